"""What share of the ground that the robot can reach was ever seen.

All masks are rows and columns of a grid of the true arena: row 0 at the smallest y, column 0 at the
smallest x.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.grids.clearance import clearance
from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.statistics.arrays import Flags, Floats, floats

FARTHEST_M = 3.0
"""Ground farther away does not count as seen [m]."""
_STEP = 0.5
"""Steps along a line of sight [cells]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrueGrid:
    """The true arena as cells.

    Attributes:
        blocked: Cells that a robot cannot enter nor see through, shape (height, width).
        resolution: Edge of a cell [m].
        origin_x: Least x [m].
        origin_y: Least y [m].
    """

    blocked: Flags
    resolution: float
    origin_x: float = 0.0
    origin_y: float = 0.0

    def cells(self, x: npt.ArrayLike, y: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Places [m] as rows and columns; whole numbers are the lower edges of cells."""
        return (
            (np.asarray(y, np.float64) - self.origin_y) / self.resolution,
            (np.asarray(x, np.float64) - self.origin_x) / self.resolution,
        )

    def holds(self, row: float, column: float) -> bool:
        """Whether a row and column lie in the grid."""
        height, width = self.blocked.shape
        return bool(0 <= row < height and 0 <= column < width)


def standing(grid: TrueGrid, radius: float) -> Flags:
    """Cells on which a round robot fits: no blocked cell's middle is nearer than its radius.

    Args:
        grid: The arena; outside it nothing is blocked.
        radius: Of the robot [m].
    """
    if radius <= 0.0:
        return ~grid.blocked
    away = clearance(grid.blocked, grid.resolution, radius + grid.resolution)
    return ~grid.blocked & (away >= np.float32(radius))


def reachable(grid: TrueGrid, start: tuple[float, float], radius: float) -> Flags:
    """Cells that a round robot can reach with its middle, over the sides of cells.

    Args:
        grid: The arena.
        start: Where it starts [m].
        radius: Of the robot [m].

    Returns:
        None of them if it does not fit where it starts.

    Raises:
        DataError: The start lies outside the grid.
    """
    row, column = (math.floor(float(each)) for each in grid.cells(*start))
    if not grid.holds(row, column):
        text = f"the start ({start[0]:g}, {start[1]:g}) lies outside the arena"
        raise DataError(text)
    open_cells = np.pad(standing(grid, radius), 1)
    reached = np.zeros_like(open_cells)
    front = np.zeros_like(open_cells)
    front[row + 1, column + 1] = open_cells[row + 1, column + 1]
    while front.any():
        reached |= front
        grown = np.zeros_like(front)
        grown[1:] |= front[:-1]
        grown[:-1] |= front[1:]
        grown[:, 1:] |= front[:, :-1]
        grown[:, :-1] |= front[:, 1:]
        front = grown & open_cells & ~reached
    inner: Flags = reached[1:-1, 1:-1]
    return inner


def seen_cells(
    grid: TrueGrid,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    heading: npt.ArrayLike,
    *,
    width: float,
    farthest: float = FARTHEST_M,
) -> Flags:
    """Cells that a camera saw: within its wedge, near enough, and in line of sight.

    Args:
        grid: The arena.
        x: Places of the camera [m], shape (n,).
        y: The same.
        heading: Directions of its axis, counter-clockwise from x [rad], shape (n,).
        width: Horizontal field of view [rad].
        farthest: Ground farther away is not seen [m].
    """
    rows, columns = grid.cells(floats(x, "x"), floats(y, "y"))
    axes = floats(heading, "heading")
    usable = np.isfinite(rows) & np.isfinite(columns) & np.isfinite(axes)
    reach = farthest / grid.resolution
    rays = max(2, math.ceil(width * reach / _STEP) + 1)
    angles = np.linspace(-0.5 * width, 0.5 * width, rays)
    away = np.arange(0.0, reach + 1e-9, _STEP)[:, None]
    free = np.pad(~grid.blocked, 1)  # outside is out of sight
    height, across = grid.blocked.shape
    seen = np.zeros_like(free)
    for row, column, axis in np.column_stack((rows, columns, axes))[usable].tolist():
        at_rows = np.clip(np.floor(row + away * np.sin(axis + angles)), -1, height).astype(np.intp)
        at_columns = np.clip(np.floor(column + away * np.cos(axis + angles)), -1, across)
        cells = at_rows + 1, at_columns.astype(np.intp) + 1
        in_sight = np.logical_and.accumulate(free[cells], axis=0)
        seen[cells[0][in_sight], cells[1][in_sight]] = True
    inner: Flags = seen[1:-1, 1:-1]
    return inner


def coverage(seen: npt.ArrayLike, within: npt.ArrayLike) -> float:
    """Share of the reachable cells that were seen; NaN if none is reachable.

    Args:
        seen: Cells that were seen or mapped, shape (height, width).
        within: Cells that the robot can reach, the same shape.

    Raises:
        DataError: The shapes differ.
    """
    first, second = np.asarray(seen, bool), np.asarray(within, bool)
    if first.shape != second.shape:
        text = f"masks of one grid have one shape, not {first.shape} and {second.shape}"
        raise DataError(text)
    total = int(second.sum())
    return int((first & second).sum()) / total if total else math.nan
