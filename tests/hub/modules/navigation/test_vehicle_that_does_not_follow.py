"""A task ends when the vehicle does not follow any more; then each new one is refused."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest

from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotState
from hub.gcm.navigation import Cause, DriveState, GoalCommand, Point, Task
from hub.gcm.vehicle import VEHICLE_STATE, Arming, VehicleState
from hub.ipc.message_info import MessageInfo
from hub.modules.navigation.__main__ import Navigation
from hub.robots.robot_file import find_robot_file, read_description
from tests.hub.modules.extremes_bus import ExtremesBus

OPERATOR, DRIVER = 2, 3
GOAL = GoalCommand(points=(Point(x=3.0, y=0.0),))
HOLDS = "it is in hold, not asked for here: ask it to drive"


class Vehicle:
    """Navigation, with a driver that reports."""

    def __init__(self) -> None:
        robot, _ = read_description(find_robot_file("magellan"))
        self.bus = ExtremesBus(time.monotonic, Random(7))
        self.navigation = Navigation(self.bus, robot)  # type: ignore[arg-type]
        self.task = self.navigation.pilot.task
        self.navigation.reported(DriveState(reckoning=11), _from(DRIVER))

    def goes(self) -> None:
        self.navigation.go(GOAL, _from(OPERATOR))

    def piloted(self, why: str) -> None:
        for take in self.bus.handlers[AUTOPILOT_STATE.name]:
            take(AutopilotState(why=why))

    def arms(self, arming: Arming) -> None:
        for take in self.bus.handlers[VEHICLE_STATE.name]:
            take(VehicleState(arming=arming))


def _from(sender: int) -> MessageInfo:
    return MessageInfo(sender, 1, 0, 0.0, time.monotonic())


@pytest.fixture
def vehicle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Vehicle:
    ticks = itertools.count(100_000)
    monkeypatch.setattr(time, "monotonic", lambda: next(ticks) * 1e-4)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return Vehicle()


LOSSES: dict[str, tuple[Callable[[Vehicle], None], Callable[[Vehicle], None], str]] = {
    "another station sets a mode": (
        lambda vehicle: vehicle.piloted(HOLDS),
        lambda vehicle: vehicle.piloted(""),
        HOLDS,
    ),
    "it is disarmed": (
        lambda vehicle: vehicle.arms(Arming.DISARMED),
        lambda vehicle: vehicle.arms(Arming.ARMED),
        "its motors are off: arm it",
    ),
}


@pytest.mark.parametrize("loss", LOSSES)
def test_the_goal_ends_and_does_not_go_on_by_itself(vehicle: Vehicle, loss: str) -> None:
    lose, follow, why = LOSSES[loss]
    vehicle.goes()
    assert vehicle.task.active
    lose(vehicle)
    assert (vehicle.task.state, vehicle.task.cause) == (Task.CANCELLED, Cause.DRIVER)
    assert vehicle.task.why == why
    vehicle.goes()
    assert not vehicle.task.active
    assert vehicle.task.why == f"not begun: {why}"
    assert vehicle.task.cause is Cause.DRIVER
    follow(vehicle)
    assert not vehicle.task.active, "only an order begins to move it"
    vehicle.goes()
    assert vehicle.task.active
