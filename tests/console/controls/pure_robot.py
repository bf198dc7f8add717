"""The robot's pure parts, connected as its modules connect them: who has control, speed, wheels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hub.control_gate import ControlGate
from hub.gcm.body import Freedom, Motion
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.geometry import Twist
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.ipc.message_info import MessageInfo
from hub.ipc.security.publish_rights import ROBOMON
from hub.modules.driver.watchdog import CommandWatchdog
from hub.modules.navigation.speed_governor import SpeedGovernor
from hub.robomon.control_lease import ControlLease
from hub.sim.kinematics import ANGULAR, LINEAR, approach

STEP_S = 0.02
"""How often the modules look [s]; really twice as often."""
STILL = 1e-3
DAEMON = 1
"""The number of the hub's daemon at central."""
_DRIVE_S = 0.05
_MOTIONS = (
    Motion(freedom=Freedom.SURGE, limit=0.5, acceleration=2.0),
    Motion(freedom=Freedom.YAW, limit=1.0, acceleration=4.0),
)


class Bus:
    """What a gate needs of a client."""

    def __init__(self) -> None:
        self.published: list[Any] = []
        self.hears: dict[str, Callable[[Any, MessageInfo], None]] = {}

    def define(self, *definitions: object) -> None:
        """All are known."""

    def subscribe(self, definition: Any, handler: Any, **how: object) -> None:
        del how
        self.hears[definition.name] = handler

    @property
    def directory(self) -> Bus:
        return self

    def follow(self, module: str, learn: Callable[[int], None]) -> None:
        assert module == ROBOMON
        learn(DAEMON)

    def publish(self, definition: object, value: object) -> None:
        del definition
        self.published.append(value)


class Robot:
    """Central's arbiter, navigation, driver and wheels.

    Attributes:
        commanded: The velocity that the wheels are commanded [m/s, rad/s].
        true: Their velocity [m/s, rad/s].
        navigates: Whether navigation runs.
    """

    def __init__(self) -> None:
        self.commanded = self.true = (0.0, 0.0)
        self._bus = Bus()
        self.restart(0.0)

    def began(self, now: float) -> None:
        """Navigation begins, perhaps anew."""
        self._governor = SpeedGovernor(_MOTIONS, now)
        bus: Any = self._bus
        self._gate = ControlGate(bus, self._handed_over)
        self._wanted = Twist()
        self._driven = now
        self._owner = 0
        self.navigates = True

    def restart(self, now: float) -> None:
        """Another hub in place of the last: nobody has control of its robot."""
        self.arbiter = ControlLease(now)
        self._watchdog = CommandWatchdog()
        self.began(now)

    def command(self, sender: int, twist: Twist, measured: float, now: float) -> None:
        """A velocity command came, as navigation takes it."""
        age = max(0.0, now - measured)
        if not self.navigates or age > VELOCITY_COMMAND.lifespan_s:
            return
        if self._gate.obeys(sender):
            self._governor.command(sender, twist, now - age, now)
            self._look(now)

    def stop(self, now: float) -> None:
        """Somebody sent a stop."""
        self._governor.stop()
        self._look(now)

    def pass_time(self, now: float) -> None:
        """A look of navigation and driver."""
        self.arbiter.expire(now)
        self.tell(now)
        if self.navigates:
            self._governor.driver_reported(now)
            self._look(now)
            if now - self._driven >= _DRIVE_S - STEP_S / 2:
                self._drive(now)
        if self._watchdog.expired(now):
            self.commanded = (0.0, 0.0)
        self.true = (
            approach(self.true[0], self.commanded[0], LINEAR, STEP_S),
            approach(self.true[1], self.commanded[1], ANGULAR, STEP_S),
        )

    def tell(self, now: float) -> None:
        """The desk says who has control, when that changes."""
        owner = self.arbiter.owner.number if self.arbiter.owner else 0
        if owner != self._owner and self.navigates:
            self._owner = owner
            self._now = now
            how = MessageInfo(DAEMON, 1, 0, 0.0, now)
            self._bus.hears[CONTROL_STATE.name](ControlState(owner=owner), how)

    @property
    def owner(self) -> int:
        return self.arbiter.owner.number if self.arbiter.owner else 0

    @property
    def stops(self) -> int:
        return self._governor.stops

    @property
    def driven(self) -> bool:
        return self.commanded != (0.0, 0.0)

    @property
    def moves(self) -> bool:
        return max(map(abs, self.true)) >= STILL

    def _handed_over(self, state: ControlState, before: int) -> None:
        self._governor.controlled_by(state.owner, before)
        self._look(self._now)

    def _look(self, now: float) -> None:
        if self._governor.velocity(now) != self._wanted:
            self._drive(now)

    def _drive(self, now: float) -> None:
        self._wanted = given = self._governor.velocity(now)
        self._driven = now
        if self._watchdog.allows(now, now, neutral=given.neutral):
            self.commanded = given.linear.x, given.angular.z
