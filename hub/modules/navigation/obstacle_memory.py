"""Recent points of range sensors and bumpers around the robot, in `odom`; pure.

A ring of sensors sees little at once: one scan misses a table's leg between two rays, and the next
one sees it. So points are remembered, in the cells of a small grid that moves with the robot. A
point is forgotten when several rays have passed through it, after some seconds, or when it is some
metres away. `beam_rules` says what each kind of beam shows.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from hub.gcm.beam_scans import BeamScan
from hub.gcm.body import Bumper, RobotBody
from hub.gcm.navigation import DriveState
from hub.gcm.outline import exits
from hub.modules.navigation.beam_rules import LONGEST_ARC, RIM, BeamRules
from hub.pose import Pose, each_wrapped, wrapped

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

RESOLUTION = 0.03
"""Edge of a cell [m]; one point is remembered in each."""
LEAST_CELLS = 128
"""Least number of cells along each edge of the grid, which is 3.84 m wide then."""
RAY_S = 20.0
"""Life of a point of a narrow beam [s]: drift of the odometry stays below 10 cm."""
CONE_S = 2.0
"""Life of a point of a cone [s]; its place within the cone is not known."""
GUESS_S = 1.0
"""Life of an assumed point [s]."""
BUMP_S = 20.0
"""Life of a point of a bumper [s]."""

_CLEARED_BY = 3
"""Number of scans through a point after which it is forgotten."""
_BESIDE = 0.01
"""A ray within this distance of a point would have met it [m]; it removes an assumed point."""
_BEFORE = 0.10
"""The last part of a ray clears nothing [m]."""
_SPREAD: Floats = np.array((-1.0, -0.5, 0.0, 0.5, 1.0)) / 3.0
"""Bearings of assumed obstacles on the arc of an echo, as shares of its cone; its middle is the
likely part."""
_EXPLAINS = 0.12
"""A remembered point within this angle of a ray [rad] explains its hit."""
_EXPLAINS_FAR = 0.02
"""It may be farther away than what the ray cannot measure by this [m]."""
_CORNER = 0.8
"""Distance of an edge between two rays, as a share of the nearer range: a surface that a ray meets
at 45 degrees has this distance 18 degrees beside the ray."""
_CORNER_FAR = 0.7
"""Edges beside rays with a longer range than this [m] are left out."""
_BUMPER_PIECE = 0.1
"""A bumper longer than this [m] is several points."""
_GUESSES = 512
_GUESSED_AT_ONCE = 256
"""Largest number of assumed points of one scan: one for each 1.4 degrees around."""
_MOVING = 0.1
"""From this velocity on [m/s] points age in real time."""
_TURNING = 0.2
"""From this turn rate on [rad/s] too."""
_STANDING = 0.1
"""Share of real time at which points age while the robot stands."""


class ObstacleMemory:
    """Remembers points; every method gets the present monotonic time [s]."""

    def __init__(
        self, body: RobotBody, rules: BeamRules, reach: float, silent: Flags | None = None
    ) -> None:
        """Remember nothing yet.

        Args:
            body: The body, which has the bumpers.
            rules: What its beams show.
            reach: Farthest point of interest [m].
            silent: Which beams are silent now, so that their last ranges do not count, shape (n,);
                the caller changes it. None: none ever is.
        """
        self._rules = rules
        self._edge_cells = max(LEAST_CELLS, 2 * math.ceil(reach / RESOLUTION))
        self._farthest = 0.5 * self._edge_cells * RESOLUTION
        self._bumpers = [_bumper_points(body, bumper) for bumper in body.bumpers]
        shape = (self._edge_cells**2,)
        self._x = np.zeros(shape)
        self._y = np.zeros(shape)
        self._until = np.full(shape, -np.inf)
        self._looked_through = np.zeros(shape, dtype=np.int64)
        self._guessed_x = np.zeros(_GUESSES)
        self._guessed_y = np.zeros(_GUESSES)
        self._guessed_until = np.full(_GUESSES, -np.inf)
        self._guesses = 0
        self._time = 0.0
        self._last: tuple[Pose, float] | None = None
        self._looked = {sparse: (Pose(), -math.inf) for sparse in (True, False)}
        self._ranges: Floats = np.full(len(rules.narrow), np.nan)
        self._silent = np.zeros(len(rules.narrow), np.bool_) if silent is None else silent

    def moved(self, drive: DriveState, now: float) -> None:
        """Take the pose and the bumpers."""
        pose = Pose(x=drive.x, y=drive.y, theta=drive.theta)
        self._age(pose, now)
        # The thin rays of a ring sweep over the ground between two measurements.
        self._look_through(pose, self._rules.sparse, now)
        for number, (x, y) in enumerate(self._bumpers):
            if drive.bumpers >> number & 1:
                self._meet(pose, x, y, self._time + BUMP_S)

    def scanned(self, scan: BeamScan, now: float) -> None:
        """Take new ranges."""
        if self._silent.any():
            scan = dataclasses.replace(scan, ranges=np.where(self._silent, np.nan, scan.ranges))
        self._ranges = scan.ranges
        for which in (self._rules.sparse, scan.fresh & ~self._rules.sparse):
            self._look_through(scan.pose, which, now)
        rules, beams = self._rules, self._rules.beams
        met = scan.fresh & (scan.ranges > rules.blind) & (scan.ranges < self._farthest)
        arcs = np.flatnonzero(met & ~rules.narrow)
        arcs = arcs[scan.ranges[arcs] * beams.opening[arcs] < LONGEST_ARC]
        aside = (beams.opening[arcs][:, None] * _SPREAD).ravel()
        arcs = np.repeat(arcs, len(_SPREAD))
        self._meet(scan.pose, *beams.hits(arcs, scan.ranges, aside), self._time + CONE_S)
        rays = np.flatnonzero(met & rules.narrow)
        self._meet(scan.pose, *beams.hits(rays, scan.ranges), self._time + RAY_S)
        self._assume(scan)

    def forget(self) -> None:
        """Forget all points."""
        self._until[:] = self._guessed_until[:] = -np.inf

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

    def _meet(self, pose: Pose, ahead: Floats, left: Floats, until: float) -> None:
        """Remember points in `base_link` [m], shape (k,)."""
        # Among several points of a cell the one nearest to the robot comes last, so it stays.
        order = np.argsort(-np.hypot(ahead, left), kind="stable")
        x, y = pose.outward(ahead[order], left[order])
        cells = self._cells(x, y)
        # The grid repeats, so a cell stands for many places; the newest one counts.
        moved = np.hypot(self._x[cells] - x, self._y[cells] - y) > 2.0 * RESOLUTION
        self._until[cells[moved]] = -np.inf
        self._x[cells], self._y[cells] = x, y
        self._until[cells] = np.maximum(self._until[cells], until)
        self._looked_through[cells] = 0

    def _cells(self, x: Floats, y: Floats) -> npt.NDArray[np.int64]:
        """The cells of points in the grid, which repeats; shape (k,)."""
        column = np.floor(x / RESOLUTION).astype(np.int64) % self._edge_cells
        row = np.floor(y / RESOLUTION).astype(np.int64) % self._edge_cells
        return row * self._edge_cells + column

    def _assume(self, scan: BeamScan) -> None:
        """Assume points where an obstacle may be that the sensors cannot show.

        A beam can report "too near to measure". An echo or a remembered point that is as near
        explains it; if there is none, a point is assumed at the rim. If a ray has a hit and no
        sonar has an echo, the surface is slanted. Then it may come nearer between this ray and
        the next, as the edge of a box does, by about a fifth.
        """
        rules, beams, pose, ranges = self._rules, self._rules.beams, scan.pose, scan.ranges
        cones = ranges[rules.cones]
        blind = np.flatnonzero(ranges <= rules.blind)
        if len(blind):
            reach = rules.blind[blind][:, None] + _EXPLAINS_FAR
            hidden = blind[~self._shows(pose, blind, reach)]
            self._guess(pose, *beams.hits(hidden, rules.rim + RIM))
        gaps = rules.gaps
        if not len(gaps.one):
            return
        nearer = np.fmin(ranges[gaps.one], ranges[gaps.other])
        echoes = gaps.echoes & (cones <= nearer[:, None] + 0.05)
        corner = np.flatnonzero((nearer < _CORNER_FAR) & ~echoes.any(axis=1))
        away = np.maximum(_CORNER * nearer[corner], gaps.rim[corner] + RIM)
        numbers, bearing = gaps.one[corner], gaps.bearing[corner]
        x = beams.x[numbers] + away * np.cos(bearing)
        self._guess(pose, x, beams.y[numbers] + away * np.sin(bearing))

    def _shows(self, pose: Pose, numbers: npt.NDArray[np.intp], reach: Floats) -> Flags:
        """Whether remembered points lie before beams, within a reach [m], shape (k, 1)."""
        beams = self._rules.beams
        origins = np.hypot(beams.x[numbers], beams.y[numbers])
        x, y = self.points(pose.x, pose.y, pose.theta, float((reach[:, 0] + origins).max()))
        to_x, to_y = x - beams.x[numbers, None], y - beams.y[numbers, None]
        off = np.abs(each_wrapped(np.arctan2(to_y, to_x) - beams.bearing[numbers, None]))
        return np.asarray(((off < _EXPLAINS) & (np.hypot(to_x, to_y) <= reach)).any(axis=1))

    def _guess(self, pose: Pose, ahead: Floats, left: Floats) -> None:
        """Assume points in `base_link` [m], shape (k,)."""
        # Of the many beams of a covered laser, some all around stay.
        every = -(-len(ahead) // _GUESSED_AT_ONCE) or 1
        x, y = pose.outward(ahead[::every], left[::every])
        places = (self._guesses + np.arange(len(x))) % _GUESSES
        self._guesses += len(x)
        self._guessed_x[places], self._guessed_y[places] = x, y
        self._guessed_until[places] = self._time + GUESS_S

    def _age(self, pose: Pose, now: float) -> None:
        """Let points age, but slowly while the robot stands.

        The sensors may not see the obstacle before which it stands. If it were forgotten while
        the operator pushes the stick, the robot would drive into it.
        """
        if self._last is not None:
            before, then = self._last
            way = math.hypot(pose.x - before.x, pose.y - before.y) / _MOVING
            turn = abs(wrapped(pose.theta - before.theta)) / _TURNING
            passed = max(now - then, 0.0)
            self._time += min(passed, _STANDING * passed + way + turn)
        self._last = pose, now

    def _look_through(self, pose: Pose, which: Flags, now: float) -> None:
        """Count the beams through each point, and forget points with enough of them.

        Args:
            pose: The robot's pose.
            which: The beams, shape (n,).
            now: Monotonic time [s].
        """
        sparse = which is self._rules.sparse
        if not which.any() or not _elsewhere(pose, now, *self._looked[sparse]):
            return
        self._looked[sparse] = pose, now
        free = np.where(np.isinf(self._ranges), self._rules.sure, self._ranges - _BEFORE)
        free[~which | self._silent] = 0.0
        held = np.flatnonzero(self._until > self._time)
        x, y = pose.inward(self._x[held], self._y[held])
        seen = held[self._passed(free, x, y)]
        self._looked_through[seen] += 1
        self._until[seen[self._looked_through[seen] >= _CLEARED_BY]] = -np.inf
        self._until[held[np.hypot(x, y) > self._farthest]] = -np.inf
        guessed = np.flatnonzero(self._guessed_until > self._time)
        x, y = pose.inward(self._guessed_x[guessed], self._guessed_y[guessed])
        self._guessed_until[guessed[self._passed(free, x, y)]] = -np.inf

    def _passed(self, free: Floats, x: Floats, y: Floats) -> Flags:
        """Whether a beam of light passed each point in `base_link` [m], shape (k,).

        Args:
            free: The free length of each beam [m], shape (n,).
            x: The points, shape (k,).
            y: The same.
        """
        passed = np.zeros(len(x), dtype=np.bool_)
        for group in self._rules.light:
            if not (free[group.place] > 0.0).any():
                continue
            to_x, to_y = x - group.x, y - group.y
            along = (np.arctan2(to_y, to_x) - group.first) * math.copysign(1.0, group.step)
            number = np.rint(along % math.tau / abs(group.step)).astype(np.intp)
            number[number >= group.place.stop - group.place.start] = 0
            number += group.place.start
            bearing = self._rules.beams.bearing[number]
            ahead, left = np.cos(bearing), np.sin(bearing)
            way, off = to_x * ahead + to_y * left, np.abs(to_y * ahead - to_x * left)
            passed |= (off < _BESIDE) & (way > 0.0) & (way < free[number])
        return passed


def _bumper_points(body: RobotBody, bumper: Bumper) -> tuple[Floats, Floats]:
    """Points on the outline that a bumper covers, in `base_link` [m], shape (k,)."""
    count = 1 + int(bumper.width * body.radius / _BUMPER_PIECE)
    middles = (np.arange(count) + 0.5) / count - 0.5
    bearing = bumper.direction + bumper.width * middles
    away = exits(body, np.zeros(count), np.zeros(count), bearing)
    return away * np.cos(bearing), away * np.sin(bearing)


def _elsewhere(pose: Pose, now: float, before: Pose, then: float) -> bool:
    """Whether beams from here, or now, can clear points that the last ones could not."""
    return (
        math.hypot(pose.x - before.x, pose.y - before.y) > 0.01
        or abs(wrapped(pose.theta - before.theta)) > 0.02
        or now - then > 1.0
    )
