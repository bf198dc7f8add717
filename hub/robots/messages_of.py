"""Which messages a robot brings, and what each has: from the parts of its body."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from typing import Any

from hub.gcm.battery import BATTERY
from hub.gcm.body import CarriedPart, RobotBody
from hub.gcm.camera_info import CAMERA_INFO
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.environment import ENVIRONMENT
from hub.gcm.flight import ALTITUDE, FLUID_PRESSURE
from hub.gcm.ground_truth import GROUND_TRUTH
from hub.gcm.imu import IMU
from hub.gcm.joints import JOINT_STATES
from hub.gcm.navigation import DRIVE_STATE, ROBOT_STATE
from hub.gcm.ranges import RANGES
from hub.gcm.transforms import TRANSFORMS
from hub.gcm.vehicle import VEHICLE_STATE
from hub.gcm.vision import CAMERA_STATE, IMAGE
from hub.ipc.definition import MessageDefinition

_Messages = dict[MessageDefinition[Any], str]

_EACH: _Messages = {
    ROBOT_STATE: "summary",
    DRIVE_STATE: "odometry",
    TRANSFORMS: "frames",
    VEHICLE_STATE: "activity",
    DIAGNOSTICS: "problems",
}
"""What each robot brings."""
_BY_PART: dict[str, _Messages] = {
    "ranges": {RANGES: "ranges"},
    "cameras": {
        IMAGE: "pictures",
        CAMERA_STATE: "direction of the camera",
        CAMERA_INFO: "projection of cameras",
    },
    "joints": {JOINT_STATES: "joints"},
    "senses": {ENVIRONMENT: "sound and air"},
}
"""What a robot brings with parts of these fields of its body."""
_MEASURED: _Messages = {
    BATTERY: "battery",
    IMU: "tilt and heading",
    ALTITUDE: "height and depth",
    FLUID_PRESSURE: "pressure",
    GROUND_TRUTH: "true pose",
}
"""What a kind of robot may measure besides."""


def described(body: RobotBody, measures: Iterable[MessageDefinition[Any]]) -> RobotBody:
    """The body with the messages that it brings.

    Args:
        body: Its parts.
        measures: What its kind measures besides them.
    """
    return dataclasses.replace(body, messages=tuple(_carried(body, measures)))


def _carried(body: RobotBody, measures: Iterable[MessageDefinition[Any]]) -> Iterator[CarriedPart]:
    parts = (found for part, found in _BY_PART.items() if getattr(body, part))
    known = {message: _MEASURED.get(message, message.name) for message in measures}
    for messages in (_EACH, *parts, known):
        for message, part in messages.items():
            yield CarriedPart(message=message.name, part=part)
