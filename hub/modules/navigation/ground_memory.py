"""What beams to the ground show of it, in `odom`: edges, and low obstacles; pure.

Rises count from the robot: above the plane that it stands on, and above the level through it.

| a beam meets | means |
| --- | --- |
| what rises or falls by at most a step from one of these, or lies between them | ground |
| ground beside known ground, and clearly less steep from there than the beam | ground |
| lower ground, or none | an edge, after the last known ground on its way |
| anything higher | a low obstacle |

The robot's own height follows from its way and its tilt, so that ramps keep theirs.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.beam_scans import LARGEST_TILT, BeamScan
from hub.gcm.beams import Beams
from hub.gcm.body import Freedom, RobotBody
from hub.gcm.outline import exits
from hub.gcm.ranges import too_near
from hub.modules.navigation.beam_rules import RIM
from hub.pose import Pose

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

CELL = 0.05
"""Side of a cell [m]."""
CELLS = 128
"""Cells along each side of the grid, which repeats every 6.4 m."""
MARK_S = 120.0
"""Life of an edge or a low obstacle after it was last seen [s]."""
GUESS_S = 1.0
"""The same of an edge whose place is not known [s]: it is assumed at the rim."""
FARTHEST = 3.0
"""Marks farther from the robot than this are forgotten [m]."""
EDGE_MARGIN = 0.08
"""Additional distance from edges [m]: ground near an edge may break, or be seen too late."""

_RAMP = 0.8
"""Steepest ramp, as a share of the beam's own slope: beyond an edge, hits lie on the beam."""
_ROUGH = 0.2
"""Difference of heights by noise and small debris, as a share of a step."""
_BESIDE = 4
"""Known ground counts up to this distance from a hit [cells]."""
_BEFORE = 0.7
"""Ground is before a hit if its direction differs from the beam's by 45 degrees at most."""
_SAME = 0.06
"""Ground this near to a point is ground there too [m]: the way between two scans."""
_GAP = 3
"""Known ground ends where more cells of a way are not known."""
_LEVEL = 1e-9
_LONGEST_WAY = 2.0
"""Longest way on which known ground is looked for [m]."""
_OFFSETS = tuple(part.ravel() for part in np.mgrid[-_BESIDE : _BESIDE + 1, -_BESIDE : _BESIDE + 1])
_NEXT = tuple(part.ravel() for part in np.mgrid[-1:2, -1:2])


