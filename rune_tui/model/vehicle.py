"""A robot's holds, lights, joints and problems, from its messages; pure."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from hub.gcm.autopilot import AUTOPILOT_STATE, AUTOPILOT_TEXT, AutopilotState
from hub.gcm.body import HoldKind, LightBody
from hub.gcm.diagnostics import DIAGNOSTICS, DiagnosticStatus, Severity
from hub.gcm.joints import JOINT_STATES
from hub.gcm.vehicle import VEHICLE_STATE, HoldState, VehicleState
from rune_tui.model.robot_state import Received, RobotState

VERTICAL = "vertical"
"""Names the hold of a height or a depth, as the body has it."""
GONE_S = 10.0
"""Time without a message after which a publisher of diagnostics counts as gone [s]."""
_MOST_TEXTS = 20
"""Most texts of an autopilot that are kept."""


def with_message(robot: RobotState, name: str, newest: Received[Any], publisher: int) -> RobotState:
    """The state of a robot with a new message.

    It keeps the diagnostics of each publisher, and some texts of an autopilot.
    """
    robot = robot.with_(messages={**robot.messages, name: newest})
    if name == AUTOPILOT_TEXT.name:
        return robot.with_(texts=(*robot.texts, newest)[-_MOST_TEXTS:])
    if name != DIAGNOSTICS.name:
        return robot
    kept = {
        number: each
        for number, each in robot.diagnostics.items()
        if newest.measured - each.measured < GONE_S
    }
    return robot.with_(diagnostics={**kept, publisher: newest})


def problems_of(robot: RobotState) -> Iterator[Received[DiagnosticStatus]]:
    """The problems that the robot's modules report, the worst first, each once.

    A module that connected again has another number, and the report of the old one is still kept.
    """
    found = {
        (status.name, status.hardware_id, status.message): Received(
            value=status, measured=each.measured, number=each.number
        )
        for each in sorted(robot.diagnostics.values(), key=lambda each: each.measured)
        for status in each.value.status
        if status.level is not Severity.OK
    }
    return iter(sorted(found.values(), key=lambda each: each.value.level is not Severity.ERROR))


def hears_problems(robot: RobotState, now: float) -> bool:
    """Whether a module has reported of late what is wrong with it, or that nothing is."""
    return any(each.age(now) < GONE_S for each in robot.diagnostics.values())


def remarks_of(robot: RobotState) -> Iterator[Received[DiagnosticStatus]]:
    """What the robot's modules report besides problems."""
    for each in robot.diagnostics.values():
        for status in each.value.status:
            if status.level is Severity.OK and status.message:
                yield Received(value=status, measured=each.measured, number=each.number)


def vehicle_of(robot: RobotState) -> VehicleState | None:
    """The newest state of the vehicle; None: none yet."""
    known = robot.newest(VEHICLE_STATE)
    return known.value if known is not None else None


def autopilot_of(robot: RobotState) -> AutopilotState | None:
    """The newest state of the robot's autopilot; None: none yet, or it has none."""
    known = robot.newest(AUTOPILOT_STATE)
    return known.value if known is not None else None


def hold_named(robot: RobotState, name: str) -> HoldKind | None:
    """The hold of a layout's option that the body has; None: it has none."""
    body = robot.body
    kinds = [hold.kind for hold in body.holds] if body is not None else []
    wanted = (HoldKind.HEIGHT, HoldKind.DEPTH) if name == VERTICAL else (HoldKind[name.upper()],)
    return next((kind for kind in kinds if kind in wanted), None)


def hold_state(robot: RobotState, kind: HoldKind) -> HoldState | None:
    """The newest state of a hold; None: not known."""
    vehicle = vehicle_of(robot)
    holds = vehicle.holds if vehicle is not None else ()
    return next((each for each in holds if each.kind is kind), None)


def light_named(robot: RobotState, name: str) -> LightBody | None:
    """The light of a name, or the first one without a name; None: the body has none."""
    lights = robot.body.lights if robot.body is not None else ()
    return next((each for each in lights if name in ("", each.name)), None)


def brightness(robot: RobotState, light: LightBody) -> float:
    """The brightness of a light, 0 to 1; NaN: not known."""
    if not light.camera:
        vehicle = vehicle_of(robot)
        lit = vehicle.lights if vehicle is not None else ()
        return next((each.brightness for each in lit if each.name == light.name), math.nan)
    known = robot.camera
    if known is not None and known.value.name == light.camera:
        return known.value.headlight
    picture = robot.pictures.get(light.camera)
    return picture.value.camera.headlight if picture is not None else math.nan


def joint_angle(robot: RobotState, name: str) -> float:
    """The angle of a joint [rad]; NaN: not known."""
    known = robot.newest(JOINT_STATES)
    return known.value.position_of(name) if known is not None else math.nan
