"""Drives simulated wheels to goals, by the rules of Nav2 and move_base; no sockets.

| goal | event | next |
| --- | --- | --- |
| none | a goal in a frame that it knows | it drives |
| drives | it is there | reached |
| drives | the map shows no way, or it came no nearer for 8 s | aborted |
| drives | another goal | aborted in ROS 2, cancelled in ROS 1 |
| drives | a cancel | cancelled; the wheels get one zero |

The bridge's threads give goals and cancels, and its own thread lets time pass, so a lock is needed.
"""

from __future__ import annotations

import itertools
import math
import threading
from collections import OrderedDict
from typing import Final

from hub.gcm.geometry import Twist
from hub.grids.grid import Grid
from hub.grids.planner import plan
from hub.pose import Pose, wrapped
from hub.ros.goal_messages import CancelAnswer, GoalPlace, GoalStatus, KnownGoal
from hub.values import dataclass

PERIOD: Final = 0.05
"""Time between two velocities [s]."""
_SPEED, _TURN = 0.3, 1.0
"""Largest velocities [m/s, rad/s]."""
_REACHED, _TURNED = 0.1, 0.1
"""A goal is reached within these [m, rad]."""
_AHEAD: Final = 0.2
"""The robot heads for a point this far along its path [m]."""
_ASIDE: Final = 0.7
"""With a larger bearing to that point it turns on the spot [rad]."""
_PATIENCE_S: Final = 8.0
_HEADWAY: Final = 0.1
"""Time without headway after which it gives up [s]; headway is [m, or rad for a turn]."""
_MARGIN: Final = 0.1
_MOST_KEPT: Final = 10
"""Goals that have ended and are still listed."""

Way = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalFailure:
    """Why a goal was aborted, as Nav2 says it.

    Attributes:
        code: Number of the error; 0: there was none.
        text: The same for people.
    """

    code: int = 0
    text: str = ""


_NONE: Final = GoalFailure()
_NO_PATH: Final = GoalFailure(code=208, text="Failed to create a valid plan to the goal")
_NO_HEADWAY: Final = GoalFailure(code=105, text="Failed to make progress")


