"""Carries out the orders that are no motion: holds, arming, lights, joints.

| event | from | action |
| --- | --- | --- |
| DISARM | any operator | motors off, joints stop |
| ARM | the owner of control | motors on; they wait for a neutral command |
| HOLD, RELEASE, LIGHT | the owner of control | the body does it |
| DRIVE, MODE, STAY | the owner of control | the autopilot is asked; motion waits for neutral |
| JOINT | the owner of control | the joint turns, if `CommandWatchdog` allows it |
| no fresh JOINT for 0.3 s | | the joint stops, and waits for a 0 |
| `GCM_Stop` | any client | joints stop, holds keep the place of now; a body's own stop acts |
| another owner of control | | as after `GCM_Stop` |
| an order that switches on, 1 s old or of unknown age | any | refuse; say so in the log |
| an order for a part that the body lacks | any | refuse; say so in the log |
"""

from __future__ import annotations

import contextlib
import logging
import math
import time
from collections.abc import Callable, Iterable, Iterator

from hub.control_gate import ControlGate
from hub.errors import RobotFileError
from hub.gcm.autopilot import MAVLINK_REQUEST, MavlinkRequest
from hub.gcm.body import HoldKind, JointBody
from hub.gcm.control import ControlState
from hub.gcm.navigation import STOP
from hub.gcm.vehicle import (
    LATE_S,
    VEHICLE_COMMAND,
    Arming,
    HoldPhase,
    VehicleCommand,
    VehicleOrder,
    VehicleState,
    too_late,
)
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.modules.driver.watchdog import CommandWatchdog
from hub.robots.description import RobotDescription
from hub.robots.interfaces import (
    Body,
    BodyArms,
    BodyHolds,
    BodyJoints,
    BodyLights,
    BodyModes,
    BodyStops,
)

_logger = logging.getLogger(__name__)


_AGAIN_S = 0.05
"""Time until a joint that could not be stopped is stopped again [s]."""


