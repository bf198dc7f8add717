"""A task of navigation: go to points, or turn on the spot; pure.

A message begins a task. The task does not depend on its sender: a command sends a goal and ends.

| event | action |
| --- | --- |
| the last point or the heading is reached | the task ends: done |
| a stop, a motion command, or another task | the task ends: cancelled |
| the path is closed | wait, at most for the task's patience; then end |
| the wheels are held | wait, at most `LONGEST_HOLD_S`; then end |
| the robot makes headway again | go on |
"""

from __future__ import annotations

import math
from itertools import pairwise

from hub.gcm.navigation import Cause, GoalCommand, Task, TurnCommand
from hub.modules.navigation.route import CARROT, OFF, Route, Way
from hub.pose import Pose, wrapped
from hub.values import dataclass

REACHED = 0.1
"""The last point is reached within this distance [m]."""
PASSED = 0.3
"""Any other point is reached within this distance [m]."""
TURNED = math.radians(3.0)
"""A heading is reached within this angle [rad]."""
BLOCKED_S = 8.0
"""After this time without headway [s] the path is closed, for any patience."""
PATIENCE_S = 30.0
"""Default patience: the time that a robot waits before a closed path [s]."""
MOST_PATIENCE_S = 600.0
"""Largest patience [s]."""
MENTION_S = 5.0
"""After this time without headway [s] a robot reports that it waits."""
LONGEST_HOLD_S = 60.0
"""A task ends when it was held for this time without headway between [s]."""
HEADWAY = 0.1
"""Headway: the robot came nearer by this [m, or rad for a turn]."""
OCCUPIED = 0.4
"""A point is occupied if the robot is blocked this near to it [m]."""
CLOSELY = 0.2
"""After a blockage the robot heads for a point this far along the path [m]; a farther point would
make it cut the corner again."""
CLOSELY_S = 5.0
"""Time for which it follows the path that closely [s]."""
MOST_ROUNDS = 3
"""Number of longer paths in a row, round something new, that count as headway."""
MOST_DETOURS = 5
"""Number of longer paths to one point that are detours; more are a lack of headway."""
MOST_POINTS = 1000
"""A goal of more points than this is refused."""
FARTHEST = 1e4
"""A goal farther from the origin than this [m] is refused."""
LARGEST_TURN = 100.0
"""A turn by more than this [rad] is refused."""

