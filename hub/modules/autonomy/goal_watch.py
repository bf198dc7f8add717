"""Tracks the goal that was sent to navigation; pure."""

from __future__ import annotations

import enum
import math

from hub.gcm.navigation import Cause, NavigationStatus, Task
from hub.modules.autonomy.autonomy_task import Target

ACCEPTED_S = 1.5
"""Time in which navigation must accept a goal [s]."""
MAX_SENDS = 3
"""Number of tries to send a goal."""
LONGEST_S = 180.0
"""A goal is blocked after this time without headway [s]."""
NEARER = 0.1
"""Headway: the robot came nearer by this [m]."""
AT_ONCE_S = 1.0
"""A goal that ended sooner was not begun [s]."""


class Outcome(enum.Enum):
    """The state of a goal.

    Attributes:
        NONE: There is none.
        SENT: Navigation has not accepted it yet.
        GOING: Navigation drives to it.
        REACHED: The robot is there.
        BLOCKED: There is no path to it.
        CANCELLED: An operator or another client ended it.
        GIVEN_UP: Navigation was held for too long.
        REPLACED: Another client sent another goal.
        UNHEARD: Navigation has not accepted it in time.
        LOST: Navigation restarted, or could not begin it.
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
        target: The goal; None: there is none.
        left: Number of its points that are left.
        distance: Length of the path that is left [m]; NaN: not known.
        why: Navigation's reason for its end or its wait.
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
        self._sends = 0
        self._number = -1

    def send(self, target: Target, now: float) -> None:
        """Note that this goal is sent now."""
        again = target is self.target and self._outcome in (Outcome.SENT, Outcome.UNHEARD)
        self._sends = self._sends + 1 if again else 1
        self.target, self.left = target, len(target.points)
        self.distance, self._nearest = math.nan, math.inf
        self.why, self.cause = "", Cause.NONE
        self._outcome, self._after, self._sent = Outcome.SENT, self._number, now

    def forget(self) -> None:
        """Drop the goal."""
        self.target = None
        self.distance, self.why, self.cause = math.nan, "", Cause.NONE
        self._outcome = Outcome.NONE

    def on_status(self, status: NavigationStatus, now: float, *, mine: bool) -> None:
        """Take the status of navigation; `mine`: its task comes from autonomy."""
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
        """The state of the goal at `now` [s]."""
        waited = now - self._sent
        if self._outcome is Outcome.SENT and waited > ACCEPTED_S:
            return Outcome.UNHEARD
        if self._outcome is Outcome.GOING and waited > LONGEST_S:
            return Outcome.BLOCKED
        return self._outcome

    @property
    def may_send_again(self) -> bool:
        """Whether to send a goal again that was not accepted."""
        return self._sends < MAX_SENDS


def _outcome_of(status: NavigationStatus) -> Outcome:
    """The state of a goal by this status of navigation."""
    held = (Cause.BUSY, Cause.DRIVER, Cause.TILTED, Cause.BLIND)
    if status.task is Task.CANCELLED and status.cause in held:
        return Outcome.LOST if status.seconds < AT_ONCE_S else Outcome.GIVEN_UP
    return _OUTCOMES[status.task]
