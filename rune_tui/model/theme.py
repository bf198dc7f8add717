"""The colours of everything that is drawn; whatever a colour says is also said by a word or a mark.

Warnings are orange, and alarms white on red: blue against orange stays distinct for people who do
not tell red from green.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

Colour = tuple[int, int, int, int]
"""Red, green, blue, alpha; 0 to 255 each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Theme:
    """One set of colours.

    Attributes:
        name: Its name.
        ink: Of words.
        faint: Of words and lines that matter less.
        ground: Behind pictures.
        panel: Behind words and gauges.
        accent: Of what moves in a gauge.
        good: Of words that all is well.
        warning: Of words and marks of what needs a look.
        alarm: Behind words of what needs a hand.
        alarm_ink: Of such words where nothing is behind them.
        on_alarm: Of words on `alarm`.
        tint: What is left of red, green and blue of the whole picture, 0 to 255 each.
    """

    name: str
    ink: Colour
    faint: Colour
    ground: Colour
    panel: Colour
    accent: Colour
    good: Colour
    warning: Colour
    alarm: Colour
    alarm_ink: Colour
    on_alarm: Colour
    tint: tuple[int, int, int] = (255, 255, 255)


DARK: Final = Theme(
    name="dark",
    ink=(240, 240, 240, 255),
    faint=(140, 150, 160, 255),
    ground=(0, 0, 0, 255),
    panel=(24, 28, 34, 255),
    accent=(80, 160, 220, 255),
    good=(120, 200, 255, 255),
    warning=(255, 176, 0, 255),
    alarm=(200, 24, 24, 255),
    alarm_ink=(255, 120, 110, 255),
    on_alarm=(240, 240, 240, 255),
)
LIGHT: Final = Theme(
    name="light",
    ink=(16, 18, 22, 255),
    faint=(92, 98, 106, 255),
    ground=(255, 255, 255, 255),
    panel=(232, 235, 238, 255),
    accent=(20, 100, 170, 255),
    good=(0, 84, 150, 255),
    warning=(150, 84, 0, 255),
    alarm=(190, 16, 16, 255),
    alarm_ink=(176, 12, 12, 255),
    on_alarm=(255, 255, 255, 255),
)
NIGHT: Final = Theme(
    name="night",
    ink=(240, 240, 240, 255),
    faint=(150, 150, 150, 255),
    ground=(0, 0, 0, 255),
    panel=(18, 18, 18, 255),
    accent=(180, 180, 180, 255),
    good=(210, 210, 210, 255),
    warning=(255, 220, 160, 255),
    alarm=(255, 255, 255, 255),
    alarm_ink=(255, 255, 255, 255),
    on_alarm=(0, 0, 0, 255),
    tint=(150, 34, 22),
)
"""Red keeps eyes that are used to the dark; in it nothing is told by hue."""

THEMES: Final[Mapping[str, Theme]] = {theme.name: theme for theme in (DARK, LIGHT, NIGHT)}
