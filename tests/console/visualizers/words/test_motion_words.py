"""How a robot moves: the status line and the team agree, and drift is no STOPPING."""

from __future__ import annotations

import dataclasses
from typing import Any

from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotPhase, AutopilotState
from hub.gcm.body import ROBOT_DESCRIPTION, Freedom, HoldKind, Motion
from hub.gcm.diagnostics import DIAGNOSTICS, Diagnostics, DiagnosticStatus, Severity
from hub.gcm.navigation import MotionState
from hub.gcm.vehicle import VEHICLE_STATE, Arming, HoldPhase, HoldState, VehicleState
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import with_message
from rune_tui.visualizers.words.status_words import status_parts
from rune_tui.visualizers.words.team_words import does
from tests.console.visualizers.conftest import NOW, Made, received
from tests.support.car import CAR
from tests.support.cases import for_each
from tests.support.messages import robot_state

WAITING, STANDING, STOPPED = MotionState.WAITING, MotionState.STANDING, MotionState.STOPPED
HELD = (HoldState(kind=HoldKind.DEPTH, phase=HoldPhase.HOLDING, target=1.2),)
FAILS = (HoldState(kind=HoldKind.DEPTH, phase=HoldPhase.FAILING, target=1.2),)
WHEELS, SIDEWAYS, AFLOAT = (Freedom.SURGE,), (Freedom.SWAY,), (Freedom.HEAVE,)


def robot(
    *freedoms: Freedom, vehicle: VehicleState | None = None, age: float = 0.1, **motion: Any
) -> RobotState:
    """A robot with these degrees of freedom."""
    made = Made().robot(navigation=received(robot_state(**motion)))
    motions = tuple(Motion(freedom=each, limit=0.5, acceleration=1.0) for each in freedoms)
    messages = {
        **made.messages,
        ROBOT_DESCRIPTION.name: received(dataclasses.replace(CAR, motions=motions)),
    }
    if vehicle is not None:
        messages[VEHICLE_STATE.name] = received(vehicle, age)
    return made.with_(messages=messages)


def said(known: RobotState) -> list[str]:
    return [part.text for part in status_parts(known, ConsoleState(now=NOW))]


@for_each(
    ("freedoms", "motion", "speeds", "activity", "holds", "status", "team"),
    [
        (WHEELS, STANDING, {"linear": 0.03}, "drives", (), "STOPPING", "STOPPING"),
        (WHEELS, STANDING, {"linear": 0.01}, "drives", (), "STANDING", "stands"),
        (SIDEWAYS, STANDING, {"sway": -0.03}, "drives", (), "STOPPING", "STOPPING"),
        (AFLOAT, STANDING, {"linear": 0.03}, "drifts", (), "DRIFTS", "drifts"),
        (AFLOAT, STANDING, {"sway": 0.12}, "drifts", (), "STOPPING", "STOPPING"),
        (AFLOAT, STANDING, {"heave": -0.12}, "drifts", (), "STOPPING", "STOPPING"),
        (AFLOAT, STANDING, {"sway": 0.12}, "holds", HELD, "HOLDS", "holds 1.2 m"),
        (AFLOAT, STANDING, {}, "holds", FAILS, "HOLD FAILS: DEPTH", "HOLD FAILS: depth"),
        (
            AFLOAT,
            WAITING,
            {"linear": 0.03},
            "holds",
            HELD,
            "READY",
            "ready",
        ),
        (AFLOAT, STOPPED, {"linear": 0.03}, "drifts", (), "STOPPED: a stop was sent", "STOPPED"),
        # A hold of the depth stops no motion ahead.
        (AFLOAT, STOPPED, {"linear": 0.3}, "holds", HELD, "STOPPING: a stop was sent", "STOPPING"),
    ],
)
def test_drift_is_no_stopping_and_the_team_agrees(
    freedoms, motion, speeds, activity, holds, status, team
) -> None:
    vehicle = VehicleState(activity=activity, holds=holds)
    known = robot(*freedoms, vehicle=vehicle, motion=motion, **speeds)
    assert status in said(known)
    assert does(known, NOW).text == team


def test_a_disarmed_robot_is_not_said_to_stand() -> None:
    vehicle = VehicleState(activity="disarmed", arming=Arming.DISARMED)
    for motion in (STANDING, WAITING, STOPPED):
        known = robot(*AFLOAT, vehicle=vehicle, motion=motion, heave=-0.3)
        assert {"DISARMED", "0.30 m/s down"} <= set(said(known))
        assert does(known, NOW).text == "disarmed"
    old = robot(*AFLOAT, vehicle=vehicle, age=4.0)
    assert "STANDING" in said(old)


def test_motion_to_the_side_is_said_where_the_robot_has_it() -> None:
    speeds = {"motion": MotionState.MOVING, "sway": -0.4, "heave": 0.1}
    assert "0.40 m/s to the right" in said(robot(*SIDEWAYS, **speeds))
    assert "0.10 m/s up" not in said(robot(*SIDEWAYS, **speeds))
    assert {"0.40 m/s to the right", "0.10 m/s up"} <= set(said(robot(*AFLOAT, **speeds)))
    assert not any("to the" in text for text in said(robot(*WHEELS, **speeds)))


def test_what_holds_a_robot_back_besides_obstacles_is_said() -> None:
    moving = robot(*WHEELS, motion=MotionState.MOVING, held_back=0.67)
    assert "HELD BACK 67%" in said(moving)
    status = tuple(
        DiagnosticStatus(level=Severity.WARN, name=name, message=name)
        for name in ("edge", "tilt", "range sonar", "tether")
    )
    for found, words in ((status[:2], "tilted, edge near"), (status[2:], "sensor silent")):
        problems = received(Diagnostics(status=found))
        text = said(with_message(moving, DIAGNOSTICS.name, problems, 3))
        assert f"HELD BACK 67% ({words})" in text
    old = received(Diagnostics(status=status), 5.0)
    assert "HELD BACK 67%" in said(with_message(moving, DIAGNOSTICS.name, old, 3))


@for_each(
    ("phase", "arming", "motion", "linear", "status"),
    [
        (AutopilotPhase.DRIVING, Arming.ARMED, MotionState.MOVING, 0.3, "MOVING"),
        (AutopilotPhase.ELSEWHERE, Arming.ARMED, MotionState.MOVING, 0.0, "DOES NOT FOLLOW"),
        (AutopilotPhase.GONE, Arming.ARMED, MotionState.MOVING, 0.0, "DOES NOT FOLLOW"),
        (AutopilotPhase.DISARMED, Arming.DISARMED, MotionState.MOVING, 0.0, "DISARMED"),
        (AutopilotPhase.ELSEWHERE, Arming.ARMED, STANDING, 0.3, "MOVES BY ITSELF"),
        (AutopilotPhase.ELSEWHERE, Arming.ARMED, STANDING, 0.0, "STANDING"),
    ],
)
def test_keys_that_move_nothing_are_not_called_a_motion(phase, arming, motion, linear, status):
    vehicle = VehicleState(arming=arming)
    known = robot(*WHEELS, vehicle=vehicle, motion=motion, linear=linear)
    known = with_message(known, AUTOPILOT_STATE.name, received(AutopilotState(phase=phase)), 1)
    assert status in said(known)
    team = {"MOVING": "drives", "DISARMED": "disarmed", "STANDING": "stands"}
    assert does(known, NOW).text == team.get(status, status)
