"""What navigation does by itself: it goes to points, or it turns; pure.

A task is begun by a message and then goes on by itself, also when its sender is gone: a command
line sends a goal and ends. It ends when it is done, when it makes no headway, or when somebody
ends it: by a stop, a velocity that is not neutral, or another task. It waits, and goes on by
itself, where the way is closed and where the wheels are held; both for a limited time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from hub.gcm.navigation import Cause, GoalCommand, Task, TurnCommand
from hub.modules.navigation.route import CARROT, OFF, Route, Way
from hub.pose import Pose, wrapped

REACHED = 0.1
"""A point counts as reached from so far off [m]."""
PASSED = 0.3
"""A point that is not the last one counts as reached from so far off [m]."""
TURNED = math.radians(3.0)
"""A heading counts as reached from so far off [rad]."""
BLOCKED_S = 8.0
"""Without headway for this long [s] the way counts as closed, whatever the sender's patience."""
PATIENCE_S = 30.0
"""A robot waits for so long where the way is closed, unless its sender says something else [s]."""
MOST_PATIENCE_S = 600.0
"""It waits no longer than this [s]."""
MENTION_S = 5.0
"""Without headway for this long [s] a robot says that it waits."""
LONGEST_HOLD_S = 60.0
"""A task whose wheels were held for this time without headway between ends [s]."""
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
MOST_DETOURS = 5
"""So often on the way to a point a longer way is a detour; after that it is a lack of headway."""
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
        stay: Whether to stand, as no way is known.
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
        task: What is done, or how it ended.
        sender: Whose task it is or was.
        why: Why it waits or how it ended, for people.
        cause: The same for programs.
        place: Where it leads or led to, in `map` [m]; NaN: it is a turn, or there was none.
        ended: When it ended [s].
        points: Points that are left, in `map` [m].
        distance_left: Length of the way that is left [m]; NaN: not known.
        route: The planned way, if there is a plan.
    """

    def __init__(self) -> None:
        self.number = 0
        self.task = Task.NONE
        self.sender = 0
        self.why = ""
        self.cause = Cause.NONE
        self.place = (math.nan, math.nan)
        self.ended = math.nan
        self.points: Way = ()
        self.distance_left = math.nan
        self.route: Route | None = None
        self._theta = math.nan
        self._limit = math.inf
        self._turn_left = 0.0
        self._heading = 0.0
        self._best = math.inf
        self._best_at = 0.0
        self._patience = PATIENCE_S
        self._began = 0.0
        self._seen = 0.0
        self._held = 0.0
        self._hindrance: tuple[Cause, str] | None = None
        self._no_way = ""
        self._arrived = False
        self._rounds = self._detours = 0
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
        if not goal.points:
            self.end(Task.CANCELLED, "somebody ended it", Cause.WITHDRAWN, now)
            return
        self.end(Task.CANCELLED, "another task came", Cause.REPLACED, now)
        self._begin(Task.GOING, sender, now)
        self.points = tuple((point.x, point.y) for point in goal.points)
        self.place = self.points[-1]
        wanted = goal.patience if goal.patience > 0.0 else PATIENCE_S
        self._patience = min(wanted, MOST_PATIENCE_S)
        self._theta = goal.theta
        self._limit = goal.linear_limit if goal.linear_limit > 0.0 else math.inf

    def turn(self, command: TurnCommand, sender: int, pose: Pose, now: float) -> None:
        """Somebody wants the robot to turn on the spot."""
        self.end(Task.CANCELLED, "another task came", Cause.REPLACED, now)
        self._begin(Task.TURNING, sender, now)
        self._turn_left = command.angle
        self._heading = pose.theta

    def refuse(self, goal: GoalCommand, sender: int, why: str, cause: Cause, now: float) -> None:
        """A goal is not begun; what is under way goes on."""
        if goal.points and not self.active:
            self._begin(Task.GOING, sender, now)
            self.place = goal.points[-1].x, goal.points[-1].y
            self.end(Task.CANCELLED, f"not begun: {why}", cause, now)

    def end(self, how: Task, why: str, cause: Cause, now: float) -> None:
        """It ends, if it is under way."""
        if self.active:
            self.task = how
            self.why, self.cause = why, cause
            self.route = None
            self.ended = now

    def seconds(self, now: float) -> float:
        """How long it has taken so far, or took in all [s]."""
        return (now if self.active else self.ended) - self._began if self.number else 0.0

    def hold(self, cause: Cause, why: str, now: float) -> None:
        """The wheels are held, which says nothing of the way; this ends what is held too long."""
        if not self.active:
            return
        passed = now - self._seen
        self._seen = now
        self._best_at += passed
        self._closely_until += passed
        self._held += passed
        self.cause, self.why = cause, f"waits: {why}"
        if self._held > LONGEST_HOLD_S:
            self.end(Task.CANCELLED, f"gave up after {LONGEST_HOLD_S:.0f} s: {why}", cause, now)

    def planned(self, way: Way | None, no_way: str = "") -> None:
        """There is a new plan for the way to the present point.

        Args:
            way: The way; None: go straight.
            no_way: Why there is none at all, for people; the robot waits for one then.
        """
        self.route = None if way is None else Route(way)
        self._no_way = no_way
        if self.route is not None and self._detours < MOST_DETOURS:
            length = sum(math.dist(a, b) for a, b in pairwise(self.route.way))
            if self._best + HEADWAY < length < math.inf:
                # Headway on a longer way is headway; the time that it has for it stays.
                self._best = length
                self._detours += 1

    def goes_round(self, pose: Pose, now: float) -> None:
        """Something that was not on the map is in the way: headway counts from here on.

        If it is as near as the goal, nothing leads round it.
        """
        goal = self.goal
        if goal is not None and math.dist(goal, (pose.x, pose.y)) <= OCCUPIED:
            self._hindrance = (Cause.OCCUPIED, "something stands there")
            if now - self._best_at > self._patience:
                self._blocked(now)
        elif self._rounds < MOST_ROUNDS:
            self._rounds += 1
            self._closely_until = now + CLOSELY_S
            self._best, self._best_at = math.inf, now

    def astray(self, pose: Pose) -> bool:
        """Whether the robot has left its way."""
        return self.route is not None and self.route.ahead(pose)[2] > OFF

    def aim(self, pose: Pose, now: float) -> Aim | None:
        """What the wheels should do at a pose in `map`; None: stand, nothing is under way."""
        self._seen = now
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
        self.task, self.sender, self.why, self.cause = task, sender, "", Cause.NONE
        self.place, self.ended = (math.nan, math.nan), math.nan
        self._began = self._seen = now
        self._held = 0.0
        self._hindrance, self._no_way = None, ""
        self._patience = 0.0
        self.points, self.route, self.distance_left = (), None, math.nan
        self._theta, self._limit = math.nan, math.inf
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
            self._hindrance = (Cause.CLOSED, self._no_way)
        waited = now - self._best_at
        if waited > (self._patience if self._no_way else max(BLOCKED_S, self._patience)):
            self._blocked(now)
            return None
        self._say_whether_it_waits(waited)
        if self._no_way:
            return Aim(stay=True)
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
            self.end(Task.REACHED, done, Cause.NONE, now)
            return None
        self._headway(abs(turn), now)
        if now - self._best_at > BLOCKED_S:
            self.end(Task.BLOCKED, "it does not turn", Cause.CLOSED, now)
            return None
        self._say_whether_it_waits(0.0)
        return Aim(turn=turn)

    def _headway(self, left: float, now: float) -> bool:
        """Whether it has come nearer since it last did."""
        nearer = left < self._best - HEADWAY
        if nearer:
            self._best, self._best_at = left, now
            self._held, self._hindrance = 0.0, None
        return nearer

    def _say_whether_it_waits(self, waited: float) -> None:
        """Tell of a way that is closed, after some seconds without headway or at once."""
        cause, why = self._hindrance or (Cause.CLOSED, "something is in the way")
        waits = waited > MENTION_S or bool(self._no_way)
        self.cause, self.why = (cause, f"waits: {why}") if waits else (Cause.NONE, "")

    def _blocked(self, now: float) -> None:
        """There is no way, or none any more."""
        cause, why = self._hindrance or (Cause.CLOSED, "it comes no nearer")
        self.end(Task.BLOCKED, why, cause, now)


def refusal(goal: GoalCommand) -> str:
    """Why a goal cannot be gone to; empty if it can."""
    if len(goal.points) > MOST_POINTS:
        return f"more than {MOST_POINTS} points"
    for point in goal.points:
        if not (abs(point.x) <= FARTHEST and abs(point.y) <= FARTHEST):
            return "a point that is nowhere"
    return ""
