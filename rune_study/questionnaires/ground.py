"""The ground that a question about a place shows: walls as half blocks, without marks and robots.

Places are in the frame `map` [m]: x to the right on the screen, y up.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hub.pose import Pose
from hub.values import dataclass
from rune_study.statistics.arrays import Flags, Floats

Place = tuple[float, float]
_BLOCKS: Final = (" ", "▄", "▀", "█")
"""By whether the upper (2) and the lower half (1) of a cell of the terminal has a wall."""


@dataclass(frozen=True, kw_only=True)
class Ground:
    """Walls as cells of a grid.

    Attributes:
        walls: Cells with a wall, shape (height, width), row 0 at the least y of the grid.
        resolution: Edge of a cell [m].
        origin_x: Lower left corner of cell (0, 0) in the grid's frame [m].
        origin_y: Lower left corner of cell (0, 0) in the grid's frame [m].
        frame: The frame `map` in the grid's frame.
    """

    walls: Flags
    resolution: float
    origin_x: float = 0.0
    origin_y: float = 0.0
    frame: Pose = Pose()

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Least x, least y, greatest x and greatest y of the grid in `map` [m]."""
        height, width = self.walls.shape
        corners = [
            self.frame.inward(
                self.origin_x + column * self.resolution, self.origin_y + row * self.resolution
            )
            for column in (0, width)
            for row in (0, height)
        ]
        x, y = zip(*corners, strict=True)
        return min(x), min(y), max(x), max(y)

    def has_wall(self, x: Floats, y: Floats) -> Flags:
        """Whether there is a wall at places in `map` [m], of any shape; none outside the grid."""
        across, up = self.frame.outward(x, y)
        column = np.floor((across - self.origin_x) / self.resolution).astype(int)
        row = np.floor((up - self.origin_y) / self.resolution).astype(int)
        height, width = self.walls.shape
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        found: Flags = np.zeros(np.shape(x), bool)
        found[inside] = self.walls[row[inside], column[inside]]
        return found

    def surfaces(self) -> Floats:
        """Middles of all cells with a wall in `map` [m] (n, 2)."""
        cells = np.argwhere(self.walls).astype(np.float64) + 0.5
        x = self.origin_x + cells[:, 1] * self.resolution
        y = self.origin_y + cells[:, 0] * self.resolution
        return np.stack(self.frame.inward(x, y), axis=-1)


@dataclass(frozen=True, kw_only=True)
class Picture:
    """The ground on the screen: a character is one pixel wide and two high.

    Attributes:
        lines: The characters.
        left: Least x of the first column [m].
        top: Greatest y of the first line [m].
        scale: Edge of a pixel [m].
    """

    lines: tuple[str, ...]
    left: float
    top: float
    scale: float

    def place(self, column: int, line: int) -> Place | None:
        """The place in the middle of a character [m]; None: it is none of the picture."""
        if not (0 <= line < len(self.lines) and 0 <= column < len(self.lines[0])):
            return None
        return self.left + (column + 0.5) * self.scale, self.top - (2 * line + 1) * self.scale

    def character(self, place: Place) -> tuple[int, int]:
        """Column and line of the character that shows a place, or that is nearest to it."""
        column = math.floor((place[0] - self.left) / self.scale)
        line = math.floor((self.top - place[1]) / (2.0 * self.scale))
        return (
            min(max(column, 0), len(self.lines[0]) - 1),
            min(max(line, 0), len(self.lines) - 1),
        )


def picture_of(ground: Ground, columns: int, lines: int) -> Picture:
    """The ground, as large as it fits into columns and lines; a thin wall stays visible."""
    left, low, right, top = ground.bounds
    scale = max((right - left) / max(1, columns), (top - low) / max(1, 2 * lines))
    across = max(1, math.ceil((right - left) / scale - 1e-9))
    down = max(1, math.ceil((top - low) / (2.0 * scale) - 1e-9))
    x = left + (np.arange(across) + 0.5) * scale
    y = top - (np.arange(2 * down) + 0.5) * scale
    pixels = ground.has_wall(*np.meshgrid(x, y))
    walls = ground.surfaces()
    column = np.clip(np.floor((walls[:, 0] - left) / scale), 0, across - 1).astype(int)
    row = np.clip(np.floor((top - walls[:, 1]) / scale), 0, 2 * down - 1).astype(int)
    pixels[row, column] = True
    halves = 2 * pixels[0::2].astype(int) + pixels[1::2]
    rows = tuple("".join(_BLOCKS[each] for each in row) for row in halves.tolist())
    return Picture(lines=rows, left=left, top=top, scale=scale)
