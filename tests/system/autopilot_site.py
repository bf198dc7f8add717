"""A simulated vehicle with an autopilot, a relay, a hub, and an operator: real processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotPhase, AutopilotState
from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import (
    CONSOLE_HEARTBEAT,
    CONTROL_REQUEST,
    CONTROL_STATE,
    ConsoleHeartbeat,
    ControlAction,
    ControlRequest,
)
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import (
    GOAL_COMMAND,
    NAVIGATION_STATUS,
    ROBOT_STATE,
    STOP,
    VELOCITY_COMMAND,
    NavigationStatus,
    RobotState,
)
from hub.gcm.vehicle import VEHICLE_COMMAND, VEHICLE_STATE, VehicleCommand, VehicleOrder
from hub.ipc.client import Client
from tests.support.mavlink_relay import MavlinkRelay
from tests.support.running_command import RunningCommand
from tests.support.waiting import Limit, until
from tests.system.harness import HubProcess, Observer

_TABLES = """
[mavlink]
address = "tcp://127.0.0.1:{port}"
[limits]
{limits}
[body]
arming = "disarmed"
radius = 0.4
"""
_SAFETY = """
[safety]
left_alone = "{}"
surface_after_s = 0.5
"""
_LIMITS = {
    "rover": "linear = 1.0\nangular = 1.0",
    "sub": "linear = 0.5\nsway = 0.5\nheave = 0.3\nangular = 0.6",
    "blimp": "linear = 0.2\nsway = 0.2\nheave = 0.2\nangular = 0.3",
}
_MODULES = ("driver", "navigation")
_EVERY_S = 0.05
_HEARTBEAT_S = 0.2


def vehicle_tables(kind: str, port: int) -> str:
    """The tables of a robot file for a vehicle at a TCP port of loopback."""
    return _TABLES.format(port=port, limits=_LIMITS[kind])


class SimulatedVehicle(RunningCommand):
    """`rune-hub sim-autopilot`.

    Attributes:
        port: Its TCP port on loopback.
    """

    def __init__(self, kind: str, parameters: Sequence[str] = (), *, booted: bool = True) -> None:
        settings = ["--parameters", *parameters] if parameters else []
        super().__init__("sim-autopilot", kind, "--tcp", "0", *["--fast-boot"] * booted, *settings)
        (address,) = self.ready["addresses"]
        self.port = int(address.rpartition(":")[2])


class Operator:
    """Somebody who holds a stick: sends a velocity again and again while the test waits.

    Attributes:
        twist: The velocity; None: nothing is sent.
        sent: How many were sent.
    """

    def __init__(self, endpoint: str, name: str) -> None:
        self.client = Client(name, endpoint)
        self.client.wait_connected(5.0)
        self.client.define(VEHICLE_COMMAND, VELOCITY_COMMAND, CONSOLE_HEARTBEAT, GOAL_COMMAND, STOP)
        self.client.wait_defined(5.0)
        self.twist: Twist | None = None
        self.sent = 0
        self.client.every(_EVERY_S, self._send)

    def _send(self) -> None:
        if self.twist is not None:
            self.client.publish(VELOCITY_COMMAND, TwistStamped.of(self.twist))
            self.sent += 1

    def order(self, order: VehicleOrder, name: str = "") -> None:
        self.client.wait_connected(5.0)  # the tests of other sites may have taken a while
        self.client.publish(VEHICLE_COMMAND, VehicleCommand(order=order, name=name))
        self.client.wait_published(5.0)

    def takes_control(self) -> None:
        """Take it, and keep it until the hub's modules know it."""
        told: list[bool] = []
        mine = ConsoleHeartbeat(holds=1)
        self.client.every(_HEARTBEAT_S, lambda: self.client.publish(CONSOLE_HEARTBEAT, mine))
        self.client.subscribe(
            CONTROL_STATE, lambda state, _: told.append(state.owner == self.client.number)
        )
        request = ControlRequest(action=ControlAction.TAKE, operator="alice")
        answer = self.client.query_response(CONTROL_REQUEST, request, COMMON_RESULT, timeout=5.0)
        assert answer.done, answer.text
        until(lambda: sum(told) >= 2, 10.0, meanwhile=lambda: self.client.listen(0.02))