class GroundMemory:
    """Remembers the ground around the robot; every method gets the monotonic time [s].

    Attributes:
        found: Number of edges found until now.
    """

    def __init__(self, body: RobotBody, beams: Beams, step: float) -> None:
        """Know nothing yet.

        Args:
            body: The body; the ground below one that flies or dives does not matter.
            beams: Its beams.
            step: Highest step that it drives over, up or down [m].
        """
        reach = beams.to_floor()
        looks_down = (beams.elevation < -LARGEST_TILT) & (reach < beams.farthest)
        rolls = all(motion.freedom is not Freedom.HEAVE for motion in body.motions)
        self._numbers = np.flatnonzero(looks_down & rolls)
        self._beams, self._step = beams, step
        self._ramp = _RAMP * np.abs(np.tan(beams.elevation))[self._numbers]
        self._crossing = (reach * np.cos(beams.elevation))[self._numbers]
        rim = exits(body, beams.x, beams.y, beams.bearing)[self._numbers]
        self._rim = np.minimum(rim + RIM, self._crossing)
        self._robot_z, self._at = 0.0, Pose()
        self._x, self._y, self._height = (np.full(CELLS**2, np.nan) for _ in range(3))
        self._mark_x, self._mark_y = np.zeros(CELLS**2), np.zeros(CELLS**2)
        self._mark_until = np.full(CELLS**2, -np.inf)
        self._is_edge = np.zeros(CELLS**2, dtype=np.bool_)
        self.found = 0

    def scanned(self, scan: BeamScan, now: float) -> None:
        """Take new ranges."""
        if not len(self._numbers) or scan.along is None:
            return
        beams, numbers = self._beams, self._numbers
        along = scan.along[numbers]
        along = np.where(along > beams.farthest[numbers], np.inf, along)
        near = too_near(along, beams.nearest[numbers])
        self._mark_near(scan, np.flatnonzero(near), now)
        # A range too near to measure shows no ground.
        measured = ~near & ~np.isnan(along)
        if not measured.any():
            return
        self._climb(scan)
        rise = self._rises(along, 0.0, 0.0)
        # At the end of a ramp a level floor leaves the robot's plane, and is neither of these.
        level = self._rises(along, scan.roll, scan.pitch)
        lower = measured & (np.maximum(rise, level) < -self._step)
        higher = measured & (np.minimum(rise, level) > self._step)
        hit = measured & np.isfinite(along)
        away = np.where(hit, along, 0.0) * np.cos(beams.elevation[numbers])
        x, y = self._outward(scan.pose, away)
        height = self._robot_z + level
        near = hit & ~(lower | higher)
        is_ground = near | (hit & self._continues(scan.pose, x, y, height))
        self._learn(x[near], y[near], height[near], self._step)
        self._learn(x[is_ground], y[is_ground], height[is_ground], math.inf)
        low = hit & higher & ~is_ground
        self._mark(x[low], y[low], now + MARK_S, edge=False)
        away[~hit] = math.inf
        self._mark_edges(scan.pose, np.flatnonzero(lower & ~is_ground), away, now)

    def _mark_near(self, scan: BeamScan, near: npt.NDArray[np.intp], now: float) -> None:
        """Assume low obstacles at the rim, before beams that stop above the ground.

        Args:
            scan: The ranges.
            near: Which of the beams to the ground are too near to measure, shape (m,).
            now: The time.
        """
        if not len(near):
            return
        nearest = self._beams.nearest[self._numbers]
        ends = np.minimum(
            self._rises(nearest, 0.0, 0.0), self._rises(nearest, scan.roll, scan.pitch)
        )
        above = near[ends[near] > self._step]
        x, y = self._outward(scan.pose, self._rim)
        self._mark(x[above], y[above], now + GUESS_S, edge=False)

    def points(self, x: float, y: float, theta: float, reach: float) -> tuple[Floats, Floats]:
        """What the robot must not meet, around a pose in `odom`, in `base_link` [m]; shapes (n,).

        Args:
            x: Position [m].
            y: Position [m].
            theta: Heading [rad].
            reach: Largest distance of a point from there [m].
        """
        ahead, left, edge = self._marks(Pose(x=x, y=y, theta=theta))
        away = np.hypot(ahead, left)
        nearer = 1.0 - np.where(edge, EDGE_MARGIN, 0.0) / np.maximum(away, EDGE_MARGIN)
        near = away <= reach
        return (ahead * nearer)[near], (left * nearer)[near]

    def edges(self, pose: Pose) -> tuple[Floats, Floats]:
        """The known edges around a pose in `odom`, in `base_link` [m]; shapes (n,)."""
        ahead, left, edge = self._marks(pose)
        return ahead[edge], left[edge]

    def age(self, pose: Pose, now: float) -> None:
        """Forget marks that are old, or far from a pose in `odom`."""
        away = np.hypot(self._mark_x - pose.x, self._mark_y - pose.y)
        self._mark_until[(self._mark_until < now) | (away > FARTHEST)] = -np.inf

    def _marks(self, pose: Pose) -> tuple[Floats, Floats, Flags]:
        held = np.flatnonzero(self._mark_until > -np.inf)
        return *pose.inward(self._mark_x[held], self._mark_y[held]), self._is_edge[held]

    def _climb(self, scan: BeamScan) -> None:
        """Follow the height of the robot along its way."""
        ahead, _ = scan.pose.seen_from(self._at).outward(0.0, 0.0)
        self._robot_z -= ahead * math.sin(scan.pitch)
        self._at = scan.pose

    def _rises(self, along: Floats, roll: float, pitch: float) -> Floats:
        """Height of the ends of beams [m], shape (k,): over a body that leans so, as measured."""
        height, rise = self._beams.heights(roll, pitch)
        # A body that leans far may have beams along the level, which meet no ground.
        slope = np.where(np.abs(rise) < _LEVEL, -_LEVEL, rise)[self._numbers]
        rises: Floats = height[self._numbers] + along * slope
        return rises

    def _outward(self, pose: Pose, away: Floats) -> tuple[Floats, Floats]:
        """Points on the beams in `odom` [m], seen from above; `away` has the shape (..., k)."""
        beams, numbers = self._beams, self._numbers
        bearing = beams.bearing[numbers]
        return pose.outward(
            beams.x[numbers] + away * np.cos(bearing), beams.y[numbers] + away * np.sin(bearing)
        )

    def _continues(self, pose: Pose, x: Floats, y: Floats, height: Floats) -> Flags:
        """Whether known ground is before each hit [m], and no ramp from it is too steep.

        Ground beside the beam does not count: neighbouring beams meet the far side of a hole at
        heights that differ little.
        """
        cells = _cells(x[:, None] + CELL * _OFFSETS[0], y[:, None] + CELL * _OFFSETS[1])
        to_x, to_y = x[:, None] - self._x[cells], y[:, None] - self._y[cells]
        away = np.hypot(to_x, to_y)
        bearing = pose.theta + self._beams.bearing[self._numbers, None]
        along = to_x * np.cos(bearing) + to_y * np.sin(bearing)
        before = (along >= _BEFORE * away) & (away <= (_BESIDE + 1) * CELL)
        up = np.abs(self._height[cells] - height[:, None])
        most = self._ramp[:, None] * away + _ROUGH * self._step
        return np.asarray(((before | (away <= 0.5 * CELL)) & (up <= most)).any(axis=1))

    def _learn(self, x: Floats, y: Floats, height: Floats, least: float) -> None:
        """Take points of the ground in `odom` [m].

        What a cell knows stays if the height differs by less than `least` [m]. Else hits that
        climb an upright face would carry the ground up with them.
        """
        cells = _cells(x, y)
        known = np.hypot(self._x[cells] - x, self._y[cells] - y) <= 2.0 * CELL
        new = ~(known & (np.abs(self._height[cells] - height) <= least))
        self._x[cells[new]], self._y[cells[new]] = x[new], y[new]
        self._height[cells[new]] = height[new]
        self._mark_until[cells] = -np.inf

    def _mark(self, x: Floats, y: Floats, until: Floats | float, *, edge: bool) -> None:
        cells = _cells(x, y)
        self._mark_x[cells], self._mark_y[cells] = x, y
        self.found += int(edge) * int(np.count_nonzero(self._mark_until[cells] == -np.inf))
        self._mark_until[cells] = np.maximum(self._mark_until[cells], until)
        self._is_edge[cells] = edge

    def _mark_edges(
        self, pose: Pose, missing: npt.NDArray[np.intp], away: Floats, now: float
    ) -> None:
        """Mark where the known ground ends on the ways of beams; at the rim if none is known.

        Args:
            pose: The robot's pose.
            missing: Which of the beams to the ground, shape (m,).
            away: Length of the way of each of them [m], shape (k,).
            now: The time.
        """
        if not len(missing):
            return
        steps = np.arange(round(_LONGEST_WAY / CELL))[:, None]
        ways = np.asarray(steps * CELL + self._rim, np.float64)
        x, y = (part[:, missing] for part in self._outward(pose, ways))
        ways = ways[:, missing]
        cells = _cells(x[..., None] + CELL * _NEXT[0], y[..., None] + CELL * _NEXT[1])
        off = np.hypot(self._x[cells] - x[..., None], self._y[cells] - y[..., None])
        known = (~np.isnan(self._height[cells]) & (off <= _SAME)).any(axis=2)
        known &= ways <= away[missing]
        last = np.maximum.accumulate(np.where(known, steps, -1), axis=0)
        ends = (last >= 0) & (steps - last > _GAP)
        end = np.where(ends.any(axis=0), ends.argmax(axis=0), len(steps) - 1)
        last = last[end, np.arange(len(missing))]
        begins = ways[known.argmax(axis=0), np.arange(len(missing))]
        sure = (last >= 0) & (begins <= self._crossing[missing])
        edge = self._rim.copy()
        edge[missing] += np.where(sure, (last + 0.5) * CELL, 0.0)
        x, y = self._outward(pose, edge)
        until = now + np.where(sure, MARK_S, GUESS_S)
        self._mark(x[missing], y[missing], until, edge=True)


def _cells(x: Floats, y: Floats) -> npt.NDArray[np.intp]:
    """The cells of points in the grid, which repeats; any shape."""
    column = np.floor(x / CELL).astype(np.intp) % CELLS
    row = np.floor(y / CELL).astype(np.intp) % CELLS
    cells: npt.NDArray[np.intp] = row * CELLS + column
    return cells
