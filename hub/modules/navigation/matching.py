"""How far dead reckoning has drifted, told by laying what was seen lately onto the map; pure.

Correlative scan matching (E. Olson, Real-Time Correlative Scan Matching, 2009): of all small
shifts and turns of the points the one counts for which most of them lie on walls of the map, as
long as the points are not part of that map themselves.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.grids.clearance import clearance
from hub.grids.grid import Grid
from hub.plane import Pose

FEWEST = 40
"""So many points it takes."""
LEAST_SHARE = 0.5
"""So much of what is possible the points have to agree with the map in the end [share]."""

_MOST = 200
_SPREAD = 0.05
"""Standard deviation of points and walls of the map [m]."""
_CAP = 0.25
"""Farther from all walls than this [m] a point says nothing."""
_TURNS = np.radians(np.arange(-9.0, 9.1, 0.75))
_SHIFTS = np.arange(-0.15, 0.151, 0.03)
_LIKELY_TURN = math.radians(4.0)
_LIKELY_SHIFT = 0.1
_UNLIKELY = 0.02
"""What a turn or shift of the likely size costs, as a share of the points."""

Floats = npt.NDArray[np.float64]


def drift(grid: Grid, x: Floats, y: Floats, robot: Pose) -> Pose | None:
    """How the points have to be moved to lie on the walls of a map.

    Args:
        grid: The map.
        x: Points in `map`, as dead reckoning tells them [m], shape (n,).
        y: Likewise [m].
        robot: The pose around which they turn, in `map`.

    Returns:
        What leads from where the robot is thought to be to where it is, as a shift in `map` [m] and
        a turn about the robot [rad]; None: the map does not tell.
    """
    fits = _fits(grid)
    # Points on ground of which the map knows nothing say nothing.
    rows, columns = _cells(grid, x, y)
    near = fits[rows, columns] > 0.0
    x, y = x[near], y[near]
    if len(x) < FEWEST:
        return None
    if len(x) > _MOST:
        picked = np.linspace(0, len(x) - 1, _MOST).astype(np.intp)
        x, y = x[picked], y[picked]
    best, found = -math.inf, Pose()
    shift_y, shift_x = (part.ravel() for part in np.meshgrid(_SHIFTS, _SHIFTS, indexing="ij"))
    far = (shift_x**2 + shift_y**2) / _LIKELY_SHIFT**2
    along, aside = x - robot.x, y - robot.y
    for turn in _TURNS.tolist():
        turned_x, turned_y = Pose(x=robot.x, y=robot.y, theta=turn).outward(along, aside)
        rows, columns = _cells(grid, turned_x + shift_x[:, None], turned_y + shift_y[:, None])
        score = fits[rows, columns].mean(axis=1)
        score -= _UNLIKELY * (far + (turn / _LIKELY_TURN) ** 2)
        index = int(score.argmax())
        if score[index] > best:
            best = float(score[index])
            found = Pose(x=float(shift_x[index]), y=float(shift_y[index]), theta=turn)
    return found if best >= LEAST_SHARE else None


def _fits(grid: Grid) -> Floats:
    """How well a point in each cell fits a wall, 0 to 1, with a frame of cells where none does."""
    away = clearance(np.pad(grid.occupied, 1), grid.resolution, _CAP)
    fits: Floats = np.exp(-0.5 * np.square(away / _SPREAD)).astype(np.float64)
    fits[away >= _CAP - 1e-6] = 0.0
    fits[[0, -1]] = fits[:, [0, -1]] = 0.0
    return fits


def _cells(grid: Grid, x: Floats, y: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Rows and columns in the framed map; what lies outside comes into the frame."""
    rows = np.floor((y - grid.origin_y) / grid.resolution) + 1.0
    columns = np.floor((x - grid.origin_x) / grid.resolution) + 1.0
    rows = np.clip(rows, 0.0, grid.height_cells + 1.0)
    columns = np.clip(columns, 0.0, grid.width_cells + 1.0)
    return rows.astype(np.intp), columns.astype(np.intp)


class Sightings:
    """Collects what range sensors meet, in `odom`, until it is asked for."""

    SONAR_REACH = 2.0
    """Echoes from farther away than this come from too wide an arc [m]."""
    MOST_SCANS = 40

    def __init__(self) -> None:
        self._scans: list[tuple[Floats, Floats]] = []
        self._ranges: Floats = np.full(32, np.nan)

    def scanned(
        self,
        pose: Pose,
        sonar: npt.NDArray[np.float32],
        infrared: npt.NDArray[np.float32],
        blind: float,
    ) -> None:
        """Sensors have reported at a pose in `odom`.

        Args:
            pose: Where.
            sonar: Ranges [m], shape (16,).
            infrared: Likewise.
            blind: Infrared ranges up to this say nothing [m].
        """
        ranges = np.concatenate((sonar, infrared)).astype(np.float64)
        usable = (ranges != self._ranges) & np.isfinite(ranges) & (ranges > 0.0)
        usable[:16] &= ranges[:16] < self.SONAR_REACH
        usable[16:] &= ranges[16:] > blind
        self._ranges = ranges
        bearings = np.tile(np.arange(16) * (math.pi / 8.0), 2)[usable] + pose.theta
        if usable.any():
            ranges = ranges[usable]
            points = pose.x + ranges * np.cos(bearings), pose.y + ranges * np.sin(bearings)
            self._scans = [*self._scans[-self.MOST_SCANS :], points]

    def taken(self) -> tuple[Floats, Floats]:
        """What was collected [m], shapes (n,); it begins anew."""
        scans, self._scans = self._scans, []
        if not scans:
            return np.empty(0), np.empty(0)
        return np.concatenate([x for x, _ in scans]), np.concatenate([y for _, y in scans])
