"""Holds, lights, flippers, arming and problems of real hubs, with their orders from a console."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from hub.gcm.body import HoldKind
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.joints import JOINT_STATES
from hub.gcm.navigation import GROUND_TRUTH
from hub.gcm.vehicle import (
    VEHICLE_COMMAND,
    VEHICLE_STATE,
    Arming,
    HoldPhase,
    HoldState,
    VehicleCommand,
    VehicleOrder,
    VehicleState,
)
from hub.gcm.vision import CAMERA_STATE
from hub.ipc.definition import MessageDefinition
from tests.support.bodies import hub_with
from tests.system.harness import ConsoleProcess, HubProcess, Observer, press

F8, F9 = "\x1b[19~", "\x1b[20~"
HUB = hub_with("rov", kind="simulated-rov")


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture
def observer(hub: HubProcess, stack: ExitStack) -> Observer:
    kinds = (GROUND_TRUTH, VEHICLE_STATE, DIAGNOSTICS, CAMERA_STATE)
    return stack.enter_context(closing(Observer(hub.endpoint, *kinds)))


@pytest.fixture
def console(hub: HubProcess, stack: ExitStack) -> ConsoleProcess:
    """A console with a layout made for the robot."""
    arguments = ["run", "auto", "--hub", hub.endpoint]
    opened = stack.enter_context(closing(ConsoleProcess(arguments, columns=160, rows=60)))
    opened.wait(lambda: "HOLDS" in opened.text, 20.0, lambda: opened.text)
    return opened


def newest(observer: Observer, definition: MessageDefinition[Any]) -> Any:
    return observer.seen[definition.name][-1][1]


def vehicle(observer: Observer) -> VehicleState:
    state: VehicleState = newest(observer, VEHICLE_STATE)
    return state


def depth_hold(observer: Observer) -> HoldState:
    (found,) = [each for each in vehicle(observer).holds if each.kind is HoldKind.DEPTH]
    return found


def order(observer: Observer, command: VehicleCommand) -> None:
    observer.client.define(VEHICLE_COMMAND)
    observer.client.wait_defined(5.0)
    observer.client.publish(VEHICLE_COMMAND, command)


def test_the_robot_goes_to_the_target_of_a_hold(observer: Observer) -> None:
    """Nobody has had control yet, so the robot is not left alone."""
    before = observer.truth.z
    hold = VehicleCommand(order=VehicleOrder.HOLD, hold=HoldKind.DEPTH, value=1.2)
    order(observer, hold)
    observer.wait(lambda: depth_hold(observer).target == pytest.approx(1.2), 5.0)
    observer.wait(lambda: abs(depth_hold(observer).error) < 0.05, 15.0)
    assert observer.truth.z < before
    assert vehicle(observer).tether_length == 25.0
    assert newest(observer, DIAGNOSTICS).status == ()


def test_keys_switch_holds_light_and_motors(console: ConsoleProcess, observer: Observer) -> None:
    def wait(condition: Callable[[], bool]) -> None:
        """Wait for the robot, while the console is read and ignored keys are pressed again."""
        console.wait(lambda: observer.client.listen(0.01) or condition(), 10.0)

    press(console, "t")
    console.wait(lambda: "you have control" in console.text, 10.0)
    press(console, "g")
    wait(lambda: depth_hold(observer).phase is HoldPhase.OFF)
    console.wait(lambda: "hold depth: off" in console.text, 5.0, lambda: console.text)
    press(console, "g")
    wait(lambda: depth_hold(observer).phase is HoldPhase.HOLDING)
    press(console, "o")
    wait(lambda: newest(observer, CAMERA_STATE).headlight == 1.0)
    press(console, F9)
    wait(lambda: vehicle(observer).arming is Arming.DISARMED)
    console.wait(lambda: "DISARMED" in console.text, 5.0, lambda: console.text)
    before = observer.truth.z
    observer.wait(lambda: observer.truth.z > before + 0.02, 10.0, "it does not rise")
    press(console, F8)
    console.wait(lambda: "press again to arm" in console.text, 5.0)
    assert vehicle(observer).arming is Arming.DISARMED
    press(console, F8)
    wait(lambda: vehicle(observer).arming is Arming.ARMED)


def test_flippers_of_a_tracked_robot_move_while_a_key_is_held(
    stack: ExitStack, tmp_path: Path
) -> None:
    keys = hub_with("tracked", kind="simulated-tracked")
    hub = stack.enter_context(closing(HubProcess(tmp_path, **keys)))
    observer = stack.enter_context(closing(Observer(hub.endpoint, JOINT_STATES)))
    console = stack.enter_context(
        closing(ConsoleProcess(["run", "auto", "--hub", hub.endpoint], columns=160, rows=60))
    )
    console.wait(lambda: "front flippers +35 deg" in console.text, 20.0, lambda: console.text)
    press(console, "t")
    console.wait(lambda: "you have control" in console.text, 10.0)

    def angle() -> float:
        observer.client.listen(0.01)
        states = newest(observer, JOINT_STATES)
        return float(states.position_of("front flippers"))

    console.hold_until("2", lambda: angle() > 1.0)
    observer.wait(lambda: newest(observer, JOINT_STATES).velocity[0] == 0.0, 2.0, "it turns on")
