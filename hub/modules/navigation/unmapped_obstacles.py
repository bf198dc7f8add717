"""Obstacles that blocked the robot and are not on the map, so that paths lead round them; pure.

Sonars do not see smooth walls at a slant, so a map has holes in walls. The robot sees such a wall
when it stands before it. Without this memory it would stand there until the task ends.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from hub.grids.grid import Grid

BLOCKED_S = 1.0
"""The robot is blocked if it faces its path and stands for this time [s]."""
REMEMBERED_S = 45.0
"""Time for which paths lead round an obstacle [s]."""
WIDER = 0.05
"""Additional distance of a path from such an obstacle [m]: the robot does not take corners as
sharply as a planned path."""
_MOST = 2000
"""Largest number of points; the oldest are dropped first."""
_OCCUPIED = 100

Floats = npt.NDArray[np.float64]


class UnmappedObstacles:
    """Points in `map`; every method gets the present monotonic time [s]."""

    def __init__(self) -> None:
        self._points: Floats = np.empty((0, 3))
        self._blocked_since = math.inf

    def blocked(self, *, still: bool, now: float) -> bool:
        """Whether the robot is blocked now; true once for each BLOCKED_S.

        Args:
            still: Whether it faces its path and stands.
            now: The time.
        """
        if not still:
            self._blocked_since = math.inf
            return False
        self._blocked_since = min(self._blocked_since, now)
        if now - self._blocked_since < BLOCKED_S:
            return False
        self._blocked_since = now
        return True

    def note(self, x: Floats, y: Floats, now: float) -> None:
        """Remember obstacles in `map` [m], shapes (n,)."""
        found = np.stack((x, y, np.full(len(x), now + REMEMBERED_S)), axis=1)
        self._points = np.concatenate((self._points, found))[-_MOST:]

    def forget(self) -> None:
        """Forget all: if they leave no path, some of them are gone or were elsewhere."""
        self._points = self._points[:0]

    def onto(self, grid: Grid, now: float) -> Grid:
        """The map with the remembered obstacles marked as occupied."""
        self._points = self._points[self._points[:, 2] > now]
        return with_obstacles(grid, self._points[:, 0], self._points[:, 1])


def with_obstacles(grid: Grid, x: Floats, y: Floats) -> Grid:
    """The map with the cells around points in `map` [m], shape (n,), marked as occupied."""
    columns = np.floor((x - grid.origin_x) / grid.resolution).astype(np.intp)
    rows = np.floor((y - grid.origin_y) / grid.resolution).astype(np.intp)
    down, right = _disc(WIDER / grid.resolution)
    rows, columns = (rows[:, None] + down).ravel(), (columns[:, None] + right).ravel()
    inside = (rows >= 0) & (rows < grid.height_cells)
    inside &= (columns >= 0) & (columns < grid.width_cells)
    if not inside.any():
        return grid
    cells = grid.cells.copy()
    cells[rows[inside], columns[inside]] = _OCCUPIED
    return dataclasses.replace(grid, cells=cells)


def _disc(radius_cells: float) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Offsets of the cells of a disc, rows and columns, shapes (n,)."""
    reach = math.floor(radius_cells)
    down, right = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    within = np.hypot(down, right) <= radius_cells
    return down[within], right[within]
