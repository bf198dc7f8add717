"""What became of the goal that navigation was sent; pure."""

from __future__ import annotations

import enum
import math

from hub.gcm.navigation import Cause, NavigationStatus, Task
from hub.modules.autonomy.errands import Target

ACCEPTED_S = 1.5
"""Navigation has to have taken a goal after this time [s]."""
SENDINGS = 3
"""So often a goal is sent before navigation is taken to be deaf."""
LONGEST_S = 180.0
"""A goal that the robot comes no nearer to for this time counts as blocked [s]."""
NEARER = 0.1
"""Coming nearer by this is headway [m]."""
AT_ONCE_S = 1.0
"""A goal that ended sooner than this was not begun [s]."""


class Outcome(enum.Enum):
    """What became of a goal.

    Attributes:
        NONE: There is none.
        SENT: Navigation has not said that it has it.
        GOING: It is under way.
        REACHED: It is there.
        BLOCKED: It could not get there.
        CANCELLED: Somebody ended it.
        GIVEN_UP: Navigation could not steer for too long.
        REPLACED: Somebody sent navigation elsewhere.
        UNHEARD: Navigation has not taken it in time.
        LOST: Navigation knows nothing of it any more, or could not begin it.
    """

    NONE = enum.auto()
    SENT = enum.auto()
    GOING = enum.auto()
    REACHED = enum.auto()
    BLOCKED = enum.auto()
    CANCELLED = enum.auto()
    GIVEN_UP = enum.auto()
    REPLACED = enum.auto()
    UNHEARD = enum.auto()
    LOST = enum.auto()


_OUTCOMES = {
    Task.NONE: Outcome.CANCELLED,
    Task.GOING: Outcome.GOING,
    Task.TURNING: Outcome.GOING,
    Task.REACHED: Outcome.REACHED,
    Task.BLOCKED: Outcome.BLOCKED,
    Task.CANCELLED: Outcome.CANCELLED,
}


class GoalWatch:
    """Follows one goal from its sending to its end.

    Attributes:
        target: The goal; None if there is none.
        left: Points of it that are left.
        distance: Length of the way that is left [m]; NaN: not known.
        why: What navigation says of its end, or of what it waits for.
        cause: The same for programs.
    """

    def __init__(self) -> None:
        self.target: Target | None = None
        self.left = 0
        self.distance = math.nan
        self.why = ""
        self.cause = Cause.NONE
        self._nearest = math.inf
        self._outcome = Outcome.NONE
        self._after = -1
        self._sent = 0.0
        self._sendings = 0
        self._number = -1

    def send(self, target: Target, now: float) -> None:
        """This goal is sent now."""
        again = target is self.target and self._outcome in (Outcome.SENT, Outcome.UNHEARD)
        self._sendings = self._sendings + 1 if again else 1
        self.target, self.left = target, len(target.points)
        self.distance, self._nearest = math.nan, math.inf
        self.why, self.cause = "", Cause.NONE
        self._outcome, self._after, self._sent = Outcome.SENT, self._number, now

    def forget(self) -> None:
        """There is no goal any more."""
        self.target = None
        self.distance, self.why, self.cause = math.nan, "", Cause.NONE
        self._outcome = Outcome.NONE

    def heard(self, status: NavigationStatus, now: float, *, mine: bool) -> None:
        """Navigation says what it does; `mine`: the task it speaks of is or was ours."""
        self._number = status.number
        if self._outcome not in (Outcome.SENT, Outcome.GOING):
            return
        if mine and status.number > self._after:
            self._outcome = _outcome_of(status)
            if status.points_left < self.left or status.distance_left < self._nearest - NEARER:
                self._nearest, self._sent = status.distance_left, now
            self.left, self.distance = status.points_left, status.distance_left
            self.why, self.cause = status.why, status.cause
        elif not mine and status.number > self._after and status.task is not Task.NONE:
            self._outcome = Outcome.REPLACED
        elif not mine and self._outcome is Outcome.GOING:
            self._outcome = Outcome.LOST

    def outcome(self, now: float) -> Outcome:
        """What became of it, at `now` [s]."""
        waited = now - self._sent
        if self._outcome is Outcome.SENT and waited > ACCEPTED_S:
            return Outcome.UNHEARD
        if self._outcome is Outcome.GOING and waited > LONGEST_S:
            return Outcome.BLOCKED
        return self._outcome

    @property
    def may_send_again(self) -> bool:
        """Whether a goal that was not taken is worth another sending."""
        return self._sendings < SENDINGS


def _outcome_of(status: NavigationStatus) -> Outcome:
    """What became of a goal of which navigation says this."""
    if status.task is Task.CANCELLED and status.cause in (Cause.BUSY, Cause.DRIVER):
        return Outcome.LOST if status.seconds < AT_ONCE_S else Outcome.GIVEN_UP
    return _OUTCOMES[status.task]