class VehicleOrders:
    """The orders to one body."""

    def __init__(
        self,
        client: Client,
        body: Body,
        robot: RobotDescription,
        *,
        stop: Callable[[], None],
        stopped: Callable[[], None],
        changed: Callable[[ControlState], None],
    ) -> None:
        """Check that the body can do what the robot file describes.

        Args:
            client: The driver's connection.
            body: The hardware.
            robot: The robot file.
            stop: Stops the motion; after it, a neutral command must come first.
            stopped: Called after `GCM_Stop`.
            changed: Called when the owner of control changes.

        Raises:
            RobotFileError: The body lacks a part of the robot file.
        """
        if lacks := [*_lacking(body, robot)]:
            raise RobotFileError(str(robot.path), lacks)
        self._body = body
        self._stop = stop
        self._after_stop = stopped
        self._changed = changed
        self._holds = {table.kind for table in robot.holds}
        self._lights = {table.name for table in robot.lights}
        self._of_cameras = {each.name for each in robot.body.lights} - self._lights
        self._joints = {each.name: (each, CommandWatchdog()) for each in robot.body.joints}
        self._arms = body if isinstance(body, BodyArms) and robot.body.arms else None
        if self._arms is not None and not isinstance(body, BodyModes):
            self._arms.arm(armed=robot.arming is Arming.ARMED)
        self._seen = VehicleState()
        self._ordered: set[HoldKind] = set()  # holds that are on, but not yet in what was seen
        self._silence = client.alarm(self._watch)
        self._gate = ControlGate(client, self._on_owner_change)
        client.subscribe(VEHICLE_COMMAND, self._command)
        client.subscribe(STOP, lambda *_: self.stop())
        if isinstance(body, BodyModes):
            client.subscribe(MAVLINK_REQUEST, self._pass_on)

    def seen(self, state: VehicleState) -> None:
        """Take the newest state of the body."""
        self._seen = state
        self._ordered.clear()

    def stop_joints(self) -> None:
        """Stop all joints; each waits for a 0."""
        for _, watchdog in self._joints.values():
            watchdog.expire()
        self._stop_each(self._joints)

    def _pass_on(self, request: MavlinkRequest, reception: MessageInfo) -> None:
        """Give frames of another ground station to the autopilot."""
        fresh = reception.age < LATE_S
        if (
            isinstance(self._body, BodyModes)
            and self._gate.admits(MAVLINK_REQUEST, reception)
            and fresh
        ):
            self._body.pass_on(request.data.tobytes())

    def _command(self, command: VehicleCommand, reception: MessageInfo) -> None:
        order = command.order
        if order is VehicleOrder.LIGHT and command.name in self._of_cameras:
            return  # that light is vision's
        if order is not VehicleOrder.DISARM and not self._gate.admits(VEHICLE_COMMAND, reception):
            return
        if late := too_late(order, reception.age):
            _logger.warning("%s", late)
            return
        if order in (VehicleOrder.ARM, VehicleOrder.DISARM):
            self._arm(armed=order is VehicleOrder.ARM)
        elif order in (VehicleOrder.HOLD, VehicleOrder.RELEASE):
            self._hold(command.hold, on=order is VehicleOrder.HOLD, target=command.value)
        elif order is VehicleOrder.LIGHT:
            self._light(command.name, command.value)
        elif order in (VehicleOrder.DRIVE, VehicleOrder.MODE, VehicleOrder.STAY):
            self._mode(order, command.name)
        else:
            self._joint(command, time.monotonic(), reception.age)

    def _arm(self, *, armed: bool) -> None:
        if self._arms is None:
            _logger.warning("an order to arm or disarm is refused: this body cannot")
            return
        _logger.warning("an order comes to %s the motors", "arm" if armed else "disarm")
        try:
            self.stop_joints()
            self._stop()
        finally:  # the motors go off also after a fault
            if not armed:
                self._arms.arm(armed=False)
        if armed:
            self._arms.arm(armed=True)

    def _mode(self, order: VehicleOrder, name: str) -> None:
        """Ask an autopilot for a mode."""
        if not isinstance(self._body, BodyModes):
            _logger.warning("an order is refused: this body has no modes")
            return
        self.stop_joints()
        self._stop()
        if order is VehicleOrder.MODE:
            _logger.warning("asks the autopilot for the mode %r", name)
            self._body.set_mode(name)
        elif order is VehicleOrder.STAY:
            _logger.warning("asks the autopilot to stay where it is")
            self._body.stay()
        else:
            _logger.warning("asks the autopilot for the mode that follows velocities")
            self._body.drive()

    def _hold(self, kind: HoldKind, *, on: bool, target: float) -> None:
        if kind not in self._holds or not isinstance(self._body, BodyHolds):
            _logger.warning("an order is refused: this body has no hold of its %s", _word(kind))
        elif on:
            _logger.info("holds its %s", _word(kind))
            self._ordered.add(kind)
            self._body.hold(kind, target)
        else:
            _logger.info("releases its %s", _word(kind))
            self._ordered.discard(kind)
            self._body.release(kind)

    def _light(self, name: str, brightness: float) -> None:
        if name not in self._lights or not isinstance(self._body, BodyLights):
            _logger.warning("an order is refused: there is no light %r", name)
        elif not math.isnan(brightness):
            self._body.set_light(name, max(0.0, min(1.0, brightness)))

    def _joint(self, command: VehicleCommand, now: float, age: float) -> None:
        known = self._joints.get(command.name)
        if known is None:
            _logger.warning("an order is refused: there is no joint %r", command.name)
            return
        joint, watchdog = known
        rate = _limited(command.value, joint)
        if watchdog.allows(now - age, now, neutral=rate == 0.0):
            self._silence.due = min(self._silence.due, watchdog.deadline)
            self._turn(command.name, rate)

    def _turn(self, name: str, rate: float) -> None:
        if isinstance(self._body, BodyJoints):
            self._body.turn_joint(name, rate)

    def _watch(self) -> None:
        """Stop the joints whose orders ended."""
        now = time.monotonic()
        ended = [
            name
            for name, (_, watchdog) in self._joints.items()
            if watchdog.expired(now) and watchdog.deadline > -math.inf
        ]
        self._silence.due = now + _AGAIN_S  # if a joint cannot be stopped now
        self._stop_each(ended)
        for name in ended:
            self._joints[name][1].expire()
        deadlines = (watchdog.deadline for _, watchdog in self._joints.values())
        self._silence.due = min((each for each in deadlines if each > now), default=math.inf)

    def _stop_each(self, names: Iterable[str]) -> None:
        """Stop joints; a fault of one does not keep the others from it."""
        with contextlib.ExitStack() as stack:
            for name in names:
                stack.callback(self._turn, name, 0.0)

    def stop(self) -> None:
        """Stop what the body does besides driving, as a stop from any client does."""
        with contextlib.ExitStack() as stack:
            stack.callback(self._after_stop)
            stack.callback(self._stopped)
            if isinstance(self._body, BodyStops):
                self._body.stop()

    def _stopped(self) -> None:
        try:
            self.stop_joints()
        finally:
            self._hold_here()

    def _hold_here(self) -> None:
        """Let the holds that are on keep the place of now."""
        if isinstance(self._body, BodyHolds):
            on = {hold.kind for hold in self._seen.holds if hold.phase is not HoldPhase.OFF}
            for kind in sorted(on | self._ordered):
                self._body.hold(kind, math.nan)

    def _on_owner_change(self, state: ControlState, _before: int) -> None:
        try:
            self._stopped()
        finally:
            self._changed(state)


def _lacking(body: Body, robot: RobotDescription) -> Iterator[str]:
    """What the robot file describes and the body lacks, a sentence each."""
    for described, part, name in (
        (robot.holds, BodyHolds, "[[hold]]"),
        (robot.lights, BodyLights, "[[light]]"),
        (robot.joints, BodyJoints, "[[joint]]"),
        (robot.arming is not Arming.NONE, BodyArms, "[body] arming"),
    ):
        if described and not isinstance(body, part):
            yield f"{name}: the kind {robot.kind!r} has none"


def _limited(rate: float, joint: JointBody) -> float:
    """A rate within the joint's largest [rad/s]; NaN is 0."""
    return 0.0 if math.isnan(rate) else max(-joint.speed, min(joint.speed, rate))


def _word(kind: HoldKind) -> str:
    return kind.name.lower()
