"""The console's own keys, which work in every layout that does not bind them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from hub.values import dataclass
from rune_tui.layout.rules import Section
from rune_tui.model.effects import Effect, PaletteEffect, SuspendEffect, ToggleHelp, ToggleLog


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnKey:
    """A key of the console.

    Attributes:
        key: Its name in layouts.
        effect: Its effect.
        words: The same in plain words.
        section: Its section of the help.
        under_page: Whether it works under a page and leaves the page open.
        ends_page: Whether it works under a page and closes the page.
    """

    key: str
    effect: Effect
    words: str
    section: Section = Section.SCREEN
    under_page: bool = False
    ends_page: bool = False


OWN_KEYS = (
    OwnKey(key="f1", effect=ToggleHelp(), words="This help"),
    OwnKey(key="?", effect=ToggleHelp(), words="This help"),
    OwnKey(key="ctrl+e", effect=ToggleLog(), words="All messages, to read and to search"),
    OwnKey(
        key="ctrl+p",
        effect=PaletteEffect(),
        words="A list of all this, to choose from",
        ends_page=True,
    ),
    OwnKey(
        key="ctrl+z",
        effect=SuspendEffect(),
        words="Back to the shell, until fg",
        section=Section.SESSION,
        under_page=True,
    ),
)


def own_key(name: str) -> OwnKey | None:
    """The console's key of this name; None if there is none."""
    return next((each for each in OWN_KEYS if each.key == name), None)


def unbound(bound: Iterable[str]) -> Iterator[OwnKey]:
    """The console's keys that a layout does not bind."""
    taken = set(bound)
    return (each for each in OWN_KEYS if each.key not in taken)
