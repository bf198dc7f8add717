"""What navigation does by itself: it goes to points, or it turns; pure.

A task is begun by a message and then goes on by itself, also when its sender is gone: a command
line sends a goal and ends. It ends when it is done, when it makes no headway, or when somebody
ends it: by a stop, a velocity that is not neutral, or another task.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from hub.gcm.navigation import GoalCommand, Task, TurnCommand
from hub.modules.navigation.route import CARROT, OFF, Route, Way
from hub.plane import Pose, wrapped

REACHED = 0.1
"""A point counts as reached from so far off [m]."""
PASSED = 0.3
"""A point that is not the last one counts as reached from so far off [m]."""
TURNED = math.radians(3.0)
"""A heading counts as reached from so far off [rad]."""
BLOCKED_S = 8.0
"""Without headway for this long [s] there is no way."""
HEADWAY = 0.1
"""Coming nearer by this is headway [m, or rad for a turn]."""
OCCUPIED = 0.4
"""Who is held up so near to a point [m] finds it occupied."""
CLOSELY = 0.2
"""So far along the way lies the point that the robot heads for after it was held up [m]: heading
for one that is farther off it would cut the corner again."""
CLOSELY_S = 5.0
"""So long it follows its way closely then [s]."""
MOST_ROUNDS = 3
"""So often in turn a longer way round something new does not count as a lack of headway."""
MOST_POINTS = 1000
"""A goal of more points than this is refused."""
FARTHEST = 1e4
"""A goal farther from the origin than this [m] is refused."""
LARGEST_TURN = 100.0
"""A turn by more than this [rad] is refused."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Aim:
    """What a task wants of the wheels now; either to go to a place, or to turn on the spot.

    Attributes:
        x: Where to head for, in `map` [m].
        y: Where to head for, in `map` [m].
        left: Length of the way to the point where the robot has to stand [m].
        turn: By how much to turn on the spot [rad]; None: go.
        limit: Fastest forward velocity [m/s].
    """

    x: float = 0.0
    y: float = 0.0
    left: float = 0.0
    turn: float | None = None
    limit: float = math.inf


