"""The colours of the view; a word or a mark repeats the meaning of each colour.

Cautions are orange, and alarms white on red. Blue and orange stay distinct for people who cannot
distinguish red and green. Every text has a contrast of at least `LEAST_CONTRAST` to its ground.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from hub.values import dataclass

Colour = tuple[int, int, int, int]
"""Red, green, blue, alpha; 0 to 255 each."""

LEAST_CONTRAST: Final = 4.5
"""Least contrast of text to its ground: WCAG 2.2, success criterion 1.4.3 (AA)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Theme:
    """One set of colours.

    Attributes:
        name: Its name.
        ink: Of values, and of words that change.
        soft: Of titles, labels and units.
        faint: Of hints, and of lines and rules.
        ground: Behind pictures, and between panes.
        panel: Behind words and gauges.
        bar: Behind lines that separate panes: the status line.
        track: The empty part of a gauge.
        accent: Of the moving part of a gauge.
        good: Colour of words without a problem.
        warning: Of words and marks of a caution.
        alarm: Behind words of an alarm.
        alarm_ink: Of words of an alarm without a ground of their own.
        on_alarm: Of words on `alarm`.
        wall: Of occupied cells of a map.
        floor: Of free cells of a map.
        unknown: Of unknown cells of a map.
        robot: Of the robot on a map.
        cone: Of the camera's field of view on a map.
        picture: Brightness of the camera's picture, 0 to 255.
        tint: Share of red, green and blue of the whole view, 0 to 255 each.
    """

    name: str
    ink: Colour
    soft: Colour
    faint: Colour
    ground: Colour
    panel: Colour
    bar: Colour
    track: Colour
    accent: Colour
    good: Colour
    warning: Colour
    alarm: Colour
    alarm_ink: Colour
    on_alarm: Colour
    wall: Colour
    floor: Colour
    unknown: Colour
    robot: Colour
    cone: Colour
    picture: int = 255
    tint: tuple[int, int, int] = (255, 255, 255)


DARK: Final = Theme(
    name="dark",
    ink=(244, 244, 244, 255),
    soft=(184, 194, 204, 255),
    faint=(142, 152, 162, 255),
    ground=(0, 0, 0, 255),
    panel=(24, 28, 34, 255),
    bar=(38, 45, 54, 255),
    track=(58, 66, 76, 255),
    accent=(80, 160, 220, 255),
    good=(120, 200, 255, 255),
    warning=(255, 176, 0, 255),
    alarm=(200, 24, 24, 255),
    alarm_ink=(255, 130, 120, 255),
    on_alarm=(255, 255, 255, 255),
    wall=(236, 232, 220, 255),
    floor=(74, 84, 98, 255),
    unknown=(16, 19, 24, 255),
    robot=(90, 200, 255, 255),
    cone=(150, 170, 90, 255),
)
LIGHT: Final = Theme(
    name="light",
    ink=(12, 14, 18, 255),
    soft=(58, 64, 72, 255),
    faint=(88, 94, 102, 255),
    ground=(255, 255, 255, 255),
    panel=(234, 237, 240, 255),
    bar=(214, 220, 226, 255),
    track=(196, 203, 210, 255),
    accent=(20, 100, 170, 255),
    good=(0, 84, 150, 255),
    warning=(140, 76, 0, 255),
    alarm=(190, 16, 16, 255),
    alarm_ink=(168, 10, 10, 255),
    on_alarm=(255, 255, 255, 255),
    wall=(20, 22, 26, 255),
    floor=(255, 255, 255, 255),
    unknown=(176, 182, 190, 255),
    robot=(0, 96, 190, 255),
    cone=(214, 180, 60, 255),
)
RED: Final = Theme(
    name="red",
    ink=(255, 255, 255, 255),
    soft=(242, 242, 242, 255),
    faint=(228, 228, 228, 255),
    ground=(0, 0, 0, 255),
    panel=(20, 20, 20, 255),
    bar=(36, 36, 36, 255),
    track=(72, 72, 72, 255),
    accent=(225, 225, 225, 255),
    good=(240, 240, 240, 255),
    warning=(255, 255, 255, 255),
    alarm=(255, 255, 255, 255),
    alarm_ink=(255, 255, 255, 255),
    on_alarm=(0, 0, 0, 255),
    wall=(255, 255, 255, 255),
    floor=(96, 96, 96, 255),
    unknown=(14, 14, 14, 255),
    robot=(255, 255, 255, 255),
    cone=(150, 150, 150, 255),
    picture=150,
    tint=(255, 76, 52),
)
"""Red keeps eyes adapted to the dark; this theme uses no hue to distinguish things."""

THEMES: Final[Mapping[str, Theme]] = {theme.name: theme for theme in (DARK, LIGHT, RED)}
RENAMED: Final[Mapping[str, str]] = {"night": RED.name}
"""Older names of themes in layouts; "night" is now the camera's night mode."""