class AutopilotSite:
    """All of them.

    Attributes:
        vehicle: The simulated vehicle.
        relay: Between it and the hub.
        hub: The hub.
        observer: What the hub publishes.
        operator: Who drives.
    """

    def __init__(
        self,
        folder: Path,
        kind: str = "rover",
        parameters: Sequence[str] = (),
        left_alone: str = "stand",
    ) -> None:
        self._kind, self._parameters = kind, parameters
        self.vehicle = SimulatedVehicle(kind, parameters)
        self._closing: list[Callable[[], None]] = [self._end_vehicle]
        try:
            self.relay = MavlinkRelay(self.vehicle.port)
            self._closing.append(self.relay.close)
            tables = vehicle_tables(kind, self.relay.port) + _SAFETY.format(left_alone)
            self.hub = HubProcess(folder, kind="mavlink", modules=_MODULES, tables=tables)
            self._closing.append(self.hub.close)
            states = AUTOPILOT_STATE, ROBOT_STATE, VEHICLE_STATE, NAVIGATION_STATUS
            definitions = (*states, DIAGNOSTICS)
            self.observer = Observer(self.hub.endpoint, *definitions)
            self._closing.append(self.observer.close)
            self.operator = Operator(self.hub.endpoint, "operator")
            self._closing.append(self._end_operator)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        while self._closing:
            self._closing.pop()()

    def _end_vehicle(self) -> None:
        self.vehicle.close()

    def _end_operator(self) -> None:
        self.operator.client.close()

    def start_vehicle_again(self) -> None:
        """Kill it, and start another one like it in its place."""
        self.vehicle.kill()
        self.vehicle = SimulatedVehicle(self._kind, self._parameters)
        self.relay.vehicle = self.vehicle.port

    def newest(self, definition: Any) -> Any:
        return self.observer.seen[definition.name][-1][1]

    @property
    def autopilot(self) -> AutopilotState:
        state: AutopilotState = self.newest(AUTOPILOT_STATE)
        return state

    @property
    def robot(self) -> RobotState:
        state: RobotState = self.newest(ROBOT_STATE)
        return state

    @property
    def task(self) -> NavigationStatus:
        status: NavigationStatus = self.newest(NAVIGATION_STATUS)
        return status

    @property
    def phase(self) -> AutopilotPhase:
        return self.autopilot.phase

    @property
    def problems(self) -> list[str]:
        return [each.message for each in self.newest(DIAGNOSTICS).status]

    def wait(self, condition: Callable[[], object], timeout: float = 15.0, why: str = "") -> None:
        """Until something is so; the operator goes on meanwhile."""

        def both() -> bool:
            self.operator.client.listen(0.0)
            return bool(condition())

        self.observer.wait(both, timeout, lambda: f"{why} {self.autopilot} {self.problems}")

    def go_on(self, seconds: float) -> None:
        """Let time pass, because what must not happen needs time to happen."""
        end = time.monotonic() + seconds
        self.wait(lambda: time.monotonic() >= end, seconds + 10.0)

    def drive(self) -> None:
        """Arm it, from whatever it does."""
        self.operator.twist = None
        self.relay.join()
        if self.autopilot.phase is not AutopilotPhase.DISARMED:
            self.operator.order(VehicleOrder.DISARM)
        self.wait(
            lambda: (
                self.phase is AutopilotPhase.DISARMED
                and self.autopilot.armable
                and self.autopilot.position
            ),
            why="it never was ready:",
        )
        self.operator.order(VehicleOrder.ARM)
        self.wait(lambda: self.phase is AutopilotPhase.DRIVING, why="it never drove:")

    def move(self, twist: Twist) -> None:
        """From neutral to this velocity, until the vehicle moves.

        On a busy machine commands fall silent at times, and the driver wants neutral again.
        """
        limit = Limit(30.0)
        while not self._moves_after_neutral(twist):
            assert not limit.over, f"it never moved: {self.autopilot} {self.problems}"

    def _moves_after_neutral(self, twist: Twist) -> bool:
        self.operator.twist, sent = Twist(), self.operator.sent
        self.wait(lambda: self.operator.sent > sent + 2 and not self.autopilot.why)
        self.operator.twist, tried, enough = twist, Limit(6.0), 0.7 * abs(twist.linear.x)
        self.wait(lambda: self.speed > enough or tried.over, 60.0)
        return self.speed > enough

    @property
    def speed(self) -> float:
        """Newest speed that the vehicle reported [m/s]."""
        speeds = self.relay.speeds(time.monotonic() - 1.0)
        return speeds[-1][1] if speeds else 0.0
