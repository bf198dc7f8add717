"""The velocity of the wheels, from the commands received and the time; pure.

One sender drives at a time. A sender is ARMED for 1 s by each command that it sends; only a neutral
command arms a sender that is not armed. So a stick that was left deflected never moves the robot.
FREE stands for WAITING, STANDING, STOPPED and SILENCE: the wheels stand and no sender drives.
GOING is a task of navigation. It needs no neutral command, because no stick begins it.

| event | FREE | MOVING | GOING |
| --- | --- | --- | --- |
| a command is not finite, late, or comes right after a pause | refuse | refuse | refuse |
| neutral command of the driving sender | - | arm, STANDING | - |
| neutral command of another sender | arm, STANDING | arm | arm |
| armed sender commands a motion | MOVING | follow the driving sender, refuse others | MOVING |
| sender that is not armed does | refuse | refuse | refuse, STANDING |
| a task begins | GOING | refuse | GOING |
| the task ends | - | - | STANDING |
| `stop` | disarm all, STOPPED | disarm all, STOPPED | disarm all, STOPPED |
| the driver process restarted | disarm all, WAITING | disarm all, WAITING | disarm all, hold |
| control passes from owner to owner | disarm all, WAITING | as FREE | as FREE |
| control begins | - | disarm all, WAITING, unless the owner drives | - |
| control ends | - | disarm all, WAITING | - |
| no fresh command for 0.3 s | - | disarm the sender, SILENCE | hold |
| no report of the driver for 0.5 s | refuse motion | disarm all, STOPPED | hold |
| this process paused for over 0.3 s | - | disarm all, STOPPED | hold |

Hold: the wheels stand and the task stays. It steers again when nothing was missing for 0.2 s.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from hub.gcm.body import Freedom, Motion
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.navigation import Cause, MotionState
from hub.own_pauses import OwnPauses

SILENCE_S = 0.3
"""Time without a fresh command after which the robot is stopped [s]."""
ARMED_S = 1.0
"""Time without any command after which a sender must send neutral again [s]."""
DRIVER_SILENCE_S = 0.5
"""Time without a report after which the driver counts as gone [s]."""
STALL_S = 0.3
"""A longer time between two updates means that this process itself paused [s]."""
IGNORE_S = 0.1
"""Time after such a pause in which commands count as old [s]."""
SETTLE_S = 0.2
"""A task steers again when nothing was missing for this time [s]."""
HELD = {
    Cause.BUSY: "navigation is too busy to steer",
    Cause.DRIVER: "the driver is silent",
}
"""The reason that a task reports while it is held."""
_MAX_SENDERS = 256
_COUNTS = 1 << 32


class SpeedGovernor:
    """Decides on the velocity; every method gets the present monotonic time [s].

    Attributes:
        refused: Number of commands refused: not finite, old, from a sender that is not armed, or
            from a second sender.
        held: Why the wheels of a task stand; NONE: it may steer.
        stops: Number of times that senders were disarmed; 32 bits.
    """

    def __init__(
        self,
        motions: Iterable[Motion],
        now: float,
        *,
        silence_s: float = SILENCE_S,
        stops: int = 0,
    ) -> None:
        """Wait for a neutral command.

        Args:
            motions: The degrees of freedom that commands move; the others are left out.
            now: The time.
            silence_s: Time without a fresh command after which the robot is stopped [s].
            stops: Where to begin to count.
        """
        self._limits = {motion.freedom: motion.limit for motion in motions}
        self._silence_s = silence_s
        self._state = MotionState.WAITING
        self._velocity = Twist()
        self._armed: dict[int, float] = {}
        self._sender: int | None = None
        self._fresh_until = now
        self._driver_until = now
        self._pauses = OwnPauses(STALL_S, stale_s=IGNORE_S)
        self._pauses.look(now)
        self._settled_at = now
        self.refused = 0
        self.held = Cause.NONE
        self.stops = stops

    def command(self, sender: int, twist: Twist, measured: float, now: float) -> None:
        """A sender commands a velocity, given at `measured`."""
        self._update(now)
        usable = all(map(math.isfinite, _parts(twist)))
        if not usable or self._pauses.is_stale(now) or measured + self._silence_s <= now:
            self.refused += 1
        elif twist.neutral:
            self._neutral(sender, now)
        elif self._may_drive(sender, now):
            self._armed[sender] = now
            self._sender = sender
            self._state = MotionState.MOVING
            self._fresh_until = measured + self._silence_s
            self._velocity = self._limited(twist)
        else:
            self.end_task()
            self.refused += 1

    def begin_task(self, now: float) -> str:
        """A task asks for the wheels; returns why it does not get them, or an empty string."""
        self._update(now)
        if now >= self._driver_until:
            return "the driver does not report"
        if self._sender is not None:
            return "somebody drives"
        self._halt(MotionState.GOING)
        self._fresh_until = now + self._silence_s
        return ""

    def steer(self, linear: float, angular: float, now: float) -> None:
        """The task commands a velocity [m/s, rad/s]; it must repeat that in time."""
        self._update(now)
        if self._state is MotionState.GOING and self.held is Cause.NONE:
            self._fresh_until = now + self._silence_s
            self._velocity = self._limited(Twist.planar(linear, angular))

    def end_task(self) -> None:
        """The task has ended."""
        if self._state is MotionState.GOING:
            self._halt(MotionState.STANDING)

    @property
    def has_task(self) -> bool:
        """Whether a task has the wheels, also while it is held."""
        return self._state is MotionState.GOING

    @property
    def driver(self) -> int:
        """Number of the sender that drives; 0: none."""
        return self._sender or 0

    def stop(self) -> None:
        """Stop the robot; it stands until a neutral command comes."""
        self._disarm(MotionState.STOPPED)

    def driver_restarted(self) -> None:
        """Another driver process reports than before: senders must send neutral again."""
        if self.has_task:
            self._armed.clear()
            self._count_stop()
            self._hold(Cause.DRIVER, self._pauses.seen)
        else:
            self._disarm(MotionState.WAITING)

    def controlled_by(self, owner: int, before: int) -> None:
        """Another client has control than before; see the table.

        Args:
            owner: Number of the new owner; 0: none.
            before: Number of the owner before; 0: none.
        """
        if (owner and before) or self._sender not in (owner, None):
            self._disarm(MotionState.WAITING)

    def driver_reported(self, now: float) -> None:
        """The driver sent a report."""
        self._update(now)
        self._driver_until = now + DRIVER_SILENCE_S

    def velocity(self, now: float) -> Twist:
        """The velocity of the wheels now."""
        self._update(now)
        return self._velocity

    def state(self, now: float) -> MotionState:
        """The state of motion now, as published."""
        self._update(now)
        return MotionState.NO_DRIVER if now >= self._driver_until else self._state

    @property
    def deadline(self) -> float:
        """Next time at which the wheels must stand if nothing comes [s]; inf: they stand."""
        if self._sender is None and (not self.has_task or self.held is not Cause.NONE):
            return math.inf
        return min(self._fresh_until, self._driver_until)

    def _neutral(self, sender: int, now: float) -> None:
        if len(self._armed) >= _MAX_SENDERS:
            self._armed.clear()
        self._armed[sender] = now
        if self._sender in (sender, None) and self._state is not MotionState.GOING:
            self._halt(MotionState.STANDING)

    def _may_drive(self, sender: int, now: float) -> bool:
        armed = now - self._armed.get(sender, -math.inf) < ARMED_S
        return armed and self._sender in (sender, None) and now < self._driver_until

    def _limited(self, twist: Twist) -> Twist:
        """What the body can do of a velocity."""
        limits = [self._limits.get(freedom, 0.0) for freedom in Freedom]
        parts = zip(_parts(twist), limits, strict=True)
        surge, sway, heave, roll, pitch, yaw = (max(-most, min(most, part)) for part, most in parts)
        return Twist(
            linear=Vector3(x=surge, y=sway, z=heave), angular=Vector3(x=roll, y=pitch, z=yaw)
        )

    def _disarm(self, state: MotionState) -> None:
        """Stop; every sender must send neutral before it drives again."""
        self._halt(state)
        self._armed.clear()
        self._count_stop()

    def _count_stop(self) -> None:
        self.stops = (self.stops + 1) % _COUNTS

    def _halt(self, state: MotionState) -> None:
        self._state = state
        self._velocity = Twist()
        self._sender = None
        self.held = Cause.NONE

    def _hold(self, cause: Cause, now: float) -> None:
        """Stop the wheels and keep the task."""
        self.held = cause
        self._velocity = Twist()
        self._settled_at = now + SETTLE_S

    def _update(self, now: float) -> None:
        """Apply the time limits of the table."""
        away = self._pauses.look(now) > 0.0
        if self.has_task:
            self._update_task(now, away=away)
            return
        if self._sender is None:
            return
        if away or now >= self._driver_until:
            self.stop()
        elif now >= self._fresh_until:
            self._armed.pop(self._sender or 0, None)
            self._halt(MotionState.SILENCE)
            self._count_stop()

    def _update_task(self, now: float, *, away: bool) -> None:
        """Hold a task while something is missing; release it when all is fresh again."""
        silent = now >= self._driver_until
        if away or (silent and self._pauses.is_stale(now)):
            # Reports that came during the pause are not read yet.
            self._hold(Cause.BUSY, now)
        elif silent:
            self._hold(Cause.DRIVER, now)
        elif self.held is Cause.NONE and now >= self._fresh_until:
            self._hold(Cause.BUSY, now)
        elif self.held is not Cause.NONE and now >= self._settled_at:
            self.held = Cause.NONE
            self._fresh_until = now + self._silence_s


def _parts(twist: Twist) -> tuple[float, ...]:
    """The velocities in the order of `Freedom`."""
    linear, angular = twist.linear, twist.angular
    return linear.x, linear.y, linear.z, angular.x, angular.y, angular.z
