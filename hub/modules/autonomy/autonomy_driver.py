"""Runs the task of autonomy, below the operator; pure: state and time are passed in.

| state | event | action |
| --- | --- | --- |
| any | a command with a behaviour | begin its task, or refuse it |
| any | a command HOLD | end the task |
| task | an operator drives, after `RELEASE_S` | end the task: taken over |
| task | another client sends a goal, or gets control | end the task: taken over |
| task | a stop | end the task: stopped |
| task | the vehicle does not follow any more | end the task: lost |
| task | robot, map or navigation is silent or old | stand and wait |
| waiting | all is fresh again | go on, if the robot was neither stopped nor moved |
| waiting | `DATA_TIMEOUT_S` is over | end the task: lost |
| task | the robot loses its place | end the task: lost |
| task | the target is reached or blocked | report it to the task, which chooses the next target |
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from hub.gcm import autonomy
from hub.gcm.autonomy import AutonomyCommand, AutonomyState, Behaviour, Phase
from hub.gcm.navigation import (
    Cause,
    GoalCommand,
    MotionState,
    NavigationStatus,
    Point,
    RobotState,
)
from hub.grids.grid import Grid
from hub.modules.autonomy.autonomy_task import NOWHERE, AutonomyTask, End, Sight, Target, Visit
from hub.modules.autonomy.exploring import Explore
from hub.modules.autonomy.goal_watch import GoalWatch, Outcome
from hub.modules.autonomy.novelty import Limits
from hub.modules.autonomy.senses import MAP_PERIOD_S, Senses
from hub.modules.autonomy.wandering import Wander
from hub.own_pauses import OwnPauses

MOST_POINTS = 100
FARTHEST_POINT = 1000.0
"""Largest coordinate of a point in `map` [m]."""
START = Point(x=0.0, y=0.0)
"""The robot's start: the origin of `odom` and of `map`."""
RELEASE_S = 1.0
"""Time after a command in which the operator may still release the stick [s]."""
DATA_TIMEOUT_S = 60.0
"""Longest time that a task waits for fresh data [s]."""
STALL_S = 0.5
"""A longer time between two calls means that this process itself paused [s]."""
SETTLE_S = 0.3
"""Messages from such a pause are read within this time [s]."""
JUMP = 0.5
"""A robot that moved farther than this during its silence is lost [m]."""
SENSING_S = 0.5
"""Time for the sensors at the end of a path [s]."""
STOP_AGAIN_S = 0.5
"""Time until a stop is sent again, if navigation goes on [s]."""

_TAKEN_OVER = "the operator took over"
_OVER = (Outcome.REACHED, Outcome.BLOCKED, Outcome.LOST)


