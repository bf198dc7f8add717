"""Which velocity the wheels get, given the commands that came and the time; pure.

The robot follows fresh commands of one sender at a time. Whoever wants to drive has to have sent a
neutral command first, and again after every stop, every silence of its own, every hand-over of
control, and every pause of the driver or of this process: nobody drives off with a stick that was
left deflected. Neutral commands of those who do not drive change nothing.

A task of navigation's own holds the wheels as a sender does, but needs no neutral command: it is
begun by an event, not by a stick. It never takes over from somebody who drives; anybody who wants
to move takes over from it. While the driver is silent, and after this process was away, the wheels
of a task stand. The task keeps them, and may steer again when everything is fresh.
"""

from __future__ import annotations

import math

from hub.gcm.navigation import Cause, MotionState

SILENCE_S = 0.3
"""Time without a fresh command after which the robot is stopped [s]."""
ARMED_S = 1.0
"""Time without any command after which a sender has to send neutral again [s]."""
DRIVER_SILENCE_S = 0.5
"""Time without a report after which the driver counts as gone [s]."""
STALL_S = 0.3
"""A longer pause between two looks means that this process itself was away [s]."""
DEAF_S = 0.1
"""How long after such a pause commands are taken for old ones [s]."""
SETTLE_S = 0.2
"""A task steers again when nothing was missing for this time [s]."""
_MAX_SENDERS = 256
_COUNTS = 1 << 32


