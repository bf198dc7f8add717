"""States of a robot's autopilot."""

from __future__ import annotations

import dataclasses
from typing import Any

from hub.gcm.autopilot import (
    AUTOPILOT_STATE,
    AUTOPILOT_TEXT,
    AutopilotPhase,
    AutopilotState,
    AutopilotText,
    UnsafeParameter,
)
from hub.gcm.diagnostics import Severity
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import with_message
from tests.console.visualizers.conftest import Made, received

UNSAFE = UnsafeParameter(
    name="FS_GCS_ENABLE", value=0.0, wanted=1.0, why="it goes on for 3 s or more"
)
ROVER = AutopilotState(
    phase=AutopilotPhase.DRIVING,
    vehicle="rover",
    firmware="ArduPilot 4.7.0",
    verified=1,
    mode="guided",
    modes=("guided", "hold", "loiter"),
    holds="hold",
    armable=1,
    heard_s=0.4,
    round_trip_s=0.027,
    position=1,
    satellites=10,
    stops_after_zero_s=0.9,
    stops_after_cut_s=1.4,
)


def rover(**changes: Any) -> AutopilotState:
    """A rover that follows velocities, with other values."""
    return dataclasses.replace(ROVER, **changes)


def piloted(
    autopilot: AutopilotState | None, *texts: tuple[str, Severity], age: float = 0.1
) -> RobotState:
    """A robot with an autopilot that has said something."""
    robot = Made().robot()
    if autopilot is not None:
        robot = with_message(robot, AUTOPILOT_STATE.name, received(autopilot, age), 1)
    for number, (words, level) in enumerate(texts):
        text = received(AutopilotText(text=words, level=level), number=number)
        robot = with_message(robot, AUTOPILOT_TEXT.name, text, 1)
    return robot
