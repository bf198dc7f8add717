"""Corrects dead reckoning by laying laser scans onto the scans before; pure.

Iterated closest points, with the distance of a point from a line (A. Censi, An ICP variant using a
point-to-line metric, 2008). The lines are the surfaces of scans from several places nearby. Dead
reckoning since the last scan is one more measurement, so it decides where scans show nothing, such
as the way along a corridor.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import numpy.typing as npt

from hub.pose import Pose, wrapped
from hub.values import dataclass

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

FEWEST = 30
"""Least number of points near known surfaces for a match."""
LEAST_SHARE = 0.3
"""Least share of a scan's points that lie on known surfaces after a match."""
LARGEST_WAY = 0.3
"""A larger correction at once is a wrong match [m]."""
LARGEST_TURN = math.radians(15.0)
"""The same for the heading [rad]."""
FARTHEST = 12.0
"""Points farther from the robot are not used [m]: they lie too far apart."""
KEPT = 40
"""Largest number of scans that a new one is laid onto."""
NEW_PLACE = 0.5
"""A scan farther than this from the places of all kept ones is kept too [m]."""
NEW_SHARE = 0.7
"""A scan with a smaller share of its points on known surfaces is kept too."""

_MOST = 400
"""Most points of a scan that are matched."""
_NEIGHBOURS = 2
"""Number of points on each side of a point that show the direction of its surface."""
_GAP = 0.15
"""Neighbouring points of one surface are no farther apart than this [m], and a share of their
distance from the sensor."""
_GAP_STEPS = 4.5
"""This share, as a multiple of the angle between two beams."""
_FLAT = 0.12
"""Largest thickness of a surface at a point, as a share of its length there."""
_SHORTEST = 1e-6
"""Least scatter of points along a surface [m^2]."""
_CELL = 0.05
"""Edge of the cells in which surfaces are looked up [m]."""
_NEAR_CELLS = 6
"""A point belongs to no surface that is farther than this [cells]."""
_NOISE = 0.03
"""Standard deviation of points from known surfaces [m]."""
_ON_SURFACE = 2.0 * _NOISE
"""Points nearer than this lie on a surface [m]."""
_ALIKE = 4.0
"""This number of points counts as one: their errors correlate."""
_SURE = 0.015
"""Largest standard deviation of a place that a scan shows [m]."""
_ROUGH = 0.15
"""Distance of points from their surfaces in the first round [m]; each round halves it."""
_ROUNDS = 12
_FEWEST_ROUNDS = 4
_DONE_M, _DONE_RAD = 2e-4, 1e-4
_TURN_ERROR, _LEAST_TURN = 0.2, 0.004
"""Error of a turn by dead reckoning, as a share of it, and the least one [rad]."""
_WAY_ERROR, _LEAST_WAY = 0.25, 0.004
"""Error of a distance by dead reckoning, as a share of it, and the least one [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surfaces:
    """Points on surfaces; arrays of the shape (n,).

    Attributes:
        x: Position [m].
        y: Position [m].
        across_x: Unit vector across the surface; both are 0 where its direction is not known.
        across_y: The same.
    """

    x: Floats
    y: Floats
    across_x: Floats
    across_y: Floats

    def outward(self, pose: Pose) -> Surfaces:
        """Surfaces that are seen from a pose, in the pose's own frame."""
        x, y = pose.outward(self.x, self.y)
        across_x, across_y = Pose(theta=pose.theta).outward(self.across_x, self.across_y)
        return Surfaces(x=x, y=y, across_x=across_x, across_y=across_y)


def surfaces(x: Floats, y: Floats, step: float) -> Surfaces:
    """The surfaces at the points of a scan.

    Args:
        x: Points in the order of the beams [m], shape (n,); NaN: not measured.
        y: The same.
        step: Angle from a beam to the next [rad].
    """
    known = np.hypot(x, y) <= FARTHEST  # false for NaN
    x, y = np.where(known, x, np.nan), np.where(known, y, np.nan)
    count, size = len(x), 2 * _NEIGHBOURS + 1
    across = np.zeros((2, count))
    if count >= size:
        apart = np.hypot(np.diff(x), np.diff(y))
        joined = apart < _GAP + _GAP_STEPS * abs(step) * np.hypot(x, y)[1:]  # false for NaN
        one = np.lib.stride_tricks.sliding_window_view(joined, size - 1).all(axis=1)
        off_x, off_y = (
            each - each.mean(axis=1, keepdims=True)
            for each in (np.lib.stride_tricks.sliding_window_view(part, size) for part in (x, y))
        )
        xx, yy, xy = ((a * b).sum(axis=1) for a, b in ((off_x,) * 2, (off_y,) * 2, (off_x, off_y)))
        # Eigenvalues of the scatter: along the surface, and across it.
        spread = np.hypot(xx - yy, 2.0 * xy)
        long = xx + yy + spread
        flat = (xx + yy - spread <= _FLAT**2 * long) & (long > _SHORTEST)
        along = 0.5 * np.arctan2(2.0 * xy, xx - yy)
        across[:, _NEIGHBOURS : count - _NEIGHBOURS] = np.where(
            one & flat, (-np.sin(along), np.cos(along)), 0.0
        )
    return Surfaces(x=x[known], y=y[known], across_x=across[0, known], across_y=across[1, known])


