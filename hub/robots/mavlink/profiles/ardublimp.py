"""ArduPilot's Blimp: radio channels in VELOCITY; it ignores MANUAL_CONTROL."""

from __future__ import annotations

import math
from typing import Any, Final

from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.profile import (
    NEVER,
    STATION_WANTED,
    STREAMS,
    Braking,
    Message,
    Parameters,
    Setpoint,
    VehicleProfile,
    WantedParameter,
    stick,
)

_VELOCITY: Final = 2
_LOITER: Final = 3
_CHANNELS: Final = 8
_LEAVE: Final = 65535
"""A channel with this value stays as it is."""
_MIDDLE_US: Final = 1500
_BRAKING: Final = Braking(delay=0.3, per_speed=10.0, least=1.4)
"""Measured on a simulated blimp in VELOCITY: 1.86 s from 0.15 m/s, up to 3.2 s from 0.2 m/s."""
_DRIFTING_S: Final = 18.0
"""Time until it stands after it was disarmed: nothing brakes it [s]."""
_MODES: Final = {0: "land", 1: "manual", 2: "velocity", 3: "loiter", 4: "rtl"}


def _setpoint(wanted: Setpoint, parameters: Parameters, _gain: float) -> tuple[Message, ...]:
    flat = max(0.01, parameters.get("MAX_VEL_XY", 0.5))
    climb = max(0.01, parameters.get("MAX_VEL_Z", 0.4))
    turn = max(0.01, parameters.get("MAX_VEL_YAW", 0.5))
    channels = dict.fromkeys(range(1, _CHANNELS + 1), _LEAVE)
    for name, default, share in (
        ("RCMAP_ROLL", 1, -wanted.left / flat),
        ("RCMAP_PITCH", 2, wanted.ahead / flat),
        ("RCMAP_THROTTLE", 3, wanted.up / climb),
        ("RCMAP_YAW", 4, -wanted.turn / turn),
    ):
        number = int(parameters.get(name, default))
        if number in channels:
            channels[number] = _MIDDLE_US + stick(share, 500.0)
    fields: dict[str, Any] = {f"chan{number}_raw": value for number, value in channels.items()}
    return (("RC_CHANNELS_OVERRIDE", fields),)


def _stops(parameters: Parameters, speed: float, receiver: bool) -> tuple[float, float]:  # noqa: FBT001
    braking = _BRAKING.time(speed)
    expires = parameters.get("RC_OVERRIDE_TIME", math.nan)
    if receiver:
        return braking, expires + braking - _BRAKING.delay
    return braking, expires + _DRIFTING_S if parameters.get("FS_THR_ENABLE") else NEVER


BLIMP: Final = VehicleProfile(
    name="blimp",
    autopilot="ArduPilot",
    verified=True,
    types=frozenset({7}),
    modes=_MODES,
    drives=(_VELOCITY,),
    holds=_LOITER,
    offered=(_VELOCITY, _LOITER, 0, 4),
    alone={LeftAlone.STAND: _LOITER, LeftAlone.HOLD_HEIGHT: _LOITER},
    rates=STREAMS,
    wanted=(
        WantedParameter(
            name="RC_OVERRIDE_TIME",
            allowed=(0.5, 0.3),
            why="it keeps the last velocity for this time after the link is cut",
        ),
        WantedParameter(
            name="FS_THR_ENABLE",
            allowed=(1.0,),
            why="without a receiver it keeps the last velocity for ever",
        ),
        STATION_WANTED,
    ),
    reads=(
        "MAX_VEL_XY",
        "MAX_VEL_Z",
        "MAX_VEL_YAW",
        "RCMAP_ROLL",
        "RCMAP_PITCH",
        "RCMAP_THROTTLE",
        "RCMAP_YAW",
    ),
    frees=("ahead", "left", "up", "turn"),
    setpoint=_setpoint,
    stops=_stops,
)
