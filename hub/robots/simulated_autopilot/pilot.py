"""From sticks, setpoints and modes to what the motors do; pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

from hub.robots.mavlink.profiles.ardurover import BODY_NED, VELOCITY_AND_TURN
from hub.robots.simulated_autopilot.condition import VehicleCondition
from hub.robots.simulated_autopilot.motion import Demand, DemandKind

_SETPOINT_S: Final = 3.0
"""Age at which a setpoint ends; the firmware has it fixed [s]."""
_USES_VELOCITY: Final = 0x38
_LEAVES_REST: Final = VELOCITY_AND_TURN & ~0x400
_LEAVES_TURN: Final = 0x800
_LOCAL: Final = 1
_BODY: Final = frozenset({BODY_NED, 9, 12})
_SUB_TRAVEL_US: Final = 400.0
_DEAD_OUTPUT: Final = 0.0625
"""Output of a thruster up to which it stands: 25 us of 400."""
_FULL_TURN: Final = math.radians(45.0)
"""Turn rate of a full stick of a Sub, per unit of ACRO_YAW_P [rad/s]."""
_SURFACED: Final = 0.2
"""Depth at which a Sub is up [m]."""
_STEERED: Final = frozenset({0, 1, 3, 7})
_ROVER_GUIDED, _HOLD = 15, 4
_SUB_GUIDED, _SURFACE, _DEPTH_HOLD = 4, 9, 2
_POSITION_HOLD: Final = frozenset({16, 7, 3})
_HOLDS_DEPTH: Final = frozenset({2, 21})
_BLIMP_LAND, _BLIMP_MANUAL, _BLIMP_VELOCITY, _BLIMP_LOITER = 0, 1, 2, 3
_OFF: Final = Demand(kind=DemandKind.OFF)
_BUOYANT: Final = Demand(kind=DemandKind.OFF, down=-0.05)
"""A Sub without power rises slowly."""


def take_setpoint(vehicle: VehicleCondition, values: Mapping[str, Any]) -> None:
    """Take SET_POSITION_TARGET_LOCAL_NED; one that is not followed changes nothing."""
    mask, frame = values["type_mask"], values["coordinate_frame"]
    follows = vehicle.mode == vehicle.kind.guided_mode and vehicle.has_origin
    if not follows or mask & _USES_VELOCITY or mask & _LEAVES_REST != _LEAVES_REST:
        return
    ahead, right = values["vx"], values["vy"]
    if frame == _LOCAL:
        cos, sin = math.cos(vehicle.motion.yaw), math.sin(vehicle.motion.yaw)
        ahead, right = ahead * cos + right * sin, right * cos - ahead * sin
    elif frame not in _BODY:
        return
    turn = 0.0 if mask & _LEAVES_TURN else values["yaw_rate"]
    wanted = ahead, right, values["vz"], turn
    if all(map(math.isfinite, wanted)):
        vehicle.setpoint, vehicle.setpoint_at = wanted, vehicle.now


def take_sticks(vehicle: VehicleCondition, values: Mapping[str, Any]) -> None:
    """Take MANUAL_CONTROL; a blimp ignores the sticks in it."""
    if vehicle.kind.name == "rover":
        for channel, name in ((1, "y"), (3, "z")):
            off = max(-1000, min(1000, values[name])) // 2
            vehicle.radio.override(channel, 1500 + off, vehicle.now)
    elif vehicle.kind.name == "sub":
        scale = _SUB_TRAVEL_US * vehicle.gain / 1000.0
        throttle = 2.0 * scale * min(4.0, vehicle.parameters["JS_THR_GAIN"])
        for channel, off in (
            (3, (values["z"] - 500) * throttle),
            (4, values["r"] * scale),
            (5, values["x"] * scale),
            (6, values["y"] * scale),
        ):
            vehicle.radio.override(channel, round(1500 + max(-400.0, min(400.0, off))), vehicle.now)


def _guided(vehicle: VehicleCondition) -> Demand:
    """A velocity, while the setpoint is new."""
    if vehicle.now - vehicle.setpoint_at > _SETPOINT_S:
        return Demand(kind=DemandKind.VELOCITY)
    ahead, right, down, turn = vehicle.setpoint
    if vehicle.kind.name == "rover":
        most = vehicle.parameters["WP_SPEED"]
        ahead, right, down = max(-most, min(most, ahead)), 0.0, 0.0
    return Demand(kind=DemandKind.VELOCITY, ahead=ahead, right=right, down=down, turn=turn)


def _rover(vehicle: VehicleCondition) -> Demand:
    parameters = vehicle.parameters
    if vehicle.mode == _ROVER_GUIDED:
        return _guided(vehicle)
    if vehicle.mode == _HOLD:
        return Demand(kind=DemandKind.BRAKE)
    if vehicle.mode not in _STEERED or vehicle.radio_lost:
        return Demand(kind=DemandKind.VELOCITY)
    cruise = parameters["CRUISE_SPEED"] / max(0.05, parameters["CRUISE_THROTTLE"] / 100.0)
    ahead = vehicle.radio.share(3, parameters["RC3_DZ"]) * (parameters["SPEED_MAX"] or cruise)
    turn = vehicle.radio.share(1, parameters["RC1_DZ"])
    turn *= math.radians(parameters["ACRO_TURN_RATE"])
    if vehicle.mode != 1 and ahead < 0.0:
        turn = -turn
    return Demand(kind=DemandKind.VELOCITY, ahead=ahead, turn=turn)


def _thrust(output: float) -> float:
    """The thrust of a thruster, as a share, by its output, -1 to 1."""
    output = max(-1.0, min(1.0, output))
    return math.copysign(output * output, output) if abs(output) > _DEAD_OUTPUT else 0.0


def _thrusts(ahead: float, right: float) -> tuple[float, float]:
    """The thrust ahead and to the right, of four thrusters at 45 degrees."""
    one, other = _thrust(ahead + right), _thrust(ahead - right)
    return (one + other) / 2.0, (one - other) / 2.0


def _sub(vehicle: VehicleCondition) -> Demand:
    parameters, radio, gain = vehicle.parameters, vehicle.radio, vehicle.gain
    if vehicle.mode == _SUB_GUIDED:
        return _guided(vehicle)
    if vehicle.mode == _SURFACE and vehicle.motion.down <= _SURFACED:
        vehicle.set_mode(_DEPTH_HOLD)
    turn = radio.share(4, parameters["RC4_DZ"] * gain, _SUB_TRAVEL_US)
    turn *= _FULL_TURN * parameters["ACRO_YAW_P"]
    thrusts = _thrusts(*(radio.share(each, 0.0, _SUB_TRAVEL_US) for each in (5, 6)))
    rise = parameters["PILOT_SPEED_UP"] / 100.0
    if vehicle.mode == _SURFACE:
        kind, down = DemandKind.RISE, -rise
        return Demand(kind=kind, ahead=thrusts[0], right=thrusts[1], down=down, turn=turn)
    dead = parameters["THR_DZ"] * gain
    up = radio.share(3, 0.8 * dead, _SUB_TRAVEL_US)
    down = -up * (rise if up > 0.0 else (parameters["PILOT_SPEED_DN"] / 100.0 or rise))
    if vehicle.mode in _POSITION_HOLD and vehicle.has_place:
        speed = parameters["PILOT_SPEED"] / 100.0 * (1.0 - dead / _SUB_TRAVEL_US)
        ahead, right = (speed * radio.share(each, dead, _SUB_TRAVEL_US) for each in (5, 6))
        return Demand(kind=DemandKind.PLACE, ahead=ahead, right=right, down=down, turn=turn)
    kind = DemandKind.THRUST
    if vehicle.mode not in _HOLDS_DEPTH and vehicle.mode not in _POSITION_HOLD:
        kind, down = DemandKind.OPEN, -_thrust(radio.share(3, 0.0, _SUB_TRAVEL_US))
    return Demand(kind=kind, ahead=thrusts[0], right=thrusts[1], down=down, turn=turn)


def _blimp(vehicle: VehicleCondition) -> Demand:
    parameters = vehicle.parameters
    if vehicle.mode == _BLIMP_LAND:
        return _OFF
    right, ahead, up, turn = (
        vehicle.radio.share(int(parameters[f"RCMAP_{name}"]), parameters[f"RC{place}_DZ"])
        for place, name in enumerate(("ROLL", "PITCH", "THROTTLE", "YAW"), 1)
    )
    if vehicle.mode == _BLIMP_MANUAL:
        return Demand(kind=DemandKind.OPEN, ahead=ahead, right=right, down=-up, turn=turn)
    if vehicle.mode == _BLIMP_VELOCITY:
        kind, flat, climb = DemandKind.VELOCITY, "MAX_VEL_XY", "MAX_VEL_Z"
    elif vehicle.mode == _BLIMP_LOITER:
        kind, flat, climb = DemandKind.PLACE, "MAX_POS_XY", "MAX_POS_Z"
    else:
        return Demand(kind=DemandKind.PLACE)
    return Demand(
        kind=kind,
        ahead=ahead * parameters[flat],
        right=right * parameters[flat],
        down=-up * parameters[climb],
        turn=turn * parameters["MAX_VEL_YAW"],
    )


_DEMANDS: Final[Mapping[str, Callable[[VehicleCondition], Demand]]] = {
    "rover": _rover,
    "sub": _sub,
    "blimp": _blimp,
}


def demand(vehicle: VehicleCondition) -> Demand:
    """The demand on the motors now."""
    if not vehicle.armed:
        return _BUOYANT if vehicle.kind.name == "sub" and vehicle.motion.down > _SURFACED else _OFF
    return _DEMANDS[vehicle.kind.name](vehicle)