class ScanMatcher:
    """Keeps scans from recent places, in a frame of its own, and lays each new scan onto them.

    Attributes:
        sure: Whether the last scan showed its place in all directions, unlike in a corridor.
        share: Share of its points that lay on known surfaces.
    """

    def __init__(self) -> None:
        self.sure = False
        self.share = 0.0
        self._odom = Pose()
        self._last = Pose()
        self._kept: deque[tuple[Pose, Surfaces]] = deque(maxlen=KEPT)
        self._lookup: _Lookup | None = None

    def matched(self, odom: Pose, seen: Surfaces) -> Pose | None:
        """Lay a scan onto those before, and keep it if its place is new.

        Args:
            odom: The robot's pose by dead reckoning at the scan.
            seen: From the robot, of the scan.

        Returns:
            The robot's real pose, seen from where dead reckoning since the last scan puts it;
            None: not known, as at the first scan.
        """
        assumed = self._odom.then(odom)
        moved, self._last = odom.seen_from(self._last), odom
        real = self._laid(assumed, seen, moved)
        error = real.seen_from(assumed) if real else Pose()
        far = math.hypot(error.x, error.y) > LARGEST_WAY or abs(error.theta) > LARGEST_TURN
        if real is None or far or self.share < LEAST_SHARE:
            self._kept.clear()
            self._keep(assumed, seen)
            return None
        self._odom = real.then(Pose().seen_from(odom))
        away = min(math.hypot(real.x - pose.x, real.y - pose.y) for pose, _ in self._kept)
        if self.share < NEW_SHARE or away > NEW_PLACE:
            self._keep(real, seen)
        return error

    def _keep(self, pose: Pose, seen: Surfaces) -> None:
        self._kept.append((pose, seen.outward(pose)))
        self._lookup = _Lookup([known for _, known in self._kept])

    def _laid(self, assumed: Pose, seen: Surfaces, moved: Pose) -> Pose | None:
        """The pose from which the points lie best on known surfaces."""
        if self._lookup is None:
            return None
        way = _LEAST_WAY + _WAY_ERROR * math.hypot(moved.x, moved.y)
        turn = _LEAST_TURN + _TURN_ERROR * abs(moved.theta)
        reckoned = np.array((way**-2, way**-2, turn**-2))
        thin = 1 + len(seen.x) // _MOST
        x, y = seen.x[::thin], seen.y[::thin]
        pose, off = assumed, np.zeros(3)
        for number in range(_ROUNDS):
            there_x, there_y = pose.outward(x, y)
            near, away, across = self._lookup.nearest(there_x, there_y)
            if len(near) < FEWEST:
                return None
            lever = across[1] * (there_x[near] - pose.x) - across[0] * (there_y[near] - pose.y)
            slopes = np.stack((*across, lever))
            scale = max(_NOISE, _ROUGH * 0.5**number)
            weights = np.square(1.0 / (1.0 + np.square(away / scale))) / (_NOISE**2 * _ALIKE)
            shown = (slopes * weights) @ slopes.T
            step = np.linalg.solve(
                shown + np.diag(reckoned),
                -(slopes * weights) @ away - reckoned * off,
            )
            off = off + step
            x_off, y_off, turned = off.tolist()
            pose = Pose(
                x=assumed.x + x_off, y=assumed.y + y_off, theta=wrapped(assumed.theta + turned)
            )
            moved_by = math.hypot(step[0], step[1])
            if moved_by < _DONE_M and abs(step[2]) < _DONE_RAD and number + 1 >= _FEWEST_ROUNDS:
                break
        self.sure = bool(np.linalg.eigvalsh(shown[:2, :2])[0] >= _SURE**-2)
        self.share = float((np.abs(away) < _ON_SURFACE).sum()) / len(x)
        return pose


class _Lookup:
    """Finds the nearest surface to a point."""

    def __init__(self, scans: list[Surfaces]) -> None:
        parts = [(each.x, each.y, each.across_x, each.across_y) for each in scans]
        points = np.concatenate([np.stack(part) for part in parts], axis=1)
        self._surfaces = points = points[:, (points[2] != 0.0) | (points[3] != 0.0)]
        border = _NEAR_CELLS + 1
        self._low = points[:2].min(axis=1, initial=math.inf) - border * _CELL
        columns, rows = ((points[:2] - self._low[:, None]) / _CELL).astype(np.intp)
        self._width = int(columns.max(initial=0)) + border + 1
        self._height = int(rows.max(initial=0)) + border + 1
        self._numbers = np.full(self._width * self._height, -1, np.int32)
        span = np.arange(-_NEAR_CELLS, _NEAR_CELLS + 1)
        aside_x, aside_y = (part.ravel() for part in np.meshgrid(span, span))
        away = np.hypot(aside_x, aside_y)
        # From far to near: the nearest surface of each cell comes last.
        order = np.argsort(-away, kind="stable")
        order = order[np.count_nonzero(away > _NEAR_CELLS) :]
        cells, number = rows * self._width + columns, np.arange(len(rows))
        for aside in (aside_y * self._width + aside_x)[order].tolist():
            self._numbers[cells + aside] = number

    def nearest(self, x: Floats, y: Floats) -> tuple[Indices, Floats, Floats]:
        """Which points have a surface near them, their distances from it [m], and its `across`."""
        columns = np.floor((x - self._low[0]) / _CELL)
        rows = np.floor((y - self._low[1]) / _CELL)
        inside = (columns >= 0) & (columns < self._width) & (rows >= 0) & (rows < self._height)
        cells = np.where(inside, rows * self._width + columns, 0.0).astype(np.intp)
        numbers = self._numbers[cells]
        near = np.flatnonzero(inside & (numbers >= 0))
        on_x, on_y, *across = self._surfaces[:, numbers[near]]
        away = across[0] * (x[near] - on_x) + across[1] * (y[near] - on_y)
        return near, away, np.stack(across)
