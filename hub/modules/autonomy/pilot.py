"""What the robot does by itself, under the operator, given what is known and the time; pure.

A command starts an errand. The errand gives targets, which navigation is sent to one at a time.
Whatever an operator does ends it: a velocity command that is not neutral, a stop, a goal of
somebody else. While something that has to be known is old or missing the robot stands; when it
comes back within a minute the errand goes on, otherwise it ends.
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
from hub.modules.autonomy.errands import NOWHERE, End, Errand, Sight, Target, Visit
from hub.modules.autonomy.exploring import Explore
from hub.modules.autonomy.goal_watch import GoalWatch, Outcome
from hub.modules.autonomy.novelty import Limits
from hub.modules.autonomy.senses import MAP_PERIOD_S, Senses
from hub.modules.autonomy.wandering import Wander

MOST_POINTS = 100
FARTHEST_POINT = 1000.0
"""Points farther from the origin of `map` are not gone to [m]."""
START = Point(x=0.0, y=0.0)
"""Where the robot started: the origin of `odom`, which `map` shares."""
LET_GO_S = 1.0
"""After a command the operator has this time to let go of the stick [s]."""
PATIENCE_S = 60.0
"""So long an errand waits for what it has to know [s]."""
STALL_S = 0.5
"""A longer pause between two looks means that this process itself was away [s]."""
SETTLE_S = 0.3
"""What came meanwhile reaches this process within this time after it [s]."""
JUMP = 0.5
"""A robot that is farther than this from where it was before it fell silent is lost [m]."""
LOOK_S = 0.5
"""At the end of a way the sensors have this time to see what is there [s]."""
STOP_AGAIN_S = 0.5
"""A stop is sent again after this time if navigation goes on [s]."""

_TAKEN_OVER = "the operator took over"
_OVER = (Outcome.REACHED, Outcome.BLOCKED, Outcome.LOST)


class Pilot:
    """Decides where navigation is sent; every method gets the present monotonic time [s]."""

    def __init__(self, *, radius: float, seed: int, limits: Limits | None = None) -> None:
        """Hold.

        Args:
            radius: The robot's, with the margin it must keep [m].
            seed: Of what is drawn by lot.
            limits: When exploring ends although frontiers are left.
        """
        self._radius = radius
        self._limits = limits or Limits()
        self._seed = seed
        self._senses = Senses()
        self._watch = GoalWatch()
        self._behaviour = Behaviour.HOLD
        self._errand: Errand | None = None
        self._why = "nobody has asked for anything"
        self._phase = Phase.IDLE
        self._asked, self._commands = Behaviour.HOLD, 0
        self._began = self._ended = math.nan
        self._explored = NOWHERE
        self._acted = self._back = -math.inf
        self._left_at: tuple[float, float] | None = None
        self._commanded = self._asked_map = self._stopped = -math.inf
        self._waits_since: float | None = None
        self._map_used = self._map_left = 0
        self._under_way_for_us = self._stop_due = self._sent_elsewhere = False
        self._interrupted = False
        self._number = -1

    # What comes in.

    def command(self, command: AutonomyCommand, now: float) -> None:
        """Somebody wants a behaviour."""
        self._stop_due = self._watch.target is not None
        self._watch.forget()
        self._commanded, self._waits_since = now, None
        # What somebody else had navigation do before gives way to the command.
        self._number = self._senses.status.number if self._senses.status else -1
        self._sent_elsewhere = self._interrupted = False
        self._asked_map = -math.inf
        wrong = _mistake(command)
        if command.behaviour is Behaviour.HOLD and not wrong:
            self._end(Phase.IDLE if self._errand is None else Phase.STOPPED, "asked to hold", now)
            return
        self._asked, self._began, self._explored = command.behaviour, now, NOWHERE
        self._commands += 1
        if wrong:
            self._end(Phase.REFUSED, wrong, now)
            return
        self._behaviour, self._phase, self._ended = command.behaviour, Phase.ACTIVE, math.nan
        self._errand = self._errand_of(command.behaviour, command.points)
        self._why = "begins"

    def see_robot(self, state: RobotState, measured: float) -> None:
        """What is known of the robot, measured then [s]."""
        before = self._senses.state
        self._senses.see_robot(state, measured)
        if (
            self._errand is not None
            and before is not None
            and 0 != before.frame != state.frame != 0
        ):
            self._end(Phase.LOST, "the robot has lost its place", measured)
            self._stop_due = self._watch.target is not None
            self._watch.forget()
        ready = before is not None and before.motion is not MotionState.STOPPED
        between = self._watch.target is None and not self._interrupted
        # A stop may reach navigation alone, which says so of a goal. One before a command is past.
        if (
            state.motion is MotionState.STOPPED
            and ready
            and between
            and measured - self._commanded > LET_GO_S
        ):
            self.see_stop("navigation got a stop", measured)

    def see_navigation(self, status: NavigationStatus, now: float, *, mine: bool) -> None:
        """What navigation does; `mine`: the task is or was ours."""
        self._senses.see_navigation(status, now)
        self._watch.heard(status, now, mine=mine)
        under_way = self._senses.under_way
        self._under_way_for_us = mine and under_way
        self._number = min(self._number, status.number)
        self._sent_elsewhere = under_way and not mine and status.number > self._number

    def see_map(self, grid: Grid, now: float) -> None:
        """The newest map."""
        self._senses.see_map(grid, now)

    def miss_map(self, why: str) -> None:
        """There is no map: nobody has one, or it is damaged."""
        self._senses.miss_map(why)

    def see_stick(self, now: float) -> None:
        """Somebody else sent a velocity that is not neutral."""
        self._senses.see_stick(now)

    def see_stop(self, reason: str, now: float) -> None:
        """Somebody sent a stop; navigation has got it too."""
        if self._errand is not None:
            self._end(Phase.STOPPED, f"stopped: {reason or 'no reason given'}", now)
            self._watch.forget()

    def see_other(self, why: str, now: float) -> None:
        """Somebody else has control than before; who gets it gets a robot at rest."""
        if self._errand is not None:
            self._give_way(why, now)

    # What goes out.

    def wants_map(self, now: float) -> bool:
        """Whether a map should be asked for now; true once for each time it should."""
        needed = self._errand is not None and self._errand.needs_map
        if not needed or now - self._asked_map < MAP_PERIOD_S:
            return False
        self._asked_map = now
        return True

    def act(self, now: float) -> GoalCommand | None:
        """What navigation has to be sent now; a goal without points has it stand."""
        if self._errand is not None:
            self._see_who_drives(now)
        if self._errand is None:
            return self._stop(now)
        if self._was_away(now):
            return None
        trouble = self._senses.trouble(now, needs_map=self._errand.needs_map)
        if not trouble and self._senses.driven(now):
            trouble = "the operator still drives"
        if trouble:
            return self._wait(trouble, now)
        self._waits_since = None
        if self._interrupted:
            self._look_what_happened(now)
        self._interrupted, self._left_at = False, None
        if self._errand is not None:
            self._judge(self._errand, now)
        if self._errand is None:
            return self._stop(now)
        return self._go(self._errand, now)

    def state(self, now: float) -> AutonomyState:
        """What it does, and why."""
        errand, target = self._errand, self._watch.target
        goal = target.points[-1] if target is not None and errand is not None else None
        if self._senses.driven(now):
            pilot = autonomy.DrivingMode.OPERATOR
        else:
            ours = self._under_way_for_us
            pilot = autonomy.DrivingMode.AUTONOMY if ours else autonomy.DrivingMode.NOBODY
        over = errand is None
        waits = not over and bool(self._watch.why) and self._watch.cause is not Cause.NONE
        until = self._ended if over else now
        return AutonomyState(
            behaviour=self._behaviour,
            pilot=pilot,
            x=goal.x if goal else NOWHERE,
            y=goal.y if goal else NOWHERE,
            frontier_m=errand.frontier_m if errand else NOWHERE,
            why=self._watch.why if waits else self._why,
            phase=Phase.WAITING if waits else self._phase,
            asked=self._asked,
            number=self._commands,
            explored=errand.explored if errand else self._explored,
            distance_m=self._watch.distance if goal else NOWHERE,
            seconds=until - self._began if math.isfinite(until - self._began) else 0.0,
            ended_s=now - self._ended if over else NOWHERE,
        )

    # Inside.

    def _errand_of(self, behaviour: Behaviour, points: Sequence[Point]) -> Errand:
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
        """The errand is over, or is not begun."""
        if self._errand is not None:
            self._explored = self._errand.explored
        if phase is not Phase.IDLE:
            self._ended = now
        self._behaviour, self._errand, self._why = Behaviour.HOLD, None, why
        self._phase = phase
        self._waits_since = self._left_at = None

    def _see_who_drives(self, now: float) -> None:
        """An operator comes first: whoever has taken over keeps the robot."""
        outcome = self._watch.outcome(now)
        if outcome is Outcome.REPLACED or self._sent_elsewhere:
            self._give_way("somebody else sent the robot elsewhere", now)
        elif outcome is Outcome.CANCELLED:
            if self._watch.cause is Cause.STICK or self._senses.driven(now):
                self._give_way(_TAKEN_OVER, now)
            else:
                stopped = self._watch.cause in (Cause.STOP, Cause.WITHDRAWN, Cause.NONE)
                why = self._watch.why or "somebody ended the goal"
                self._give_way(why, now, Phase.STOPPED if stopped else Phase.TAKEN_OVER)
        elif self._senses.driven(now) and now - self._commanded > LET_GO_S:
            self._give_way(_TAKEN_OVER, now)

    def _give_way(self, why: str, now: float, phase: Phase = Phase.TAKEN_OVER) -> None:
        self._end(phase, why, now)
        self._watch.forget()

    def _was_away(self, now: float) -> bool:
        """Whether this process was away a moment ago: what it missed is on its way to it."""
        if math.isfinite(self._acted) and now - self._acted > STALL_S:
            self._back = now
        self._acted = now
        return now - self._back < SETTLE_S

    def _wait(self, trouble: str, now: float) -> GoalCommand | None:
        """Stand until what is missing has come, but not for ever."""
        if self._waits_since is None:
            self._waits_since = now
            state = self._senses.state
            self._left_at = None if state is None else (state.x, state.y)
        if now - self._waits_since > PATIENCE_S:
            self._end(Phase.LOST, f"gave up after {PATIENCE_S:.0f} s: {trouble}", now)
        else:
            self._phase, self._why = Phase.WAITING, f"waits: {trouble}"
        had_goal = self._watch.target is not None
        self._interrupted |= had_goal
        self._watch.forget()
        return self._stop(now, surely=had_goal)

    def _look_what_happened(self, now: float) -> None:
        """End the errand if the robot was stopped or moved while little was known of it."""
        state = self._senses.state
        if state is None:
            return
        if state.motion is MotionState.STOPPED:
            self._end(Phase.STOPPED, "the robot was stopped while little was known of it", now)
        elif self._left_at is not None and math.dist(self._left_at, (state.x, state.y)) > JUMP:
            self._end(Phase.LOST, "the robot is not where it was before it fell silent", now)

    def _stop(self, now: float, *, surely: bool = False) -> GoalCommand | None:
        """Have navigation stand, if it is on its way for us."""
        due = self._under_way_for_us and now - self._stopped >= STOP_AGAIN_S
        if not (surely or due or self._stop_due):
            return None
        self._stopped, self._stop_due = now, False
        return GoalCommand()

    def _judge(self, errand: Errand, now: float) -> None:
        """Draw the consequences of what became of the goal."""
        outcome, target = self._watch.outcome(now), self._watch.target
        if target is None:
            return
        if outcome is Outcome.REACHED:
            errand.reached(target, now)
        elif outcome is Outcome.BLOCKED:
            errand.blocked(target, self._watch.left, now, self._watch.why)
        elif outcome is Outcome.GIVEN_UP:
            self._end(Phase.LOST, self._watch.why, now)
        elif outcome is Outcome.UNHEARD and not self._watch.may_send_again:
            self._end(Phase.LOST, "navigation does not take the goal", now)
        if outcome in _OVER or self._errand is None:
            self._watch.forget()
            self._map_left = self._senses.map_number
            self._asked_map = now - MAP_PERIOD_S + LOOK_S

    def _go(self, errand: Errand, now: float) -> GoalCommand | None:
        """Send navigation to the next target, or leave it on its way."""
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
            stays = seen == self._map_used or errand.keeps(target, sight)
            self._map_used = seen
            if stays:
                self._phase, self._why = Phase.ACTIVE, target.why
                return None
        self._map_used = seen
        choice = errand.choose(sight)
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
    """What is wrong with a command, for people; empty: nothing."""
    points, behaviour = command.points, command.behaviour
    if behaviour is Behaviour.GO and len(points) != 1:
        return f"GO takes one point, not {len(points)}"
    if behaviour is Behaviour.FOLLOW and not 1 <= len(points) <= MOST_POINTS:
        return f"FOLLOW takes 1 to {MOST_POINTS} points, not {len(points)}"
    if not all(abs(part) <= FARTHEST_POINT for point in points for part in (point.x, point.y)):
        return f"a point is not within {FARTHEST_POINT:.0f} m"
    return ""
