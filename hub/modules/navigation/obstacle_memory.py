"""Recent points of range sensors and bumpers around the robot, in `odom`; pure.

Sixteen thin rays and sixteen cones see little at once: one scan misses a table's leg between two
rays, and the next one sees it. So points are remembered, in the cells of a small grid that moves
with the robot. A point is forgotten when several rays have passed through it, after some seconds,
or when it is some metres away.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.navigation import SENSOR_COUNT, DriveState
from hub.pose import Pose, each_wrapped, wrapped

Floats = npt.NDArray[np.float64]

RESOLUTION = 0.03
"""Edge of a cell [m]; one point is remembered in each."""
CELLS = 128
"""Cells along each edge of the grid, which is 3.84 m wide."""
RAY_S = 20.0
"""Life of a point of a thin ray [s]: drift of the odometry stays below 10 cm."""
CONE_S = 2.0
"""Life of a point of a cone [s]; its place within the cone is not known."""
GUESS_S = 1.0
"""Life of an assumed point [s]."""
BUMP_S = 20.0
"""Life of a point of a bumper [s]."""

_CLEARED_BY = 3
"""Number of scans through a point after which it is forgotten."""
_BESIDE = 0.01
"""A ray within this distance of a point would have met it [m]."""
_BESIDE_GUESS = 0.01
"""The same for an assumed point, which one ray removes [m]."""
_BEFORE = 0.10
"""The last part of a ray clears nothing [m]."""
_SURE = 0.40
"""An infrared ray without a hit is free for this length [m], also before dark surfaces."""
_CONE_FAR = 1.5
"""Echoes from farther away are not used: their arc is too wide [m]."""
_CONE_SPREAD: Floats = np.radians((-9.0, -4.5, 0.0, 4.5, 9.0))
"""Bearings of assumed obstacles on the arc of an echo [rad]; its middle is the likely part."""
_BLIND = 0.103
"""An infrared sensor cannot measure distances to the rim below this [m]."""
_EXPLAINS = 0.12
"""A remembered point within this angle of a ray [rad] explains its hit."""
_CORNER = 0.8
"""Distance of an edge between two rays, as a share of the nearer range: a surface that a ray meets
at 45 degrees has this distance 18 degrees beside the ray."""
_CORNER_FAR = 0.7
"""Edges beside rays with a longer range than this [m] are left out."""
_RIM = 0.005
"""Assumed distance of a point at the rim from it [m]."""
_GUESSES = 512
_ASSUME_S = 0.1
"""Guesses are renewed after this time while the ranges do not change [s]."""
_MOVING = 0.1
"""From this velocity on [m/s] points age in real time."""
_TURNING = 0.2
"""From this turn rate on [rad/s] too."""
_STANDING = 0.1
"""Share of real time at which points age while the robot stands."""
_AXES: Floats = np.arange(SENSOR_COUNT, dtype=np.float64) * (2.0 * math.pi / SENSOR_COUNT)


class ObstacleMemory:
    """Remembers points; every method gets the present monotonic time [s]."""

    def __init__(self, radius: float) -> None:
        self._radius = radius
        shape = (CELLS * CELLS,)
        self._x = np.zeros(shape)
        self._y = np.zeros(shape)
        self._until = np.full(shape, -np.inf)
        self._looked_through = np.zeros(shape, dtype=np.int64)
        self._guessed_x = np.zeros(_GUESSES)
        self._guessed_y = np.zeros(_GUESSES)
        self._guessed_until = np.full(_GUESSES, -np.inf)
        self._guesses = 0
        self._assume_at = -math.inf
        self._time = 0.0
        self._last: tuple[DriveState, float] | None = None
        self._looked: tuple[DriveState, float] | None = None
        self._sonar = np.full(SENSOR_COUNT, np.nan, dtype=np.float32)
        self._infrared = np.full(SENSOR_COUNT, np.nan, dtype=np.float32)

    def scanned(self, scan: DriveState, now: float) -> None:
        """Take a scan; a sensor with the same range as before has not measured again."""
        self._age(scan, now)
        fresh_infrared = scan.infrared != self._infrared
        fresh_sonar = scan.sonar != self._sonar
        self._sonar[:], self._infrared[:] = scan.sonar, scan.infrared
        if scan.bumpers:
            pressed = _AXES[[bool(scan.bumpers >> i & 1) for i in range(SENSOR_COUNT)]]
            self._meet(scan, np.full(len(pressed), self._radius), pressed, self._time + BUMP_S)
        if self._looked is None or _elsewhere(scan, now, *self._looked):
            self._looked = scan, now
            self._look_through(scan)
        fresh = bool(fresh_infrared.any() or fresh_sonar.any())
        # A driver reports more often than its sensors measure.
        if not fresh and now < self._assume_at:
            return
        self._assume_at = now + _ASSUME_S
        near = fresh_sonar & (scan.sonar < _CONE_FAR)
        ranges = np.repeat(scan.sonar[near].astype(np.float64), len(_CONE_SPREAD))
        bearings = (_AXES[near][:, None] + _CONE_SPREAD).reshape(-1)
        self._meet(scan, ranges, bearings, self._time + CONE_S)
        blind = scan.infrared <= self._radius + _BLIND
        met = fresh_infrared & np.isfinite(scan.infrared) & ~blind
        self._meet(scan, scan.infrared[met].astype(np.float64), _AXES[met], self._time + RAY_S)
        self._assume(scan, blind)

    def points(self, x: float, y: float, theta: float, reach: float) -> tuple[Floats, Floats]:
        """The points around a pose in `odom`, in `base_link` [m]; shapes (n,).

        Args:
            x: Position [m].
            y: Position [m].
            theta: Heading [rad].
            reach: Largest distance of a point from there [m].
        """
        held = np.flatnonzero(self._until > self._time)
        guessed = np.flatnonzero(self._guessed_until > self._time)
        all_x = np.concatenate((self._x[held], self._guessed_x[guessed]))
        all_y = np.concatenate((self._y[held], self._guessed_y[guessed]))
        near = np.square(all_x - x) + np.square(all_y - y) <= reach * reach
        return Pose(x=x, y=y, theta=theta).inward(all_x[near], all_y[near])

    def forget(self) -> None:
        """Forget all points."""
        self._until[:] = -np.inf
        self._guessed_until[:] = -np.inf

    def _meet(self, scan: DriveState, ranges: Floats, bearings: Floats, until: float) -> None:
        """Remember points in directions from the robot [m, rad], shape (k,)."""
        directions = bearings + scan.theta
        x = scan.x + ranges * np.cos(directions)
        y = scan.y + ranges * np.sin(directions)
        cells = _cells(x, y)
        # The grid repeats, so a cell stands for many places; the newest one counts.
        moved = np.hypot(self._x[cells] - x, self._y[cells] - y) > 2.0 * RESOLUTION
        self._until[cells[moved]] = -np.inf
        # Among several points of a cell the one nearest to the robot comes last, so it stays.
        order = np.argsort(-ranges, kind="stable")
        cells = cells[order]
        self._x[cells], self._y[cells] = x[order], y[order]
        self._until[cells] = np.maximum(self._until[cells], until)
        self._looked_through[cells] = 0

    def _assume(self, scan: DriveState, blind: npt.NDArray[np.bool_]) -> None:
        """Assume points where an obstacle may be that the sensors cannot show.

        An infrared ray can report "too near to measure". An echo or a remembered point that is as
        near explains it; if there is none, a point is assumed at the rim. If a ray has a hit and no
        sonar has an echo, the surface is slanted. Then it may come nearer between this ray and
        the next, as the edge of a box does, by about a fifth.
        """
        near = scan.sonar <= self._radius + _BLIND + 0.02
        unexplained = np.flatnonzero(blind & ~near)
        if len(unexplained):
            x, y = self.points(scan.x, scan.y, scan.theta, self._radius + _BLIND + 0.02)
            off = np.abs(each_wrapped(np.arctan2(y, x) - _AXES[unexplained][:, None]))
            known = (off < _EXPLAINS).any(axis=1) if len(x) else np.zeros(len(unexplained), bool)
            at = unexplained[~known]
            self._guess(
                scan, np.full(len(at), self._radius + _RIM), _AXES[at], self._time + GUESS_S
            )
        other = np.roll(scan.infrared, -1)
        nearer = np.minimum(scan.infrared, other)
        echo = np.minimum(scan.sonar, np.roll(scan.sonar, -1))
        corner = np.flatnonzero((nearer < _CORNER_FAR) & (echo > nearer + 0.05))
        ranges = np.maximum(_CORNER * nearer[corner], self._radius + _RIM).astype(np.float64)
        self._guess(scan, ranges, _AXES[corner] + _AXES[1] / 2.0, self._time + GUESS_S)

    def _guess(self, scan: DriveState, ranges: Floats, bearings: Floats, until: float) -> None:
        """Assume points in directions from the robot [m, rad], shape (k,)."""
        places = (self._guesses + np.arange(len(ranges))) % _GUESSES
        self._guesses += len(ranges)
        self._guessed_x[places] = scan.x + ranges * np.cos(bearings + scan.theta)
        self._guessed_y[places] = scan.y + ranges * np.sin(bearings + scan.theta)
        self._guessed_until[places] = until

    def _age(self, scan: DriveState, now: float) -> None:
        """Let points age, but slowly while the robot stands.

        The sensors may not see the obstacle before which it stands. If it were forgotten while
        the operator pushes the stick, the robot would drive into it.
        """
        if self._last is not None:
            before, then = self._last
            way = math.hypot(scan.x - before.x, scan.y - before.y) / _MOVING
            turn = abs(wrapped(scan.theta - before.theta)) / _TURNING
            passed = max(now - then, 0.0)
            self._time += min(passed, _STANDING * passed + way + turn)
        self._last = scan, now

    def _look_through(self, scan: DriveState) -> None:
        """Count the rays through each point, and forget points with enough of them."""
        held = np.flatnonzero(self._until > self._time)
        through, away = self._passed(scan, self._x[held], self._y[held], _BESIDE)
        seen = held[through]
        self._looked_through[seen] += 1
        self._until[seen[self._looked_through[seen] >= _CLEARED_BY]] = -np.inf
        self._until[held[away > CELLS * RESOLUTION / 2.0]] = -np.inf
        guessed = np.flatnonzero(self._guessed_until > self._time)
        if len(guessed):
            x, y = self._guessed_x[guessed], self._guessed_y[guessed]
            through, _ = self._passed(scan, x, y, _BESIDE_GUESS)
            self._guessed_until[guessed[through]] = -np.inf

    def _passed(
        self, scan: DriveState, x: Floats, y: Floats, beside: float
    ) -> tuple[npt.NDArray[np.bool_], Floats]:
        """Whether a ray passed each point within `beside` [m], and the points' distances [m]."""
        to_x, to_y = x - scan.x, y - scan.y
        away = np.hypot(to_x, to_y)
        bearing = np.arctan2(to_y, to_x) - scan.theta
        sensor = np.round(bearing / _AXES[1]).astype(np.int64) % SENSOR_COUNT
        free = np.where(np.isfinite(scan.infrared), scan.infrared - _BEFORE, self._radius + _SURE)[
            sensor
        ]
        off = np.abs(np.sin(bearing - _AXES[sensor])) * away
        return (off < beside) & (away < free), away


def _elsewhere(scan: DriveState, now: float, before: DriveState, then: float) -> bool:
    """Whether a scan from here, or now, can clear points that the scan before could not."""
    return (
        math.hypot(scan.x - before.x, scan.y - before.y) > 0.01
        or abs(wrapped(scan.theta - before.theta)) > 0.02
        or now - then > 1.0
    )


def _cells(x: Floats, y: Floats) -> npt.NDArray[np.int64]:
    """The cells of points in the grid, which repeats; shape (k,)."""
    column = np.floor(x / RESOLUTION).astype(np.int64) % CELLS
    row = np.floor(y / RESOLUTION).astype(np.int64) % CELLS
    return row * CELLS + column