class SpeedGovernor:
    """Decides on the velocity; every method gets the present monotonic time [s].

    Attributes:
        refused: Commands that were not followed: not finite, old, not from neutral, or from
            somebody else while one drives.
        held: Why the wheels of a task stand; NONE: it may steer.
        stops: Counts how often whoever drives had to become neutral first; 32 bits.
    """

    def __init__(
        self,
        linear_limit: float,
        angular_limit: float,
        now: float,
        *,
        silence_s: float = SILENCE_S,
        stops: int = 0,
    ) -> None:
        self._linear_limit = linear_limit
        self._angular_limit = angular_limit
        self._silence_s = silence_s
        self._state = MotionState.WAITING
        self._velocity = (0.0, 0.0)
        self._armed: dict[int, float] = {}
        self._sender: int | None = None
        self._fresh_until = now
        self._driver_until = now
        self._looked = now
        self._deaf_until = now
        self._settled_at = now
        self.refused = 0
        self.held = Cause.NONE
        self.stops = stops

    def command(
        self, sender: int, linear: float, angular: float, measured: float, now: float
    ) -> None:
        """Somebody wants a velocity [m/s, rad/s], given at `measured`."""
        self._look(now)
        usable = math.isfinite(linear) and math.isfinite(angular)
        if not usable or now < self._deaf_until or measured + self._silence_s <= now:
            self.refused += 1
        elif linear == 0.0 and angular == 0.0:
            self._neutral(sender, now)
        elif self._may_drive(sender, now):
            self._armed[sender] = now
            self._sender = sender
            self._state = MotionState.MOVING
            self._fresh_until = measured + self._silence_s
            self._velocity = self._limited(linear, angular)
        else:
            self.end_task()
            self.refused += 1

    def begin_task(self, now: float) -> str:
        """A task wants the wheels; returns why it does not get them, empty if it does."""
        self._look(now)
        if now >= self._driver_until:
            return "the driver does not report"
        if self._sender is not None:
            return "somebody drives"
        self._halt(MotionState.GOING)
        self._fresh_until = now + self._silence_s
        return ""

    def steer(self, linear: float, angular: float, now: float) -> None:
        """The task wants a velocity [m/s, rad/s]; it has to say so again before long."""
        self._look(now)
        if self._state is MotionState.GOING and self.held is Cause.NONE:
            self._fresh_until = now + self._silence_s
            self._velocity = self._limited(linear, angular)

    def end_task(self) -> None:
        """The task has ended."""
        if self._state is MotionState.GOING:
            self._halt(MotionState.STANDING)

    @property
    def has_task(self) -> bool:
        """Whether a task has the wheels, also while they are held."""
        return self._state is MotionState.GOING

    @property
    def driver(self) -> int:
        """Who sends the commands that are followed; 0: nobody."""
        return self._sender or 0

    def stop(self) -> None:
        """Somebody wants the robot to stop: it stands until neutral comes."""
        self._disarm(MotionState.STOPPED)

    def driver_began_anew(self) -> None:
        """Another driver reports than before: who drives has to send a neutral command first."""
        if self.has_task:
            self._armed.clear()
            self._count_stop()
            self._hold(Cause.DRIVER, self._looked)
        else:
            self._disarm(MotionState.WAITING)

    def controlled_by(self, owner: int, before: int) -> None:
        """Somebody else has control than before, by numbers; 0: nobody.

        The robot stands until the new owner sends neutral, unless that is who drives already. It
        stands as well when it becomes free while it is driven; a task of its own goes on then.
        """
        if (owner and before) or self._sender not in (owner, None):
            self._disarm(MotionState.WAITING)

    def driver_reported(self, now: float) -> None:
        """The driver lives."""
        self._look(now)
        self._driver_until = now + DRIVER_SILENCE_S

    def velocity(self, now: float) -> tuple[float, float]:
        """What the wheels get now [m/s, rad/s]."""
        self._look(now)
        return self._velocity

    def state(self, now: float) -> MotionState:
        """What is done with commands now."""
        self._look(now)
        return MotionState.NO_DRIVER if now >= self._driver_until else self._state

    def _neutral(self, sender: int, now: float) -> None:
        if len(self._armed) >= _MAX_SENDERS:
            self._armed.clear()
        self._armed[sender] = now
        if self._sender in (sender, None) and self._state is not MotionState.GOING:
            self._halt(MotionState.STANDING)

    def _may_drive(self, sender: int, now: float) -> bool:
        armed = now - self._armed.get(sender, -math.inf) < ARMED_S
        return armed and self._sender in (sender, None) and now < self._driver_until

    def _limited(self, linear: float, angular: float) -> tuple[float, float]:
        return (
            max(-self._linear_limit, min(self._linear_limit, linear)),
            max(-self._angular_limit, min(self._angular_limit, angular)),
        )

    def _disarm(self, state: MotionState) -> None:
        """Stop; everybody has to send neutral before they drive again."""
        self._halt(state)
        self._armed.clear()
        self._count_stop()

    def _count_stop(self) -> None:
        self.stops = (self.stops + 1) % _COUNTS

    def _halt(self, state: MotionState) -> None:
        self._state = state
        self._velocity = (0.0, 0.0)
        self._sender = None
        self.held = Cause.NONE

    def _hold(self, cause: Cause, now: float) -> None:
        """The wheels of a task stand."""
        self.held = cause
        self._velocity = (0.0, 0.0)
        self._settled_at = now + SETTLE_S

    def _look(self, now: float) -> None:
        """See what the time that has gone by has changed."""
        away = now - self._looked > STALL_S
        self._looked = now
        if away:
            self._deaf_until = now + DEAF_S
        if self.has_task:
            self._look_at_task(now, away=away)
            return
        if self._sender is None:
            return
        if away or now >= self._driver_until:
            self.stop()
        elif now >= self._fresh_until:
            self._armed.pop(self._sender or 0, None)
            self._halt(MotionState.SILENCE)
            self._count_stop()

    def _look_at_task(self, now: float, *, away: bool) -> None:
        """Hold the wheels of a task while something is missing, and let it steer again."""
        silent = now >= self._driver_until
        if away or (silent and now < self._deaf_until):
            # Reports that came while this process was away are still on their way to it.
            self._hold(Cause.BUSY, now)
        elif silent:
            self._hold(Cause.DRIVER, now)
        elif self.held is Cause.NONE and now >= self._fresh_until:
            self._hold(Cause.BUSY, now)
        elif self.held is not Cause.NONE and now >= self._settled_at:
            self.held = Cause.NONE
            self._fresh_until = now + self._silence_s
