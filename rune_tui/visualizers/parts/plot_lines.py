"""The line of a number over time, on a canvas whose first row has words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

from hub.values import dataclass
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.visualizers.parts.history import Slot

_LABELLED_ROWS: Final = 4
HEAD: Final = 2
"""Height of the first row [pixels]."""


def limits_of(slots: Iterable[Slot]) -> tuple[float, float]:
    """Values at the lower and the upper edge, so that all slots are seen."""
    known = [*slots]
    low = min((slot.low for slot in known), default=0.0)
    high = max((slot.high for slot in known), default=0.0)
    margin = 0.0 if high > low else max(abs(low) * 0.1, 0.5)
    return low - margin, high + margin


def draw_line(
    canvas: Canvas,
    slots: Sequence[Slot],
    limits: tuple[float, float],
    span: tuple[float, float],
    theme: Theme,
) -> None:
    """Draw the line.

    Args:
        canvas: The canvas.
        slots: The values, in the order of time.
        limits: Values at the lower and the upper edge.
        span: Times at the left and the right edge [s].
        theme: The colours.
    """
    top, height = HEAD, canvas.height - HEAD
    if height < 1:
        return
    (low, high), (start, end) = limits, span

    def place(value: float) -> int:
        share = min(1.0, max(0.0, (value - low) / (high - low)))
        return top + round((1.0 - share) * (height - 1))

    with drawing(canvas) as pen:
        if low < 0.0 < high:
            pen.rectangle(0, place(0.0), canvas.width, place(0.0) + 1, theme.faint)
        before = None
        for stroke in _strokes(slots, start, canvas.width / (end - start)):
            highest, lowest = stroke.high, stroke.low
            if before is not None and stroke.joined:
                if stroke.column - before.column > 1:
                    ends = [(before.column, place(before.last))]
                    pen.line([*ends, (stroke.column, place(stroke.first))], theme.accent)
                else:
                    highest, lowest = max(highest, before.last), min(lowest, before.last)
            left = stroke.column
            pen.rectangle(left, place(highest), left + 1, place(lowest) + 1, theme.accent)
            before = stroke
        pen.rectangle(0, 0, canvas.width, top, theme.panel)


def write_limits(canvas: Canvas, limits: tuple[float, float], theme: Theme) -> None:
    """Write the limits at the left edge, if there is room."""
    low, high = (f"{limit:.3g}" for limit in limits)
    if canvas.rows >= _LABELLED_ROWS:
        canvas.text(0, 1, high, theme.ink)
        canvas.text(0, canvas.rows - 1, low, theme.ink)


@dataclass(slots=True)
class _Stroke:
    """The values in one column of pixels.

    Attributes:
        column: Which; negative left of the edge.
        first: The first value.
        last: The last one.
        low: The lowest.
        high: The highest.
        joined: Whether there is no gap before this stroke.
    """

    column: int
    first: float
    last: float
    low: float
    high: float
    joined: bool


def _strokes(slots: Iterable[Slot], start: float, scale: float) -> list[_Stroke]:
    """Slots by their columns, from a time [s] on, `scale` pixels a second."""
    strokes: list[_Stroke] = []
    for slot in slots:
        column = math.floor((slot.begin - start) * scale)
        if slot.joined and strokes and strokes[-1].column == column:
            newest = strokes[-1]
            newest.low = min(newest.low, slot.low)
            newest.high = max(newest.high, slot.high)
            newest.last = slot.last
        else:
            stroke = _Stroke(column, slot.first, slot.last, slot.low, slot.high, slot.joined)
            strokes.append(stroke)
    return strokes