class SimulatedNavigation:
    """The goals of one robot.

    Attributes:
        left: The way that is left [m]; NaN: it has no goal.
    """

    def __init__(self, grid: Grid, radius: float, frames: tuple[str, ...], *, old: bool) -> None:
        """Have no goal.

        Args:
            grid: What its planner sees.
            radius: Of the robot [m].
            frames: Names of the frames in which it takes goals.
            old: Whether it is move_base of ROS 1.
        """
        self.left = math.nan
        self._grid, self._room = grid, radius + _MARGIN
        self._frames, self._old = frames, old
        self._lock = threading.Lock()
        self._goals: OrderedDict[str, GoalStatus] = OrderedDict()
        self._failures: dict[str, GoalFailure] = {}
        self._place: GoalPlace | None = None
        self._name = ""
        self._way: Way = ()
        self._best, self._patience = math.inf, 0.0
        self._arrived = self._halting = False

    @property
    def goals(self) -> tuple[KnownGoal, ...]:
        """The present goal, and those that ended last."""
        with self._lock:
            return tuple(
                KnownGoal(name=name, status=status, text=self._failures.get(name, _NONE).text)
                for name, status in self._goals.items()
            )

    @property
    def present(self) -> str:
        """The name of the goal that it drives to; empty: none."""
        return self._name

    def end_of(self, name: str) -> tuple[GoalStatus, GoalFailure] | None:
        """How a goal ended; None: it goes on, or is not known."""
        with self._lock:
            status = self._goals.get(name)
            if status is None or not status.ended:
                return None
            return status, self._failures.get(name, _NONE)

    def begin(self, name: str, place: GoalPlace) -> bool:
        """Drive to a place; returns whether it takes the goal."""
        finite = all(map(math.isfinite, (place.x, place.y, place.theta)))
        if place.frame not in self._frames or not finite:
            return False
        with self._lock:
            self._end(GoalStatus.CANCELLED if self._old else GoalStatus.ABORTED)
            self._name, self._place, self._way = name, place, ()
            self._best, self._patience, self._arrived = math.inf, _PATIENCE_S, False
            self._goals[name] = GoalStatus.DRIVES
            while len(self._goals) > _MOST_KEPT:
                self._failures.pop(self._goals.popitem(last=False)[0], None)
        return True

    def cancel(self, name: str) -> CancelAnswer:
        """Cancel a goal, or each with an empty name."""
        with self._lock:
            if self._name and name in ("", self._name):
                self._end(GoalStatus.CANCELLED)
                return CancelAnswer.BEGINS
            if not name:
                return CancelAnswer.BEGINS
            return CancelAnswer.ENDED if name in self._goals else CancelAnswer.UNKNOWN

    def velocity(self, pose: Pose, odom: Pose, seconds: float) -> Twist | None:
        """The velocity after some time [s]; None: it publishes none.

        Args:
            pose: The robot's on the map.
            odom: The origin of `odom` on the map.
            seconds: Time since the last velocity.
        """
        with self._lock:
            twist = self._driven(pose, odom, seconds) if self._place is not None else None
            if twist is None and self._halting:
                twist = Twist()
            self._halting = self._place is not None
        return twist

    def _driven(self, pose: Pose, odom: Pose, seconds: float) -> Twist | None:
        place = self._place
        if place is None:
            return None
        goal = (place.x, place.y)
        theta = place.theta
        if place.frame != self._frames[0]:
            goal, theta = odom.outward(*goal), wrapped(theta + odom.theta)
        if not self._way:
            start = (pose.x, pose.y)
            self._way = self._planned(start, goal)
        if not self._way:
            self._end(GoalStatus.ABORTED, _NO_PATH)
            return None
        away = math.dist(goal, (pose.x, pose.y))
        self._arrived = self._arrived or away <= _REACHED
        turn = wrapped(theta - pose.theta)
        if self._arrived and abs(turn) <= _TURNED:
            self._end(GoalStatus.REACHED)
            return None
        self.left = 0.0 if self._arrived else _length((pose.x, pose.y), self._rest(pose))
        self._watch(abs(turn) if self._arrived else self.left + math.pi, seconds)
        if self._place is None:
            return None
        return Twist.planar(0.0, _limited(2.0 * turn)) if self._arrived else self._along(pose)

    def _planned(self, start: tuple[float, float], goal: tuple[float, float]) -> Way:
        """A path, also over unknown ground as Nav2's planner does; empty: there is none."""
        way = plan(self._grid, start, goal, radius=self._room, squeeze=1.0, tolerance=_REACHED)
        return way or ()

    def _along(self, pose: Pose) -> Twist:
        """The velocity along the path."""
        x, y = _ahead((pose.x, pose.y), self._rest(pose))
        forward, left = pose.inward(x, y)
        bearing = math.atan2(left, forward)
        if abs(bearing) > _ASIDE:
            return Twist.planar(0.0, math.copysign(_TURN, bearing))
        return Twist.planar(min(_SPEED, 0.05 + self.left), _limited(2.0 * bearing))

    def _rest(self, pose: Pose) -> Way:
        """The points of the path that are left."""
        while len(self._way) > 1 and math.dist(self._way[0], (pose.x, pose.y)) < _AHEAD:
            self._way = self._way[1:]
        return self._way

    def _watch(self, left: float, seconds: float) -> None:
        """Give up without headway."""
        if left < self._best - _HEADWAY:
            self._best, self._patience = left, _PATIENCE_S
        self._patience -= seconds
        if self._patience < 0.0:
            self._end(GoalStatus.ABORTED, _NO_HEADWAY)

    def _end(self, status: GoalStatus, failure: GoalFailure | None = None) -> None:
        if self._name:
            self._goals[self._name] = status
        if self._name and failure is not None:
            self._failures[self._name] = failure
        self._name, self._place, self.left = "", None, math.nan


def _length(start: tuple[float, float], way: Way) -> float:
    points = (start, *way)
    return sum(math.dist(a, b) for a, b in itertools.pairwise(points))


def _ahead(start: tuple[float, float], way: Way) -> tuple[float, float]:
    """The point of a path at a distance of `_AHEAD`, or its next one if that is farther."""
    left = _AHEAD
    for point in way:
        piece = math.dist(start, point)
        if piece >= left:
            share = left / piece
            return (
                start[0] + (point[0] - start[0]) * share,
                start[1] + (point[1] - start[1]) * share,
            )
        left -= piece
        start = point
    return start


def _limited(turn: float) -> float:
    return max(-_TURN, min(_TURN, turn))
