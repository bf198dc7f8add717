"""Edges of the ground on a drawing from above: dots in the alarm's colour, and the word EDGE."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import Pen, Point

WORD: Final = "EDGE"


def draw_edges(pen: Pen, spots: Sequence[Point], theme: Theme) -> None:
    """A dot at each pixel."""
    for x, y in spots:
        pen.rectangle(x - 1.0, y - 1.0, x + 1.0, y + 1.0, theme.alarm)


def write_edge(canvas: Canvas, spots: Sequence[Point], robot: Point, theme: Theme) -> None:
    """The word at the edge that is nearest to the robot's pixel."""
    inside = [(x, y) for x, y in spots if 0 <= x < canvas.width and 0 <= y < canvas.height]
    if not inside or canvas.width < len(WORD):
        return
    x, y = min(inside, key=lambda spot: np.hypot(spot[0] - robot[0], spot[1] - robot[1]))
    column = min(max(int(x) - len(WORD) // 2, 0), canvas.width - len(WORD))
    row = int(y) // 2
    canvas.pixels[2 * row : 2 * row + 2, column : column + len(WORD)] = theme.alarm
    canvas.text(column, row, WORD, theme.on_alarm)
