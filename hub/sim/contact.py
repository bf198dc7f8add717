"""Contact of a body, a circle or a convex outline, with obstacles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hub.gcm.body import Bumper
from hub.pose import Pose, wrapped
from hub.sim.arena import Footprints
from hub.sim.convex_body import ConvexBody

TOUCH = 1e-3
"""A bumper is pressed when something is this near [m]."""
_GAP = 1e-6
"""Distance that is left when the body is pushed out of something [m]."""
_PUSHES = 6


class Impact(NamedTuple):
    """A new contact.

    Attributes:
        bearing: Direction of what the body touches, from straight ahead [rad], in (-pi, pi].
        approach: Motion towards it in the step of the contact [m].
    """

    bearing: float
    approach: float

    @classmethod
    def of(cls, direction: float, heading: float, moved_x: float, moved_y: float) -> Impact:
        """The impact of a motion [m] on something in a direction [rad] of the plane."""
        along = moved_x * math.cos(direction) + moved_y * math.sin(direction)
        return cls(wrapped(direction - heading), max(0.0, along))


NO_IMPACT = Impact(math.nan, 0.0)


class ContactBody:
    """The robot's body among obstacles: its possible positions and its contacts.

    Attributes:
        touched: Numbers of the obstacles it touches.
        contacts: Number of new contacts with an obstacle.
        impact: The last of them.
    """

    def __init__(
        self,
        footprints: Footprints,
        radius: float,
        bumpers: Sequence[Bumper],
        outline: npt.NDArray[np.float64] | None = None,
    ) -> None:
        """Stand clear of everything.

        Args:
            footprints: The obstacles.
            radius: The body is this circle [m], if it has no outline.
            bumpers: Its bumpers.
            outline: Corners of the body [m], shape (n, 2); their convex hull counts. None or
                none: the circle.
        """
        self._obstacles = footprints
        self._convex: ConvexBody | None = None
        self._radius = radius
        if outline is not None and len(outline):
            self._convex = ConvexBody(outline, footprints)
            self._radius = self._convex.radius
        self._bumpers = bumpers
        self._boxes = len(footprints.low)
        self._free = 0.0
        self.touched: frozenset[int] = frozenset()
        self.contacts = 0
        self.impact = NO_IMPACT

    def move(self, before: Pose, wanted: Pose) -> Pose:
        """The end of a short motion to a wanted pose: the body slides along obstacles, or stays.

        A short motion is shorter than the body's radius. A round body always turns.
        """
        self._free -= math.hypot(wanted.x - before.x, wanted.y - before.y)
        # An obstacle farther than the path since the last check cannot be reached yet.
        if self._free > TOUCH:
            return wanted
        if self._convex is None:
            x, y = self._pushed_out(before, wanted)
            pose = Pose(x=x, y=y, theta=wanted.theta)
        else:
            pose = self._slid(self._convex, before, wanted)
        gaps = self._obstacles.distances(pose.x, pose.y) - self._radius
        self._free = float(gaps.min(initial=math.inf))
        if self._convex is not None and self._free < TOUCH:
            gaps = self._convex.gaps(pose)[0]
        touched = frozenset(np.flatnonzero(gaps < TOUCH).tolist())
        for number in touched - self.touched:
            self.contacts += 1
            direction = self._direction(number, pose)
            way = wanted.x - before.x, wanted.y - before.y
            self.impact = Impact.of(direction, pose.theta, *way)
        self.touched = touched
        return pose

    def _direction(self, number: int, pose: Pose) -> float:
        """The direction in the plane in which the body touches an obstacle [rad]."""
        if self._convex is None:
            x, y = self._nearest_point(number, pose.x, pose.y)
            return math.atan2(y - pose.y, x - pose.x)
        bearings = self._convex.contact_bearings(pose, number, 2.0 * TOUCH)
        return pose.theta + math.atan2(np.sin(bearings).sum(), np.cos(bearings).sum())

    def _slid(self, body: ConvexBody, before: Pose, wanted: Pose) -> Pose:
        """The wanted pose, moved out of obstacles; the one before if that fails."""
        pose = wanted
        for _ in range(_PUSHES):
            gaps, ways = body.gaps(pose)
            if float(gaps.min(initial=math.inf)) >= 0.0:
                return pose
            deepest = int(gaps.argmin())
            x, y = (ways[deepest] * (float(gaps[deepest]) - _GAP)).tolist()
            pose = Pose(x=pose.x + x, y=pose.y + y, theta=pose.theta)
        return before

    def bumpers(self, pose: Pose) -> int:
        """Bit i is set when something touches bumper i."""
        bits = 0
        for number in self.touched:
            if self._convex is None:
                x, y = self._nearest_point(number, pose.x, pose.y)
                directions = [math.atan2(y - pose.y, x - pose.x) - pose.theta]
            else:
                directions = self._convex.contact_bearings(pose, number, 2.0 * TOUCH).tolist()
            for place, bumper in enumerate(self._bumpers):
                offs = (math.remainder(each - bumper.direction, math.tau) for each in directions)
                bits |= any(abs(off) <= bumper.width / 2.0 for off in offs) << place
        return bits

    def _pushed_out(self, before: Pose, wanted: Pose) -> tuple[float, float]:
        """The wanted place, moved out of obstacles; the one before if that fails."""
        x, y = wanted.x, wanted.y
        for _ in range(_PUSHES):
            distances = self._obstacles.distances(x, y)
            if float(distances.min(initial=math.inf)) >= self._radius:
                return x, y
            deepest = int(distances.argmin())
            near_x, near_y = self._nearest_point(deepest, x, y)
            away = np.array((x - near_x, y - near_y))
            length = float(np.hypot(away[0], away[1]))
            if length < _GAP:
                break
            scale = (self._radius + _GAP) / length
            x, y = near_x + float(away[0]) * scale, near_y + float(away[1]) * scale
        return before.x, before.y

    def _nearest_point(self, number: int, x: float, y: float) -> tuple[float, float]:
        """The point of an obstacle's outline that is nearest to a point outside it."""
        obstacles = self._obstacles
        if number < self._boxes:
            point: npt.NDArray[np.float64] = np.clip(
                (x, y), obstacles.low[number], obstacles.high[number]
            )
            return float(point[0]), float(point[1])
        centre_x, centre_y = obstacles.centre[number - self._boxes].tolist()
        radius = float(obstacles.radius[number - self._boxes])
        distance = math.hypot(x - centre_x, y - centre_y)
        if distance == 0.0:
            return centre_x, centre_y
        scale = radius / distance
        return centre_x + (x - centre_x) * scale, centre_y + (y - centre_y) * scale