_NOT_FOLLOWED = (Cause.DRIVER, "the driver does not follow: see whether it is armed, and its mode")
"""The driver has another velocity than it was given: an autopilot has the vehicle, for instance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Aim:
    """What a task needs of the wheels now: to go to a place, or to turn on the spot.

    Attributes:
        x: Where to head for, in `map` [m].
        y: Where to head for, in `map` [m].
        left: Length of the path to the point where the robot must stand [m].
        turn: Angle to turn on the spot [rad]; None: go.
        limit: Largest forward velocity [m/s].
        stay: Whether to stand, because no path is known.
    """

    x: float = 0.0
    y: float = 0.0
    left: float = 0.0
    turn: float | None = None
    limit: float = math.inf
    stay: bool = False


class NavigationTask:
    """The present task, or the last one; every method gets the present monotonic time [s].

    Attributes:
        number: Counts the tasks.
        state: What it does, or how it ended.
        sender: Number of the client that began it.
        why: Why it waits or how it ended, for people.
        cause: The same for programs.
        place: Its last point, in `map` [m]; NaN: it is a turn, or there was no task.
        ended: When it ended [s].
        points: Points that are left, in `map` [m].
        distance_left: Length of the path that is left [m]; NaN: not known.
        route: The planned path; None: there is no plan.
        theta: Wanted heading at the last point, in `map` [rad]; NaN: any.
        by_robot: Whether the robot's own navigation carries it out.
    """

    def __init__(self) -> None:
        self.number = 0
        self.state = Task.NONE
        self.sender = 0
        self.why = ""
        self.cause = Cause.NONE
        self.place = (math.nan, math.nan)
        self.ended = math.nan
        self.points: Way = ()
        self.distance_left = math.nan
        self.route: Route | None = None
        self.theta = math.nan
        self.by_robot = False
        self._limit = math.inf
        self._turn_left = 0.0
        self._heading = 0.0
        self._best = math.inf
        self._best_at = 0.0
        self._patience = PATIENCE_S
        self._began = 0.0
        self._updated_at = 0.0
        self._held = 0.0
        self._held_for: tuple[Cause, str] | None = None
        self._no_way = ""
        self._arrived = False
        self._rounds = self._detours = 0
        self._closely_until = -math.inf

    @property
    def active(self) -> bool:
        """Whether the task is not finished."""
        return self.state in (Task.GOING, Task.TURNING)

    @property
    def goal(self) -> tuple[float, float] | None:
        """The next point, in `map` [m]."""
        return self.points[0] if self.state is Task.GOING and self.points else None

    def go(self, goal: GoalCommand, sender: int, now: float) -> None:
        """Begin a task to go to points; without points, end the present task."""
        if not goal.points:
            self.end(Task.CANCELLED, "somebody ended it", Cause.WITHDRAWN, now)
            return
        self.end(Task.CANCELLED, "another task came", Cause.REPLACED, now)
        self._begin(Task.GOING, sender, now)
        self.points = tuple((point.x, point.y) for point in goal.points)
        self.place = self.points[-1]
        wanted = goal.patience if goal.patience > 0.0 else PATIENCE_S
        self._patience = min(wanted, MOST_PATIENCE_S)
        self.theta = goal.theta
        self._limit = goal.linear_limit if goal.linear_limit > 0.0 else math.inf

    def turn(self, command: TurnCommand, sender: int, pose: Pose, now: float) -> None:
        """Begin a task to turn on the spot."""
        self.end(Task.CANCELLED, "another task came", Cause.REPLACED, now)
        self._begin(Task.TURNING, sender, now)
        self._turn_left = command.angle
        self._heading = pose.theta

    def refuse(self, goal: GoalCommand, sender: int, why: str, cause: Cause, now: float) -> None:
        """Record a refused goal; the present task goes on."""
        if goal.points and not self.active:
            self._begin(Task.GOING, sender, now)
            self.place = goal.points[-1].x, goal.points[-1].y
            self.end(Task.CANCELLED, f"not begun: {why}", cause, now)

    def end(self, how: Task, why: str, cause: Cause, now: float) -> None:
        """End the task, if it is active."""
        if self.active:
            self.state = how
            self.why, self.cause = why, cause
            self.route = None
            self.ended = now

    def reached(self, now: float) -> None:
        """The robot's own navigation has reached the next point."""
        if len(self.points) > 1:
            self._next_point(now)
        else:
            self.points, self.distance_left = (), 0.0
            self.end(Task.REACHED, "it is there", Cause.NONE, now)

    def seconds(self, now: float) -> float:
        """Time from its begin to now or to its end [s]."""
        return (now if self.active else self.ended) - self._began if self.number else 0.0

    def hold(self, cause: Cause, why: str, now: float) -> None:
        """The wheels are held: wait, and end the task when that takes too long."""
        if not self.active:
            return
        passed = now - self._updated_at
        self._updated_at = now
        self._best_at += passed
        self._closely_until += passed
        self._held += passed
        self.cause, self.why = cause, f"waits: {why}"
        if self._held > LONGEST_HOLD_S:
            self.end(Task.CANCELLED, f"gave up after {LONGEST_HOLD_S:.0f} s: {why}", cause, now)

    def planned(self, way: Way | None, no_way: str = "") -> None:
        """Take a new plan for the path to the next point.

        Args:
            way: The path; None: go straight.
            no_way: Why no path exists, for people; then the robot waits for one.
        """
        self.route = None if way is None else Route(way)
        self._no_way = no_way
        if self.route is not None and self._detours < MOST_DETOURS:
            length = sum(math.dist(a, b) for a, b in pairwise(self.route.way))
            if self._best + HEADWAY < length < math.inf:
                # Headway is measured on the new path; the time limit stays.
                self._best = length
                self._detours += 1

    def goes_round(self, pose: Pose, now: float) -> None:
        """An obstacle that was not on the map blocks the path: measure headway from here.

        If the goal is as near as the obstacle, no path leads round it.
        """
        goal = self.goal
        if goal is not None and math.dist(goal, (pose.x, pose.y)) <= OCCUPIED:
            self._held_for = (Cause.OCCUPIED, "something stands there")
            if now - self._best_at > self._patience:
                self._blocked(now)
        elif self._rounds < MOST_ROUNDS:
            self._rounds += 1
            self._closely_until = now + CLOSELY_S
            self._best, self._best_at = math.inf, now

    def followed(self, *, by_driver: bool) -> None:
        """Note whether the driver follows the velocity that it was given."""
        if not by_driver:
            self._held_for = _NOT_FOLLOWED
        elif self._held_for == _NOT_FOLLOWED:
            self._held_for = None

    def has_left_path(self, pose: Pose) -> bool:
        """Whether the robot has left its path."""
        return self.route is not None and self.route.ahead(pose)[2] > OFF

    def aim(self, pose: Pose, now: float) -> Aim | None:
        """What the wheels do at a pose in `map`; None: stand, no task is active."""
        self._updated_at = now
        if self.state is Task.TURNING:
            return self._turning(pose, now)
        while self.state is Task.GOING:
            x, y = self.points[0]
            away = math.hypot(x - pose.x, y - pose.y)
            if len(self.points) > 1 and away <= PASSED:
                self._next_point(now)
                continue
            if away <= REACHED or self._arrived:
                return self._arriving(pose, now)
            return self._going(pose, away, now)
        return None

    def _begin(self, state: Task, sender: int, now: float) -> None:
        self.number += 1
        self.state, self.sender, self.why, self.cause = state, sender, "", Cause.NONE
        self.place, self.ended = (math.nan, math.nan), math.nan
        self._began = self._updated_at = now
        self._held = 0.0
        self._held_for, self._no_way = None, ""
        self._patience = 0.0
        self.points, self.route, self.distance_left = (), None, math.nan
        self.theta, self._limit = math.nan, math.inf
        self.by_robot = False
        self._arrived = False
        self._rounds = self._detours = 0
        self._closely_until = -math.inf
        self._best, self._best_at = math.inf, now

    def _next_point(self, now: float) -> None:
        self.points = self.points[1:]
        self._detours = 0
        self.route = None
        self._best, self._best_at = math.inf, now

    def _going(self, pose: Pose, away: float, now: float) -> Aim | None:
        if self.route is None:
            carrot, left = self.points[0], away
        else:
            length = CLOSELY if now < self._closely_until else CARROT
            carrot, left, _ = self.route.ahead(pose, length)
        later = sum(math.dist(a, b) for a, b in pairwise(self.points))
        self.distance_left = left + later
        headway = self._headway(left, now)
        if self._no_way and not headway:
            self._held_for = (Cause.CLOSED, self._no_way)
        waited = now - self._best_at
        if waited > (self._patience if self._no_way else max(BLOCKED_S, self._patience)):
            self._blocked(now)
            return None
        self._report_waiting(waited)
        if self._no_way:
            return Aim(stay=True)
        return Aim(x=carrot[0], y=carrot[1], left=left + later, limit=self._limit)

    def _arriving(self, pose: Pose, now: float) -> Aim | None:
        """Turn to the heading of the goal."""
        if not self._arrived:
            self._arrived = True
            self._best, self._best_at = math.inf, now
        self.distance_left = 0.0
        turn = wrapped(self.theta - pose.theta) if math.isfinite(self.theta) else 0.0
        return self._turn_by(turn, "it is there", now)

    def _turning(self, pose: Pose, now: float) -> Aim | None:
        # The sum of small differences tells a whole turn from none.
        self._turn_left -= wrapped(pose.theta - self._heading)
        self._heading = pose.theta
        return self._turn_by(self._turn_left, "it has turned", now)

    def _turn_by(self, turn: float, done: str, now: float) -> Aim | None:
        if abs(turn) <= TURNED:
            self.points = ()
            self.end(Task.REACHED, done, Cause.NONE, now)
            return None
        self._headway(abs(turn), now)
        if now - self._best_at > BLOCKED_S:
            self.end(Task.BLOCKED, "it does not turn", Cause.CLOSED, now)
            return None
        self._report_waiting(0.0)
        return Aim(turn=turn)

    def _headway(self, left: float, now: float) -> bool:
        """Whether the robot came nearer than ever before."""
        nearer = left < self._best - HEADWAY
        if nearer:
            self._best, self._best_at = left, now
            self._held, self._held_for = 0.0, None
        return nearer

    def _report_waiting(self, waited: float) -> None:
        """Report a closed path, after some seconds without headway or at once."""
        cause, why = self._held_for or (Cause.CLOSED, "something is in the way")
        waits = waited > MENTION_S or bool(self._no_way)
        self.cause, self.why = (cause, f"waits: {why}") if waits else (Cause.NONE, "")

    def _blocked(self, now: float) -> None:
        """No path exists: wait, and end the task when the patience is over."""
        cause, why = self._held_for or (Cause.CLOSED, "it comes no nearer")
        self.end(Task.BLOCKED, why, cause, now)


def refusal(goal: GoalCommand) -> str:
    """Why a goal is refused; empty if it is not."""
    if len(goal.points) > MOST_POINTS:
        return f"more than {MOST_POINTS} points"
    for point in goal.points:
        if not (abs(point.x) <= FARTHEST and abs(point.y) <= FARTHEST):
            return "a point with coordinates that are not finite or too far"
    return ""
