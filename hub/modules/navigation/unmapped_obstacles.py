"""What has held the robot up where the map shows nothing, so that ways lead round it; pure.

Sonars do not see smooth walls that they meet at a slant, so a map has holes where walls are. The
robot sees such a wall when it stands before it, and would stand there until the goal is given up.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from hub.grids.grid import Grid

HELD_S = 1.0
"""Who looks where it wants to go, and does not go for this time, is held up [s]."""
REMEMBERED_S = 45.0
"""So long a way is planned round what has held the robot up [s]."""
WIDER = 0.05
"""So much farther a way keeps from what has held the robot up than from what the map shows [m]:
the ways that the pilot takes at corners are not as sharp as those on the map."""
_MOST = 2000
"""So many points are remembered; the oldest go first."""
_OCCUPIED = 100

Floats = npt.NDArray[np.float64]


class UnmappedObstacles:
    """Points in `map`; every method gets the present monotonic time [s]."""

    def __init__(self) -> None:
        self._points: Floats = np.empty((0, 3))
        self._held_since = math.inf

    def held(self, *, still: bool, now: float) -> bool:
        """Whether the robot is held up now; true once for each HELD_S.

        Args:
            still: Whether it looks where it wants to go, and does not go.
            now: The time.
        """
        if not still:
            self._held_since = math.inf
            return False
        self._held_since = min(self._held_since, now)
        if now - self._held_since < HELD_S:
            return False
        self._held_since = now
        return True

    def note(self, x: Floats, y: Floats, now: float) -> None:
        """Remember what is in the way, in `map` [m], shapes (n,)."""
        found = np.stack((x, y, np.full(len(x), now + REMEMBERED_S)), axis=1)
        self._points = np.concatenate((self._points, found))[-_MOST:]

    def forget(self) -> None:
        """Begin anew: where they leave no way, some are gone or were in another place."""
        self._points = self._points[:0]

    def onto(self, grid: Grid, now: float) -> Grid:
        """A map in which what is remembered is occupied, as far as it lies within."""
        self._points = self._points[self._points[:, 2] > now]
        columns = np.floor((self._points[:, 0] - grid.origin_x) / grid.resolution).astype(np.intp)
        rows = np.floor((self._points[:, 1] - grid.origin_y) / grid.resolution).astype(np.intp)
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
