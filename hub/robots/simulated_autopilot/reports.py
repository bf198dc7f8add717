"""The messages in which a simulated autopilot tells its state; pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

from hub.robots.simulated_autopilot.condition import VehicleCondition

HOME: Final = (33.810313, -118.393867)
"""Latitude and longitude of the start [deg]."""
_PER_DEGREE: Final = 111_319.49
"""Length of a degree of latitude [m]."""
_VOLTAGE: Final = 12_600
_RESERVE: Final = 250
"""Voltage that a driving motor costs [mV]."""
_AIR: Final = 1013.25
_WATER: Final = 98.1
"""Pressure of the air, and of a metre of water [hPa]."""
_PREARM: Final = 0x10000000
_RECEIVER: Final = 0x10000
_ATTITUDE: Final = 0x200000
_MOTORS: Final = 0x8000
_UNUSED: Final = 65535
_VERSION: Final = 67_567_616
"""4.7.0-dev, a byte each."""
Fields = dict[str, Any]


def _place(vehicle: VehicleCondition) -> tuple[int, int]:
    """Latitude and longitude [1e-7 deg]."""
    state = vehicle.motion
    narrow = _PER_DEGREE * math.cos(math.radians(HOME[0]))
    latitude, longitude = HOME[0] + state.north / _PER_DEGREE, HOME[1] + state.east / narrow
    return round(latitude * 1e7), round(longitude * 1e7)


def _attitude(vehicle: VehicleCondition) -> Fields:
    state = vehicle.motion
    return {
        "time_boot_ms": vehicle.age_ms,
        "roll": state.roll,
        "pitch": state.pitch,
        "yaw": state.yaw,
        "yawspeed": state.turn,
    }


def _local_position(vehicle: VehicleCondition) -> Fields | None:
    """Of a rover, as soon as there is an origin; of others, as soon as they know their place."""
    known = vehicle.has_origin if vehicle.kind.name == "rover" else vehicle.has_place
    if not known:
        return None
    state = vehicle.motion
    north, east = state.ground
    return {
        "time_boot_ms": vehicle.age_ms,
        "x": state.north,
        "y": state.east,
        "z": state.down,
        "vx": north,
        "vy": east,
        "vz": state.sinking,
    }


def _global_position(vehicle: VehicleCondition) -> Fields:
    state = vehicle.motion
    north, east = state.ground
    latitude, longitude = _place(vehicle)
    return {
        "time_boot_ms": vehicle.age_ms,
        "lat": latitude,
        "lon": longitude,
        "alt": round(-state.down * 1e3),
        "relative_alt": round(-state.down * 1e3),
        "vx": round(north * 100.0),
        "vy": round(east * 100.0),
        "vz": round(state.sinking * 100.0),
        "hdg": round(math.degrees(state.yaw) % 360.0 * 100.0) % 36_000,
    }


def _hud(vehicle: VehicleCondition) -> Fields:
    state = vehicle.motion
    return {
        "groundspeed": math.hypot(state.ahead, state.right),
        "heading": round(math.degrees(state.yaw)) % 360,
        "alt": -state.down,
        "climb": -state.sinking,
    }


def voltage(vehicle: VehicleCondition) -> int:
    """Of the battery [mV]."""
    moves = math.hypot(vehicle.motion.ahead, vehicle.motion.right, vehicle.motion.sinking) > 0.05
    return _VOLTAGE - (_RESERVE if vehicle.armed and moves else 0)


def _charge(vehicle: VehicleCondition) -> int:
    return max(0, min(100, round(vehicle.motion.charge * 100.0)))


def _status(vehicle: VehicleCondition) -> Fields:
    present, enabled = vehicle.kind.sensors
    health = present
    if any(True for _ in vehicle.arm_refusals()) and not vehicle.armed:
        health &= ~_PREARM
    if vehicle.radio_lost:
        health &= ~_RECEIVER
    if not vehicle.has_origin:
        health &= ~_ATTITUDE
    return {
        "onboard_control_sensors_present": present,
        "onboard_control_sensors_enabled": enabled if vehicle.armed else enabled & ~_MOTORS,
        "onboard_control_sensors_health": health,
        "voltage_battery": voltage(vehicle),
        "battery_remaining": _charge(vehicle),
    }


def _battery(vehicle: VehicleCondition) -> Fields:
    return {
        "temperature": 32_767,
        "voltages": (voltage(vehicle), *(_UNUSED,) * 9),
        "battery_remaining": _charge(vehicle),
        "charge_state": 1,
    }


def _filter(vehicle: VehicleCondition) -> Fields:
    return {
        "flags": vehicle.filter_flags,
        "velocity_variance": 0.006,
        "pos_horiz_variance": 0.005,
        "pos_vert_variance": 0.02,
        "compass_variance": 0.02,
    }


def _satellites(vehicle: VehicleCondition) -> Fields:
    fixed = bool(vehicle.parameters["SIM_GPS1_ENABLE"]) and vehicle.has_origin
    latitude, longitude = _place(vehicle) if fixed else (0, 0)
    return {
        "time_usec": vehicle.age_ms * 1000,
        "fix_type": 6 if fixed else 1,
        "lat": latitude,
        "lon": longitude,
        "eph": 121 if fixed else _UNUSED,
        "epv": 200 if fixed else _UNUSED,
        "satellites_visible": 10 if fixed else 0,
    }


def _channels(vehicle: VehicleCondition) -> Fields:
    values = {f"chan{place}_raw": each for place, each in enumerate(vehicle.radio.channels, 1)}
    count = len(vehicle.radio.channels) if vehicle.receiver else 0
    return {"time_boot_ms": vehicle.age_ms, "chancount": count, "rssi": 255, **values}


def _servos(vehicle: VehicleCondition) -> Fields:
    state = vehicle.motion
    off = round(100.0 * state.ahead), round(100.0 * state.turn)
    left, right = (max(1100, min(1900, 1500 + each)) for each in (off[0] + off[1], off[0] - off[1]))
    return {
        "time_usec": vehicle.age_ms * 1000 & 0xFFFFFFFF,
        "servo1_raw": left,
        "servo3_raw": right,
    }


def _pressure(vehicle: VehicleCondition) -> Fields:
    return {
        "time_boot_ms": vehicle.age_ms,
        "press_abs": _AIR + max(0.0, vehicle.motion.down) * _WATER,
        "temperature": 1496 if vehicle.kind.name == "sub" else 3335,
    }


def _truth(vehicle: VehicleCondition) -> Fields:
    state = vehicle.motion
    north, east = state.ground
    latitude, longitude = _place(vehicle)
    return {
        "roll": state.roll,
        "pitch": state.pitch,
        "yaw": state.yaw,
        "zacc": -9.80665,
        "zgyro": state.turn,
        "lat": float(latitude),
        "lon": float(longitude),
        "alt": -state.down,
        "vn": north,
        "ve": east,
        "vd": state.sinking,
        "lat_int": latitude,
        "lon_int": longitude,
    }


def _gimbal(vehicle: VehicleCondition) -> Fields | None:
    if vehicle.kind.name != "sub":
        return None
    turn = (math.cos(vehicle.tilt / 2.0), 0.0, math.sin(vehicle.tilt / 2.0), 0.0)
    return {"time_boot_ms": vehicle.age_ms, "q": turn, "flags": 44, "gimbal_device_id": 1}


def _home(vehicle: VehicleCondition) -> Fields | None:
    if not vehicle.has_origin:
        return None
    return {
        "latitude": round(HOME[0] * 1e7),
        "longitude": round(HOME[1] * 1e7),
        "q": (math.nan,) * 4,
        "time_usec": vehicle.age_ms * 1000,
    }


def _origin(vehicle: VehicleCondition) -> Fields | None:
    if not vehicle.has_origin:
        return None
    return {
        "latitude": round(HOME[0] * 1e7),
        "longitude": round(HOME[1] * 1e7),
        "time_usec": vehicle.age_ms * 1000,
    }


def _version(vehicle: VehicleCondition) -> Fields:
    return {
        "capabilities": vehicle.kind.capabilities,
        "flight_sw_version": _VERSION,
        "flight_custom_version": tuple(b"2598e9d4"),
    }


def _mission(_vehicle: VehicleCondition) -> Fields:
    return {"total": 1, "mission_state": 1}


def _setpoint(vehicle: VehicleCondition) -> Fields | None:
    if vehicle.mode != vehicle.kind.guided_mode:
        return None
    ahead, right, down, turn = vehicle.setpoint
    cos, sin = math.cos(vehicle.motion.yaw), math.sin(vehicle.motion.yaw)
    return {
        "time_boot_ms": vehicle.age_ms,
        "coordinate_frame": 1,
        "vx": ahead * cos - right * sin,
        "vy": ahead * sin + right * cos,
        "vz": down,
        "yaw_rate": turn,
    }


def _nothing(_vehicle: VehicleCondition) -> None:
    return None


def heartbeat(vehicle: VehicleCondition) -> Fields:
    """HEARTBEAT."""
    return {
        "type": vehicle.kind.type,
        "autopilot": 3,
        "base_mode": vehicle.base_mode,
        "custom_mode": vehicle.mode,
        "system_status": vehicle.status,
        "mavlink_version": 3,
    }


def named_values(vehicle: VehicleCondition) -> dict[str, float]:
    """What a Sub tells by name."""
    if vehicle.kind.name != "sub":
        return {}
    return {
        "CamTilt": 0.5 + vehicle.tilt / math.pi,
        "CamPan": 0.5,
        "TetherTrn": 0.0,
        "Lights1": vehicle.lights[0],
        "Lights2": vehicle.lights[1],
        "PilotGain": vehicle.gain,
        "InputHold": 0.0,
        "RollPitch": 0.0,
        "RFTarget": -0.01,
    }


REPORTS: Final[Mapping[str, Callable[[VehicleCondition], Fields | None]]] = {
    "HEARTBEAT": heartbeat,
    "ATTITUDE": _attitude,
    "LOCAL_POSITION_NED": _local_position,
    "GLOBAL_POSITION_INT": _global_position,
    "VFR_HUD": _hud,
    "SYS_STATUS": _status,
    "BATTERY_STATUS": _battery,
    "EKF_STATUS_REPORT": _filter,
    "GPS_RAW_INT": _satellites,
    "RC_CHANNELS": _channels,
    "SERVO_OUTPUT_RAW": _servos,
    "SCALED_PRESSURE": _pressure,
    "SCALED_PRESSURE2": _pressure,
    "SIM_STATE": _truth,
    "SYSTEM_TIME": lambda vehicle: {"time_boot_ms": vehicle.age_ms},
    "GIMBAL_DEVICE_ATTITUDE_STATUS": _gimbal,
    "HOME_POSITION": _home,
    "GPS_GLOBAL_ORIGIN": _origin,
    "AUTOPILOT_VERSION": _version,
    "MISSION_CURRENT": _mission,
    "POSITION_TARGET_LOCAL_NED": _setpoint,
    "EXTENDED_SYS_STATE": lambda _vehicle: {},
    "VIBRATION": lambda vehicle: {"time_usec": vehicle.age_ms * 1000},
    "AHRS2": lambda vehicle: {"yaw": vehicle.motion.yaw},
    "NAMED_VALUE_FLOAT": _nothing,
    **dict.fromkeys(("DISTANCE_SENSOR", "RANGEFINDER", "CAMERA_INFORMATION"), _nothing),
    "VIDEO_STREAM_INFORMATION": _nothing,
    "FENCE_STATUS": _nothing,
}
"""The fields of each message; none: it does not come, though it may be asked for."""
_DEFAULT: Final = (
    "ATTITUDE",
    "AHRS2",
    "BATTERY_STATUS",
    "EKF_STATUS_REPORT",
    "GLOBAL_POSITION_INT",
    "GPS_RAW_INT",
    "LOCAL_POSITION_NED",
    "MISSION_CURRENT",
    "RC_CHANNELS",
    "SCALED_PRESSURE",
    "SCALED_PRESSURE2",
    "SERVO_OUTPUT_RAW",
    "SYSTEM_TIME",
    "SYS_STATUS",
    "VFR_HUD",
    "VIBRATION",
)
"""Messages that all streams together have."""
_OF_SUB: Final = ("GIMBAL_DEVICE_ATTITUDE_STATUS", "NAMED_VALUE_FLOAT")
_SUB_RATES: Final = {
    **dict.fromkeys(("ATTITUDE", "AHRS2", "VFR_HUD"), 10.0),
    **dict.fromkeys(("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "EKF_STATUS_REPORT"), 3.0),
    **dict.fromkeys(("BATTERY_STATUS", "SYSTEM_TIME", "VIBRATION", _OF_SUB[0]), 3.0),
}


def default_rates(kind: str) -> dict[str, float]:
    """The messages that a vehicle sends by itself, beside its heartbeat [Hz]."""
    if kind == "rover":
        return dict.fromkeys(_DEFAULT, 1.0)
    if kind == "sub":
        return {name: _SUB_RATES.get(name, 2.0) for name in (*_DEFAULT, *_OF_SUB)}
    return {}


def stream_messages(kind: str) -> tuple[str, ...]:
    """The messages of REQUEST_DATA_STREAM for all streams; a blimp has no missions."""
    if kind == "blimp":
        return tuple(name for name in _DEFAULT if name != "MISSION_CURRENT")
    return (*_DEFAULT, *_OF_SUB) if kind == "sub" else _DEFAULT
