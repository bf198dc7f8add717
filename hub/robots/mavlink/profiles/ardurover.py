"""ArduPilot's rovers and boats: GUIDED with velocities of the body, in a closed loop."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.profile import (
    STATION_WANTED,
    STREAMS,
    Braking,
    Message,
    Parameters,
    Setpoint,
    VehicleProfile,
    WantedParameter,
)

BODY_NED: Final = 8
"""MAV_FRAME_BODY_NED: along and across the vehicle."""
VELOCITY_AND_TURN: Final = 0x5C7
"""Use velocity and turn rate alone; with accelerations the vehicle refuses the message."""
_GUIDED: Final = 15
_HOLD: Final = 4
_SETPOINT_TIMEOUT_S: Final = 3.25
"""Time without setpoints after which GUIDED brakes, by its firmware [s]."""
_RADIO_LOST_S: Final = 0.6
"""Time without sticks until a vehicle without a receiver notices [s]."""
_MODES: Final = {
    0: "manual",
    1: "acro",
    3: "steering",
    4: "hold",
    5: "loiter",
    6: "follow",
    7: "simple",
    8: "dock",
    9: "circle",
    10: "auto",
    11: "rtl",
    12: "smart rtl",
    15: "guided",
    16: "initialising",
}
STEERS: Final = 26.0
"""Function of an output that steers wheels: the rover is no skid-steered one."""
_ZERO: Final = Braking(delay=0.2, per_speed=1.3)
"""Measured on a simulated skid-steered rover: 0.88 s from 0.53 m/s, 1.36 s from 1 m/s."""
_HOLDING: Final = Braking(delay=0.1, per_speed=0.9, least=0.6)
"""The same in HOLD: 0.67 s from 0.53 m/s, 0.9 s from 1 m/s."""
_STEERED_ZERO: Final = Braking(delay=0.45, per_speed=2.15)
"""Measured on a simulated rover that steers: 2.6 s from 1 m/s."""
_STEERED_HOLD: Final = Braking(delay=0.3, per_speed=4.5)
"""The same in HOLD, where it coasts: more than 4 s from 1 m/s."""


def _setpoint(wanted: Setpoint, _parameters: Parameters, _gain: float) -> tuple[Message, ...]:
    """A velocity, beside neutral sticks.

    A vehicle without a receiver does not arm without sticks. It holds 0.5 s + FS_TIMEOUT after they
    end, which is sooner than after the setpoints alone.
    """
    return (
        ("MANUAL_CONTROL", {}),
        (
            "SET_POSITION_TARGET_LOCAL_NED",
            {
                "coordinate_frame": BODY_NED,
                "type_mask": VELOCITY_AND_TURN,
                "vx": wanted.ahead,
                "yaw_rate": -wanted.turn,
            },
        ),
    )


def _steers(parameters: Parameters) -> bool:
    return parameters.get("SERVO1_FUNCTION") == STEERS


def _coasts(parameters: Parameters) -> bool:
    """Whether it may coast: it does where it steers, or where that was not read."""
    return parameters.get("SERVO1_FUNCTION", STEERS) == STEERS


def _stops(parameters: Parameters, speed: float, *, receiver: bool) -> tuple[float, float]:
    """After the link is cut, its firmware brakes, or a failsafe holds earlier."""
    later = parameters.get("FS_TIMEOUT", math.nan)
    holds = [math.inf]
    if parameters.get("FS_GCS_ENABLE"):
        holds.append(parameters.get("FS_GCS_TIMEOUT", math.nan) + later)
    if parameters.get("FS_THR_ENABLE") and not receiver:
        holds.append(_RADIO_LOST_S + later)
    zero, hold = (_STEERED_ZERO, _STEERED_HOLD) if _steers(parameters) else (_ZERO, _HOLDING)
    held = min(each for each in holds if not math.isnan(each))
    if held < _SETPOINT_TIMEOUT_S:
        return zero.time(speed), held + hold.time(speed)
    return zero.time(speed), _SETPOINT_TIMEOUT_S + zero.time(speed) - zero.delay


ROVER: Final = VehicleProfile(
    name="rover",
    autopilot="ArduPilot",
    verified=True,
    types=frozenset({10}),
    modes=_MODES,
    drives=(_GUIDED,),
    need_place=frozenset({_GUIDED, 5, 11}),
    holds=_HOLD,
    offered=(_GUIDED, _HOLD, 5, 0, 11),
    alone={LeftAlone.STAND: _HOLD, LeftAlone.HOLD_HEIGHT: _HOLD},
    rates=STREAMS,
    wanted=(
        WantedParameter(
            name="FS_GCS_ENABLE",
            allowed=(1.0,),
            why="it goes on for 3 s or more when the ground station is silent",
        ),
        WantedParameter(
            name="FS_GCS_TIMEOUT",
            allowed=(2.0, 1.2, 1.5),
            why="it notices the loss of the ground station late",
        ),
        WantedParameter(
            name="FS_THR_ENABLE",
            allowed=(1.0,),
            why="without a receiver it keeps the last sticks for ever",
        ),
        WantedParameter(
            name="FS_TIMEOUT",
            allowed=(0.1, 0.2, 0.3, 0.5),
            why="it waits this time in a failsafe before it stops",
        ),
        WantedParameter(
            name="FS_ACTION",
            allowed=(2.0,),
            why="after a failsafe it drives by itself, or goes on, and does not hold",
        ),
        WantedParameter(
            name="RC_OVERRIDE_TIME",
            allowed=(0.5, 0.3),
            why="with a receiver it keeps the last sticks for this time",
        ),
        STATION_WANTED,
    ),
    reads=("WP_SPEED", "SPEED_MAX", "ACRO_TURN_RATE", "SERVO1_FUNCTION"),
    frees=("ahead", "turn"),
    setpoint=_setpoint,
    stops=_stops,
    stops_by=("SERVO1_FUNCTION",),
    coasts=_coasts,
)
BOAT: Final = replace(ROVER, name="boat", types=frozenset({11}), verified=False)
