"""The one tuple of all message definitions."""

from __future__ import annotations

from typing import Any

from hub.gcm import (
    autonomy,
    autopilot,
    battery,
    body,
    camera_info,
    common,
    control,
    diagnostics,
    edges,
    environment,
    flight,
    imu,
    joints,
    mapping,
    mission,
    navigation,
    own_navigation,
    pad,
    ranges,
    recording,
    shaper,
    simulation,
    supervision,
    transforms,
    vehicle,
    vision,
)
from hub.ipc.definition import MessageDefinition

MESSAGES: tuple[MessageDefinition[Any], ...] = (
    *common.MESSAGES,
    *body.MESSAGES,
    *navigation.MESSAGES,
    *own_navigation.MESSAGES,
    *simulation.MESSAGES,
    *ranges.MESSAGES,
    *battery.MESSAGES,
    *imu.MESSAGES,
    *flight.MESSAGES,
    *transforms.MESSAGES,
    *diagnostics.MESSAGES,
    *edges.MESSAGES,
    *environment.MESSAGES,
    *vehicle.MESSAGES,
    *autopilot.MESSAGES,
    *joints.MESSAGES,
    *vision.MESSAGES,
    *camera_info.MESSAGES,
    *mapping.MESSAGES,
    *mission.MESSAGES,
    *autonomy.MESSAGES,
    *supervision.MESSAGES,
    *control.MESSAGES,
    *pad.MESSAGES,
    *recording.MESSAGES,
    *shaper.MESSAGES,
)
BY_NAME = {definition.name: definition for definition in MESSAGES}
