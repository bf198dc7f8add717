"""PX4's rovers, boats and copters: sticks in Position mode.

PX4's rovers know neither reverse nor turn rates in OFFBOARD. These rules follow documents; they
were compared with no vehicle.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.arducopter import COPTER_TYPES, not_measured
from hub.robots.mavlink.profiles.profile import (
    STREAMS,
    Message,
    Parameters,
    Setpoint,
    VehicleProfile,
    WantedParameter,
    stick,
)

_AUTO: Final = 4
_POSITION: Final = 3 << 16
_HOLD: Final = _AUTO << 16 | 3 << 24
_RETURN: Final = _AUTO << 16 | 5 << 24
_LAND: Final = _AUTO << 16 | 6 << 24
_MODES: Final = {
    1 << 16: "manual",
    2 << 16: "altitude",
    _POSITION: "position",
    _AUTO << 16 | 1 << 24: "ready",
    _AUTO << 16 | 2 << 24: "take-off",
    _HOLD: "hold",
    _AUTO << 16 | 4 << 24: "mission",
    _RETURN: "return",
    _LAND: "land",
    5 << 16: "acro",
    6 << 16: "offboard",
    7 << 16: "stabilized",
}
_MIDDLE: Final = 500
"""The vertical stick, 0 to 1000, in its middle."""
_WANTED: Final = (
    WantedParameter(
        name="COM_RC_IN_MODE",
        allowed=(1.0,),
        why="it may obey another source of sticks until it is booted, and ignore ours",
    ),
    WantedParameter(
        name="COM_RC_LOSS_T",
        allowed=(0.5, 0.3),
        why="it keeps the last sticks for this time after the link is cut",
    ),
    WantedParameter(
        name="NAV_RCL_ACT",
        allowed=(1.0,),
        why="it drives or flies by itself, or goes on, when the sticks end",
    ),
    WantedParameter(
        name="NAV_DLL_ACT",
        allowed=(1.0,),
        why="it does not hold when the ground station is silent",
    ),
)


def _share(speed: float, parameters: Parameters, name: str, scale: float = 1.0) -> float:
    """A stick's share of its travel for a speed; 0 where the vehicle's limit is not known."""
    most = parameters.get(name, math.nan) * scale
    return speed / most if most > 0.0 else 0.0


def _sticks(**fields: int) -> tuple[Message, ...]:
    sent: dict[str, Any] = {"z": _MIDDLE, **fields}
    return (("MANUAL_CONTROL", sent),)


def _rover(wanted: Setpoint, parameters: Parameters, _gain: float) -> tuple[Message, ...]:
    ahead = _share(wanted.ahead, parameters, "RO_SPEED_LIM")
    turn = _share(-wanted.turn, parameters, "RO_YAW_RATE_LIM", math.radians(1.0))
    return _sticks(z=_MIDDLE + stick(ahead, 500.0), y=stick(turn))


def _copter(wanted: Setpoint, parameters: Parameters, _gain: float) -> tuple[Message, ...]:
    climb = "MPC_Z_VEL_MAX_UP" if wanted.up > 0.0 else "MPC_Z_VEL_MAX_DN"
    turn = _share(-wanted.turn, parameters, "MPC_MAN_Y_MAX", math.radians(1.0))
    return _sticks(
        x=stick(_share(wanted.ahead, parameters, "MPC_VEL_MANUAL")),
        y=stick(_share(-wanted.left, parameters, "MPC_VEL_MANUAL")),
        z=_MIDDLE + stick(_share(wanted.up, parameters, climb), 500.0),
        r=stick(turn),
    )


_RATES: Final = {name: rate for name, rate in STREAMS.items() if name != "EKF_STATUS_REPORT"} | {
    "ESTIMATOR_STATUS": 2.0
}
PX4_ROVER: Final = VehicleProfile(
    name="rover",
    autopilot="PX4",
    verified=False,
    types=frozenset({10}),
    modes=_MODES,
    drives=(_POSITION,),
    need_place=frozenset({_POSITION}),
    holds=_HOLD,
    offered=(_POSITION, _HOLD, _RETURN),
    alone={LeftAlone.STAND: _HOLD, LeftAlone.HOLD_HEIGHT: _HOLD},
    rates=_RATES,
    wanted=_WANTED,
    scales=("RO_SPEED_LIM", "RO_YAW_RATE_LIM"),
    bytewise=True,
    main_modes=True,
    frees=("ahead", "turn"),
    setpoint=_rover,
    stops=not_measured,
)
PX4_BOAT: Final = replace(PX4_ROVER, name="boat", types=frozenset({11}))
PX4_COPTER: Final = replace(
    PX4_ROVER,
    name="copter",
    types=COPTER_TYPES,
    flies=True,
    offered=(_POSITION, _HOLD, _LAND, _RETURN),
    rates={**_RATES, "EXTENDED_SYS_STATE": 5.0},
    scales=("MPC_VEL_MANUAL", "MPC_Z_VEL_MAX_UP", "MPC_Z_VEL_MAX_DN", "MPC_MAN_Y_MAX"),
    frees=("ahead", "left", "up", "turn"),
    setpoint=_copter,
)
