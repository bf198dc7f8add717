"""What a vehicle does, holds and has, in words; and what its modules find wrong."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from hub.gcm.body import (
    ROBOT_DESCRIPTION,
    HoldBody,
    HoldKind,
    JointBody,
    LightBody,
)
from hub.gcm.diagnostics import DIAGNOSTICS, Diagnostics, DiagnosticStatus, Severity
from hub.gcm.joints import JOINT_STATES, JointState, JointStates
from hub.gcm.standard import Header
from hub.gcm.vehicle import (
    VEHICLE_STATE,
    Arming,
    HoldPhase,
    HoldState,
    VehicleState,
)
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import with_message
from rune_tui.visualizers.parts import severity
from rune_tui.visualizers.words.troubles import banner_of, troubles, troubles_of_all
from tests.console.visualizers.conftest import NOW, Draw, Made, received, words
from tests.support.car import CAR
from tests.support.messages import camera_state

BODY = dataclasses.replace(
    CAR,
    holds=(HoldBody(kind=HoldKind.DEPTH), HoldBody(kind=HoldKind.HEADING)),
    lights=(LightBody(name="headlight", camera="front"),),
    joints=(JointBody(name="front flippers", lowest=-1.0, highest=1.0, speed=0.5),),
    arms=1,
)
VEHICLE = VehicleState(
    activity="holds",
    arming=Arming.ARMED,
    holds=(
        HoldState(kind=HoldKind.DEPTH, phase=HoldPhase.HOLDING, target=1.24, error=-0.03),
        HoldState(kind=HoldKind.HEADING, phase=HoldPhase.HOLDING, target=0.0, error=0.1),
    ),
    tether_paid=12.0,
    tether_length=25.0,
    tether_turns=-1.5,
)


def robot(vehicle: VehicleState | None = VEHICLE, age: float = 0.1, **parts: Any) -> RobotState:
    camera = dataclasses.replace(camera_state(headlight=0.7), name="front")
    made = Made().robot(camera=received(camera), **parts)
    angle = JointState(name="front flippers", position=math.radians(35.0))
    messages = {
        **made.messages,
        ROBOT_DESCRIPTION.name: received(BODY),
        JOINT_STATES.name: received(JointStates.of((angle,), Header())),
    }
    if vehicle is not None:
        messages[VEHICLE_STATE.name] = received(vehicle, age)
    return made.with_(messages=messages)


def rows(draw: Draw, known: RobotState, height: int) -> list[str]:
    return words(draw("visualizeVehicle", known, (40, height)))


def test_it_says_what_is_held_how_far_off_and_what_it_has(draw: Draw) -> None:
    drawn = rows(draw, robot(), 18)
    assert drawn[:6] == [
        "HOLDS 1.2 m 090, armed",
        "depth: holds 1.2 m (-0.03 m)",
        "heading: holds 090 (-6 deg)",
        "front flippers +35 deg",
        "headlight 70%",
        "tether 12.0 of 25 m, 1.5 turns right",
    ]


def test_a_hold_that_fails_or_waits_or_is_off_is_said(draw: Draw) -> None:
    for phase, text in (
        (HoldPhase.OFF, "depth: no hold"),
        (HoldPhase.READY, "depth: holds when you let go"),
        (HoldPhase.FAILING, "depth: HOLD FAILS 1.0 m (+0.45 m)"),
    ):
        hold = HoldState(kind=HoldKind.DEPTH, phase=phase, target=1.0, error=0.45)
        vehicle = dataclasses.replace(VEHICLE, holds=(hold,))
        assert text in rows(draw, robot(vehicle), 18)


def test_without_room_what_fails_comes_first(draw: Draw) -> None:
    hold = HoldState(kind=HoldKind.DEPTH, phase=HoldPhase.FAILING, target=1.0, error=0.45)
    vehicle = dataclasses.replace(VEHICLE, holds=(hold,))
    assert rows(draw, robot(vehicle), 2) == ["depth: HOLD FAILS 1.0 m (+0.45 m)  +4"]


def test_joints_are_said_before_lights_and_little_room_is_shared(draw: Draw) -> None:
    assert rows(draw, robot(), 10)[3:] == [
        "front flippers +35 deg",
        "headlight 70%  tether 12.0 of 25 m",
    ]


def test_disarmed_motors_are_said_and_an_old_state_is_marked(draw: Draw) -> None:
    vehicle = dataclasses.replace(VEHICLE, arming=Arming.DISARMED)
    assert "DISARMED: its motors are off" in rows(draw, robot(vehicle), 18)
    (first, *_) = rows(draw, robot(age=5.0), 18)
    assert "STALE" in first
    assert rows(draw, robot(None), 4)[0] == "no state of the vehicle"


def diagnosed(*status: DiagnosticStatus, known: RobotState, publisher: int, age: float = 0.1):
    return with_message(
        known, DIAGNOSTICS.name, received(Diagnostics(status=status), age), publisher
    )


LEAK = DiagnosticStatus(level=Severity.ERROR, name="leak", message="water in the hull")
SLIP = DiagnosticStatus(level=Severity.WARN, name="slip", message="wheels slip")
FINE = DiagnosticStatus(level=Severity.OK, name="battery", message="full")


def said(known: RobotState) -> list[tuple[str, bool]]:
    parts = troubles(known, ConsoleState(now=NOW, robots={known.name: known}))
    names = {LEAK.name, SLIP.name, FINE.name}
    return [
        (part.text, part.severity is severity.Severity.ALARM)
        for part in parts
        if part.cause in names
    ]


def test_problems_of_each_publisher_are_alarms_until_it_no_longer_sends_them() -> None:
    known = diagnosed(SLIP, FINE, known=robot(), publisher=3)
    known = diagnosed(LEAK, known=known, publisher=4)
    assert said(known) == [("water in the hull", True), ("wheels slip", False)]
    state = ConsoleState(now=NOW, robots={known.name: known})
    banner = banner_of(state, troubles_of_all(state))
    assert banner is not None
    assert (banner.robot, banner.text) == ("magellan", "water in the hull")
    known = diagnosed(known=known, publisher=3)
    assert said(known) == [("water in the hull", True)]


def test_a_problem_that_is_old_says_its_age_and_a_publisher_that_is_gone_is_forgotten() -> None:
    known = diagnosed(LEAK, known=robot(), publisher=4, age=12.0)
    assert said(known) == [("water in the hull (12 s ago)", True)]
    assert said(diagnosed(known=known, publisher=5)) == []


def test_an_error_of_nearly_nothing_has_no_minus(draw: Draw) -> None:
    holds = (
        HoldState(kind=HoldKind.DEPTH, phase=HoldPhase.HOLDING, target=1.0, error=-0.001),
        HoldState(kind=HoldKind.HEADING, phase=HoldPhase.HOLDING, target=0.0, error=0.001),
    )
    drawn = rows(draw, robot(dataclasses.replace(VEHICLE, holds=holds)), 18)
    assert drawn[1:3] == ["depth: holds 1.0 m (+0.00 m)", "heading: holds 090 (+0 deg)"]