class Errand:
    """The present task, or the last one; every method gets the present monotonic time [s].

    Attributes:
        number: Counts the tasks.
        task: What is done, or how it ended.
        sender: Whose task it is or was.
        why: For people.
        points: Points that are left, in `map` [m].
        distance_left: Length of the way that is left [m]; NaN: not known.
        route: The planned way, if there is a plan.
    """

    def __init__(self) -> None:
        self.number = 0
        self.task = Task.NONE
        self.sender = 0
        self.why = ""
        self.points: Way = ()
        self.distance_left = math.nan
        self.route: Route | None = None
        self._theta = math.nan
        self._limit = math.inf
        self._turn_left = 0.0
        self._heading = 0.0
        self._best = math.inf
        self._best_at = 0.0
        self._arrived = False
        self._rounds = 0
        self._closely_until = -math.inf

    @property
    def active(self) -> bool:
        """Whether it is under way."""
        return self.task in (Task.GOING, Task.TURNING)

    @property
    def goal(self) -> tuple[float, float] | None:
        """The point that it goes to now, in `map` [m]."""
        return self.points[0] if self.task is Task.GOING and self.points else None

    def go(self, goal: GoalCommand, sender: int, now: float) -> None:
        """Somebody wants the robot at points; none: to stand."""
        self.end(Task.CANCELLED, "another task came")
        if not goal.points:
            return
        self._begin(Task.GOING, sender, now)
        self.points = tuple((point.x, point.y) for point in goal.points)
        self._theta = goal.theta
        self._limit = goal.linear_limit if goal.linear_limit > 0.0 else math.inf

    def turn(self, command: TurnCommand, sender: int, pose: Pose, now: float) -> None:
        """Somebody wants the robot to turn on the spot."""
        self.end(Task.CANCELLED, "another task came")
        self._begin(Task.TURNING, sender, now)
        self._turn_left = command.angle
        self._heading = pose.theta

    def end(self, how: Task, why: str) -> None:
        """It ends, if it is under way."""
        if self.active:
            self.task = how
            self.why = why
            self.route = None

    def planned(self, way: Way | None) -> None:
        """There is a new plan for the way to the present point; None: go straight."""
        self.route = None if way is None else Route(way)

    def goes_round(self, pose: Pose, now: float) -> None:
        """Something that was not on the map is in the way: headway counts from here on.

        If it is as near as the goal, nothing leads round it.
        """
        goal = self.goal
        if goal is not None and math.dist(goal, (pose.x, pose.y)) <= OCCUPIED:
            self.end(Task.BLOCKED, "something stands there")
        elif self._rounds < MOST_ROUNDS:
            self._rounds += 1
            self._closely_until = now + CLOSELY_S
            self._best, self._best_at = math.inf, now

    def astray(self, pose: Pose) -> bool:
        """Whether the robot has left its way."""
        return self.route is not None and self.route.ahead(pose)[2] > OFF

    def aim(self, pose: Pose, now: float) -> Aim | None:
        """What the wheels should do at a pose in `map`; None: stand, nothing is under way."""
        if self.task is Task.TURNING:
            return self._turning(pose, now)
        while self.task is Task.GOING:
            x, y = self.points[0]
            away = math.hypot(x - pose.x, y - pose.y)
            if len(self.points) > 1 and away <= PASSED:
                self._next_point(now)
                continue
            if away <= REACHED or self._arrived:
                return self._arriving(pose, now)
            return self._going(pose, away, now)
        return None

    def _begin(self, task: Task, sender: int, now: float) -> None:
        self.number += 1
        self.task, self.sender, self.why = task, sender, ""
        self.points, self.route, self.distance_left = (), None, math.nan
        self._theta, self._limit = math.nan, math.inf
        self._arrived = False
        self._rounds = 0
        self._closely_until = -math.inf
        self._best, self._best_at = math.inf, now

    def _next_point(self, now: float) -> None:
        self.points = self.points[1:]
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
        if not self._headway(left, now):
            self.end(Task.BLOCKED, "it comes no nearer")
            return None
        return Aim(x=carrot[0], y=carrot[1], left=left + later, limit=self._limit)

    def _arriving(self, pose: Pose, now: float) -> Aim | None:
        """Turn to the heading that is wanted at the end."""
        if not self._arrived:
            self._arrived = True
            self._best, self._best_at = math.inf, now
        self.distance_left = 0.0
        turn = wrapped(self._theta - pose.theta) if math.isfinite(self._theta) else 0.0
        return self._turn_by(turn, "it is there", now)

    def _turning(self, pose: Pose, now: float) -> Aim | None:
        # Sums small differences, so that more than a whole turn can be told from less.
        self._turn_left -= wrapped(pose.theta - self._heading)
        self._heading = pose.theta
        return self._turn_by(self._turn_left, "it has turned", now)

    def _turn_by(self, turn: float, done: str, now: float) -> Aim | None:
        if abs(turn) <= TURNED:
            self.points = ()
            self.end(Task.REACHED, done)
            return None
        if not self._headway(abs(turn), now):
            self.end(Task.BLOCKED, "it does not turn")
            return None
        return Aim(turn=turn)

    def _headway(self, left: float, now: float) -> bool:
        if left < self._best - HEADWAY:
            self._best, self._best_at = left, now
        return now - self._best_at <= BLOCKED_S


def refusal(goal: GoalCommand) -> str:
    """Why a goal cannot be gone to; empty if it can."""
    if len(goal.points) > MOST_POINTS:
        return f"more than {MOST_POINTS} points"
    for point in goal.points:
        if not (abs(point.x) <= FARTHEST and abs(point.y) <= FARTHEST):
            return "a point that is nowhere"
    return ""
