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
_TRAVEL_US: Final = 500.0
"""Travel of a channel to each side [us]."""
_BRAKING: Final = Braking(delay=0.3, per_speed=8.0, least=1.5)
"""Measured on a simulated blimp in VELOCITY: 1.86 s from 0.15 m/s, 1.5 to 3.2 s from 0.2 m/s."""
_RADIO_LOST_S: Final = 1.05
"""Time without sticks until a vehicle without a receiver notices, at most [s]."""
_DRIFTING_S: Final = 18.0
"""Time until it stands after it was disarmed: nothing brakes it [s]."""
_MODES: Final = {0: "land", 1: "manual", 2: "velocity", 3: "loiter", 4: "rtl"}


def _setpoint(wanted: Setpoint, parameters: Parameters, _gain: float) -> tuple[Message, ...]:
    channels = dict.fromkeys(range(1, _CHANNELS + 1), _LEAVE)
    for name, default, speed, limit, usual_dead in (
        ("RCMAP_ROLL", 1, -wanted.left, "MAX_VEL_XY", 20.0),
        ("RCMAP_PITCH", 2, wanted.ahead, "MAX_VEL_XY", 20.0),
        ("RCMAP_THROTTLE", 3, wanted.up, "MAX_VEL_Z", 30.0),
        ("RCMAP_YAW", 4, -wanted.turn, "MAX_VEL_YAW", 20.0),
    ):
        number = int(parameters.get(name, default))
        most = max(0.01, parameters.get(limit, math.inf))
        dead = parameters.get(f"RC{number}_DZ", usual_dead)
        if number in channels:
            channels[number] = _MIDDLE_US + _travel(speed / most, dead)
    fields: dict[str, Any] = {f"chan{number}_raw": value for number, value in channels.items()}
    return (("RC_CHANNELS_OVERRIDE", fields),)


def _travel(share: float, dead: float) -> int:
    """The travel of a channel [us] for a share of the limit; its dead zone is undone."""
    dead = dead if 0.0 <= dead < _TRAVEL_US else 0.0
    return stick(share, _TRAVEL_US - dead) + round(math.copysign(dead, share)) * bool(share)


def _stops(parameters: Parameters, speed: float, *, receiver: bool) -> tuple[float, float]:
    """With a receiver, its sticks come back; without one, a failsafe disarms, and it drifts."""
    braking = _BRAKING.time(speed)
    expires = parameters.get("RC_OVERRIDE_TIME", math.nan)
    if receiver:
        return braking, expires + braking - _BRAKING.delay
    cuts = [NEVER]
    if parameters.get("FS_THR_ENABLE", math.nan):
        cuts.append(min(expires, _RADIO_LOST_S) + _DRIFTING_S)
    if parameters.get("FS_GCS_ENABLE"):
        cuts.append(parameters.get("FS_GCS_TIMEOUT", math.nan) + _DRIFTING_S)
    return braking, min(each for each in cuts if not math.isnan(each))


BLIMP: Final = VehicleProfile(
    name="blimp",
    autopilot="ArduPilot",
    verified=True,
    types=frozenset({7}),
    modes=_MODES,
    drives=(_VELOCITY,),
    need_place=frozenset({_VELOCITY, _LOITER}),
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
    scales=("MAX_VEL_XY", "MAX_VEL_Z", "MAX_VEL_YAW"),
    reads=(
        "FS_GCS_ENABLE",
        "FS_GCS_TIMEOUT",
        "RCMAP_ROLL",
        "RCMAP_PITCH",
        "RCMAP_THROTTLE",
        "RCMAP_YAW",
        *(f"RC{number}_DZ" for number in range(1, 5)),  # of another channel, the usual one counts
    ),
    frees=("ahead", "left", "up", "turn"),
    setpoint=_setpoint,
    stops=_stops,
)