class AutonomyDriver:
    """Decides on the goals of navigation; every method gets the present monotonic time [s]."""

    def __init__(self, *, radius: float, seed: int, limits: Limits | None = None) -> None:
        """Start without a task.

        Args:
            radius: The robot's, with the margin it must keep [m].
            seed: Of random choices.
            limits: Limits at which exploring ends although frontiers are left.
        """
        self._radius = radius
        self._limits = limits or Limits()
        self._seed = seed
        self._senses = Senses()
        self._watch = GoalWatch()
        self._behaviour = Behaviour.HOLD
        self._task: AutonomyTask | None = None
        self._why = "there was no command yet"
        self._phase = Phase.IDLE
        self._asked, self._commands = Behaviour.HOLD, 0
        self._began = self._ended = math.nan
        self._explored = NOWHERE
        self._pauses = OwnPauses(STALL_S, stale_s=SETTLE_S)
        self._left_at: tuple[float, float] | None = None
        self._commanded = self._asked_map = self._stopped = -math.inf
        self._waits_since: float | None = None
        self._map_used = self._map_left = 0
        self._drives_for_autonomy = self._stop_due = self._sent_elsewhere = False
        self._interrupted = False
        self._number = -1

    # Input.

    def command(self, command: AutonomyCommand, now: float, refusal: str = "") -> None:
        """Take a command; `refusal`: why the robot cannot carry it out, for people."""
        self._stop_due = self._watch.target is not None
        self._watch.forget()
        self._commanded, self._waits_since = now, None
        # The command replaces an earlier goal of another client.
        self._number = self._senses.status.number if self._senses.status else -1
        self._sent_elsewhere = self._interrupted = False
        self._asked_map = -math.inf
        wrong = _mistake(command) or refusal
        if command.behaviour is Behaviour.HOLD and not wrong:
            self._end(Phase.IDLE if self._task is None else Phase.STOPPED, "asked to hold", now)
            return
        self._asked, self._began, self._explored = command.behaviour, now, NOWHERE
        self._commands += 1
        if wrong:
            self._end(Phase.REFUSED, wrong, now)
            return
        self._behaviour, self._phase, self._ended = command.behaviour, Phase.ACTIVE, math.nan
        self._task = self._task_of(command.behaviour, command.points)
        self._why = "begins"

    def see_robot(self, state: RobotState, measured: float) -> None:
        """Take the state of the robot, measured at that time [s]."""
        before = self._senses.state
        self._senses.see_robot(state, measured)
        if self._task is not None and before is not None and 0 != before.frame != state.frame != 0:
            self._end(Phase.LOST, "the robot has lost its place", measured)
            self._stop_due = self._watch.target is not None
            self._watch.forget()
        ready = before is not None and before.motion is not MotionState.STOPPED
        between = self._watch.target is None and not self._interrupted
        # A stop may reach navigation alone. A stop from before the command does not count.
        if (
            state.motion is MotionState.STOPPED
            and ready
            and between
            and measured - self._commanded > RELEASE_S
        ):
            self.see_stop("navigation got a stop", measured)

    def see_navigation(self, status: NavigationStatus, now: float, *, mine: bool) -> None:
        """Take the status of navigation; `mine`: its task comes from autonomy."""
        self._senses.see_navigation(status, now)
        self._watch.on_status(status, now, mine=mine)
        under_way = self._senses.under_way
        self._drives_for_autonomy = mine and under_way
        self._number = min(self._number, status.number)
        self._sent_elsewhere = under_way and not mine and status.number > self._number

    def see_map(self, grid: Grid, now: float) -> None:
        """Take the newest map."""
        self._senses.see_map(grid, now)

    def miss_map(self, why: str) -> None:
        """Note that there is no map, or that it is damaged."""
        self._senses.miss_map(why)

    def see_stick(self, now: float) -> None:
        """Note that another client commanded a motion."""
        self._senses.see_stick(now)

    def see_stop(self, reason: str, now: float) -> None:
        """Take a stop, which navigation gets too."""
        if self._task is not None:
            self._end(Phase.STOPPED, f"stopped: {reason or 'no reason given'}", now)
            self._watch.forget()

    def see_other(self, why: str, now: float, phase: Phase = Phase.TAKEN_OVER) -> None:
        """End the task: the robot has a new owner of control, or cannot go on."""
        if self._task is not None:
            self._yield(why, now, phase)

    # Output.

    def wants_map(self, now: float) -> bool:
        """Whether to request a map now; true once for each request."""
        needed = self._task is not None and self._task.needs_map
        if not needed or now - self._asked_map < MAP_PERIOD_S:
            return False
        self._asked_map = now
        return True

    def act(self, now: float) -> GoalCommand | None:
        """The goal to send to navigation now; a goal without points stops it."""
        if self._task is not None:
            self._check_for_takeover(now)
        if self._task is None:
            return self._stop(now)
        self._pauses.look(now)
        if self._pauses.is_stale(now):  # messages from the pause are not read yet
            return None
        trouble = self._senses.fault(now, needs_map=self._task.needs_map)
        if not trouble and self._senses.driven(now):
            trouble = "the operator still drives"
        if trouble:
            return self._wait(trouble, now)
        self._waits_since = None
        if self._interrupted:
            self._check_after_wait(now)
        self._interrupted, self._left_at = False, None
        if self._task is not None:
            self._judge(self._task, now)
        if self._task is None:
            return self._stop(now)
        return self._go(self._task, now)

    def state(self, now: float) -> AutonomyState:
        """The state for the bus."""
        task, target = self._task, self._watch.target
        goal = target.points[-1] if target is not None and task is not None else None
        if self._senses.driven(now):
            pilot = autonomy.DrivingMode.OPERATOR
        else:
            drives = self._drives_for_autonomy
            pilot = autonomy.DrivingMode.AUTONOMY if drives else autonomy.DrivingMode.NOBODY
        over = task is None
        waits = not over and bool(self._watch.why) and self._watch.cause is not Cause.NONE
        until = self._ended if over else now
        return AutonomyState(
            behaviour=self._behaviour,
            pilot=pilot,
            x=goal.x if goal else NOWHERE,
            y=goal.y if goal else NOWHERE,
            frontier_m=task.frontier_m if task else NOWHERE,
            why=self._watch.why if waits else self._why,
            phase=Phase.WAITING if waits else self._phase,
            asked=self._asked,
            number=self._commands,
            explored=task.explored if task else self._explored,
            distance_m=self._watch.distance if goal else NOWHERE,
            seconds=until - self._began if math.isfinite(until - self._began) else 0.0,
            ended_s=now - self._ended if over else NOWHERE,
        )

    # Inside.

    def _task_of(self, behaviour: Behaviour, points: Sequence[Point]) -> AutonomyTask:
        if behaviour is Behaviour.EXPLORE:
            return Explore(self._radius, self._limits)
        if behaviour is Behaviour.WANDER:
            self._seed += 1
            return Wander(self._radius, self._seed)
        if behaviour is Behaviour.RETURN:
            return Visit((START,), "returns to where it started")
        if behaviour is Behaviour.GO:
            return Visit(tuple(points), "goes to a point")
        return Visit(tuple(points), f"follows {len(points)} points")

    def _end(self, phase: Phase, why: str, now: float) -> None:
        """End the task, or refuse a command."""
        if self._task is not None:
            self._explored = self._task.explored
        if phase is not Phase.IDLE:
            self._ended = now
        self._behaviour, self._task, self._why = Behaviour.HOLD, None, why
        self._phase = phase
        self._waits_since = self._left_at = None

    def _check_for_takeover(self, now: float) -> None:
        """End the task if an operator or another client has taken over."""
        outcome = self._watch.outcome(now)
        if outcome is Outcome.REPLACED or self._sent_elsewhere:
            self._yield("somebody else sent the robot elsewhere", now)
        elif outcome is Outcome.CANCELLED:
            if self._watch.cause is Cause.STICK or self._senses.driven(now):
                self._yield(_TAKEN_OVER, now)
            else:
                stopped = self._watch.cause in (Cause.STOP, Cause.WITHDRAWN, Cause.NONE)
                why = self._watch.why or "somebody ended the goal"
                self._yield(why, now, Phase.STOPPED if stopped else Phase.TAKEN_OVER)
        elif self._senses.driven(now) and now - self._commanded > RELEASE_S:
            self._yield(_TAKEN_OVER, now)

    def _yield(self, why: str, now: float, phase: Phase = Phase.TAKEN_OVER) -> None:
        self._end(phase, why, now)
        self._watch.forget()

    def _wait(self, trouble: str, now: float) -> GoalCommand | None:
        """Stand until the data is fresh again, at most `DATA_TIMEOUT_S`."""
        if self._waits_since is None:
            self._waits_since = now
            state = self._senses.state
            self._left_at = None if state is None else (state.x, state.y)
        if now - self._waits_since > DATA_TIMEOUT_S:
            self._end(Phase.LOST, f"gave up after {DATA_TIMEOUT_S:.0f} s: {trouble}", now)
        else:
            self._phase, self._why = Phase.WAITING, f"waits: {trouble}"
        had_goal = self._watch.target is not None
        self._interrupted |= had_goal
        self._watch.forget()
        return self._stop(now, surely=had_goal)

    def _check_after_wait(self, now: float) -> None:
        """End the task if the robot was stopped or moved during its silence."""
        state = self._senses.state
        if state is None:
            return
        if state.motion is MotionState.STOPPED:
            self._end(Phase.STOPPED, "the robot was stopped while little was known of it", now)
        elif self._left_at is not None and math.dist(self._left_at, (state.x, state.y)) > JUMP:
            self._end(Phase.LOST, "the robot is not where it was before it fell silent", now)

    def _stop(self, now: float, *, surely: bool = False) -> GoalCommand | None:
        """Stop navigation, if it drives for autonomy."""
        due = self._drives_for_autonomy and now - self._stopped >= STOP_AGAIN_S
        if not (surely or due or self._stop_due):
            return None
        self._stopped, self._stop_due = now, False
        return GoalCommand()

    def _judge(self, task: AutonomyTask, now: float) -> None:
        """Report the outcome of the goal to the task."""
        outcome, target = self._watch.outcome(now), self._watch.target
        if target is None:
            return
        if outcome is Outcome.REACHED:
            task.reached(target, now)
        elif outcome is Outcome.BLOCKED:
            task.blocked(target, self._watch.left, now, self._watch.why)
        elif outcome is Outcome.GIVEN_UP:
            self._end(Phase.LOST, self._watch.why, now)
        elif outcome is Outcome.UNHEARD and not self._watch.may_send_again:
            self._end(Phase.LOST, "navigation does not take the goal", now)
        if outcome in _OVER or self._task is None:
            self._watch.forget()
            self._map_left = self._senses.map_number
            self._asked_map = now - MAP_PERIOD_S + SENSING_S

    def _go(self, task: AutonomyTask, now: float) -> GoalCommand | None:
        """Send navigation to the next target, or keep the present one."""
        state = self._senses.state
        if state is None:
            return None
        seen = self._senses.map_number
        grid, fresh = self._senses.grid, seen != self._map_left
        left = self._watch.distance
        sight = Sight(
            x=state.x, y=state.y, grid=grid, fresh=fresh, now=now, left=left, theta=state.theta
        )
        target = self._watch.target
        if target is not None:
            if self._watch.outcome(now) is Outcome.UNHEARD:
                return self._send(target, now)
            stays = seen == self._map_used or task.keeps(target, sight)
            self._map_used = seen
            if stays:
                self._phase, self._why = Phase.ACTIVE, target.why
                return None
        self._map_used = seen
        choice = task.choose(sight)
        if isinstance(choice, Target):
            self._phase, self._why = Phase.ACTIVE, choice.why
            return self._send(choice, now)
        self._watch.forget()
        if isinstance(choice, End):
            self._end(Phase.DONE if choice.done else Phase.BLOCKED, choice.why, now)
        else:
            self._phase = Phase.WAITING if choice.waits else Phase.ACTIVE
            self._why = choice.why
        return self._stop(now)

    def _send(self, target: Target, now: float) -> GoalCommand:
        self._watch.send(target, now)
        self._stop_due = False
        points = target.points
        return GoalCommand(points=points, patience=target.patience)


def _mistake(command: AutonomyCommand) -> str:
    """The mistake in a command, for people; empty: none."""
    points, behaviour = command.points, command.behaviour
    if behaviour is Behaviour.GO and len(points) != 1:
        return f"GO takes one point, not {len(points)}"
    if behaviour is Behaviour.FOLLOW and not 1 <= len(points) <= MOST_POINTS:
        return f"FOLLOW takes 1 to {MOST_POINTS} points, not {len(points)}"
    if not all(abs(part) <= FARTHEST_POINT for point in points for part in (point.x, point.y)):
        return f"a point is not within {FARTHEST_POINT:.0f} m"
    return ""
