"""ArduPilot's copters: GUIDED with velocities of the body, in the air only.

These rules follow documents; they were compared with no vehicle.
"""

from __future__ import annotations

import math
from typing import Final

from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.ardurover import BODY_NED, VELOCITY_AND_TURN
from hub.robots.mavlink.profiles.profile import (
    STATION_WANTED,
    STREAMS,
    Message,
    Parameters,
    Setpoint,
    VehicleProfile,
    WantedParameter,
)

_GUIDED: Final = 4
_LOITER: Final = 5
_RTL: Final = 6
_LAND: Final = 9
_BRAKE: Final = 17
COPTER_TYPES: Final = frozenset({2, 3, 4, 13, 14, 15, 29, 35})
"""MAV_TYPE of vehicles with four, coaxial, one, six, eight, three, twelve and ten rotors."""
_MODES: Final = {
    0: "stabilize",
    1: "acro",
    2: "altitude hold",
    3: "auto",
    4: "guided",
    5: "loiter",
    6: "rtl",
    7: "circle",
    9: "land",
    11: "drift",
    13: "sport",
    14: "flip",
    15: "autotune",
    16: "position hold",
    17: "brake",
    18: "throw",
    20: "guided without gps",
    21: "smart rtl",
    22: "flow hold",
    23: "follow",
    24: "zigzag",
    27: "auto rtl",
}


def _setpoint(wanted: Setpoint, _parameters: Parameters, _gain: float) -> tuple[Message, ...]:
    return (
        (
            "SET_POSITION_TARGET_LOCAL_NED",
            {
                "coordinate_frame": BODY_NED,
                "type_mask": VELOCITY_AND_TURN,
                "vx": wanted.ahead,
                "vy": -wanted.left,
                "vz": -wanted.up,
                "yaw_rate": -wanted.turn,
            },
        ),
    )


def not_measured(_parameters: Parameters, _speed: float, *, receiver: bool) -> tuple[float, float]:  # noqa: ARG001
    """The times of a vehicle whose stops were never measured."""
    return math.nan, math.nan


COPTER: Final = VehicleProfile(
    name="copter",
    autopilot="ArduPilot",
    verified=False,
    types=COPTER_TYPES,
    modes=_MODES,
    drives=(_GUIDED,),
    need_place=frozenset({_GUIDED, _LOITER, _RTL, _BRAKE}),
    flies=True,
    holds=_LOITER,
    offered=(_GUIDED, _BRAKE, _LOITER, _LAND, _RTL),
    alone={LeftAlone.STAND: _BRAKE, LeftAlone.HOLD_HEIGHT: _BRAKE},
    rates={**STREAMS, "EXTENDED_SYS_STATE": 5.0},
    wanted=(
        WantedParameter(
            name="FS_GCS_ENABLE",
            allowed=(5.0, 1.0, 3.0, 4.0),
            why="it does not land or come back when the ground station is silent",
        ),
        WantedParameter(
            name="FS_GCS_TIMEOUT",
            allowed=(2.0, 3.0, 5.0),
            why="it notices the loss of the ground station late",
        ),
        WantedParameter(
            name="GUID_TIMEOUT",
            allowed=(1.0, 0.5, 2.0, 3.0),
            why="it keeps the last velocity for this time after the link is cut",
        ),
        STATION_WANTED,
    ),
    frees=("ahead", "left", "up", "turn"),
    setpoint=_setpoint,
    stops=not_measured,
)
