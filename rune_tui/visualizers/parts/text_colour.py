"""The colour of a text that a layout chooses, by its meaning in the theme."""

from __future__ import annotations

from typing import Final

from rune_tui.layout.rules import ChoiceOption
from rune_tui.model.theme import Colour, Theme

USUAL: Final = "usual"
_MEANINGS: Final = {
    "strong": "ink",
    "soft": "soft",
    "faint": "faint",
    "accent": "accent",
    "good": "good",
    "warning": "warning",
    "alarm": "alarm_ink",
}
"""Colours of a theme by their names in layouts; each has enough contrast in every theme."""
COLOUR_OPTION: Final = ChoiceOption(
    default=USUAL,
    choices=(USUAL, *_MEANINGS),
    meaning="colour of its text, by its meaning in every theme",
)


def colour_of(name: str, theme: Theme, usual: Colour) -> Colour:
    """The colour of a text.

    Args:
        name: As `COLOUR_OPTION` has it.
        theme: The present theme.
        usual: Where the layout chooses none.
    """
    found: Colour = usual if name == USUAL else getattr(theme, _MEANINGS[name])
    return found
