"""What a robot reports, with the fields that a test is about."""

from __future__ import annotations

from typing import Any

from hub.gcm.navigation import DriveState, MotionState, RobotState
from hub.gcm.vision import CameraState
from hub.modules.driver import reports
from hub.robots.interfaces import Sensors


def robot_state(**changes: Any) -> RobotState:
    """Standing, with a battery that is nearly full."""
    values: dict[str, Any] = {
        "stamp": 0.0,
        "x": 0.0,
        "y": 0.0,
        "theta": 0.0,
        "linear": 0.0,
        "angular": 0.0,
        "commanded_linear": 0.0,
        "commanded_angular": 0.0,
        "bumpers": 0,
        "battery_voltage": 24.1,
        "battery_fraction": 0.87,
        "motion": MotionState.STANDING,
        "refused": 0,
    }
    return RobotState(**values | changes)


def drive_state(**changes: Any) -> DriveState:
    """Standing, as the driver reports what a body with these `Sensors` measures."""
    return reports.drive_state(Sensors(**changes), 0.0)


def camera_state(**changes: Any) -> CameraState:
    """Looking straight ahead, wide."""
    values: dict[str, Any] = {
        "stamp": 0.0,
        "pan": 0.0,
        "tilt": 0.0,
        "zoom": 0.0,
        "horizontal_fov": 0.8,
        "vertical_fov": 0.6,
        "mount_forward": 0.1,
        "mount_height": 0.5,
        "pan_limit": 1.6,
        "tilt_limit": 0.5,
        "slewing": 0,
    }
    return CameraState(**values | changes)
