"""The bar that pan and tilt share: centred on the angle, as long as the field of view."""

from __future__ import annotations

import enum
import math
from typing import Final

from rune_tui.raster.canvas import Canvas, Colour
from rune_tui.raster.shapes import drawing
from rune_tui.visualizers.palette import PANEL
from rune_tui.visualizers.staleness import mark_age, weather

_BAR: Final[Colour] = (80, 160, 220, 255)
_CENTRE_ON_BAR: Final[Colour] = (255, 255, 255, 255)


class Direction(enum.Enum):
    """Which way the bar runs: positive angles are left or up."""

    ACROSS = "across"
    UPWARD = "upward"


def draw_angle_bar(
    canvas: Canvas,
    direction: Direction,
    *,
    angle: float,
    field_of_view: float,
    limit: float,
    age: float,
) -> None:
    """Draw where the camera looks within all that it can see.

    Args:
        canvas: Its whole length stands for -(limit + field_of_view / 2) to the positive same.
        direction: Which way the bar runs.
        angle: Pan or tilt [rad], positive left or up.
        field_of_view: Seen at once in that direction, after zoom [rad].
        limit: Largest pan or tilt [rad].
        age: How old the angle is [s].
    """
    canvas.fill(PANEL)
    across = direction is Direction.ACROSS
    length = canvas.width if across else canvas.height
    whole = 2.0 * limit + field_of_view
    if not (math.isfinite(angle) and math.isfinite(whole) and whole > 0.0):
        return
    low, high = bar_span(length, angle / whole, field_of_view / whole)
    middle = (length - 1) // 2, length // 2 + 1
    with drawing(canvas) as pen:
        for (start, end), colour in (((low, high), _BAR), (middle, _CENTRE_ON_BAR)):
            if across:
                pen.rectangle(start, 0, end, canvas.height, colour)
            else:
                pen.rectangle(0, start, canvas.width, end, colour)
    weather(canvas, age)
    mark_age(canvas, age)


def bar_span(length: int, offset: float, share: float) -> tuple[int, int]:
    """First and one past last pixel of the bar, counted from the left or the top.

    Args:
        length: Whole length [pixels].
        offset: Angle as a share of the whole, positive left or up, -0.5 to 0.5.
        share: Field of view as a share of the whole.
    """
    size = min(length, max(1, round(share * length)))
    start = round((0.5 - offset) * length - size / 2.0)
    start = max(0, min(length - size, start))
    return start, start + size
