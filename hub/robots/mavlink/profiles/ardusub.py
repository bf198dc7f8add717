"""ArduPilot's Sub: sticks in POSHOLD, or in depth hold where it does not know its place."""

from __future__ import annotations

import math
from typing import Final

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

BUTTON_FUNCTIONS: Final = tuple(f"BTN{number}_FUNCTION" for number in range(16))
"""The function of each button of a joystick, by its bit."""
LIGHT_STEPS: Final = "JS_LIGHTS_STEPS"
_POSITION_HOLD: Final = 16
_DEPTH_HOLD: Final = 2
_SURFACE: Final = 9
_FULL_AHEAD: Final = 2.08
"""Speed at full thrust, measured on a simulated Sub [m/s]: 0.52 at a quarter of the output."""
_FULL_ASIDE: Final = 1.83
"""The same sideways [m/s], by the simulator's drag: 1.8 in place of 1.4."""
_STICK_US: Final = 400.0
"""Travel of a stick's channel to each side [us]."""
_ACRO_TURN: Final = math.radians(45.0)
"""Turn rate of a full stick, per unit of ACRO_YAW_P [rad/s]."""
_BRAKING: Final = Braking(delay=0.2, per_speed=3.0, least=1.6)
"""Measured on a simulated Sub in POSHOLD: 1.81 s from 0.31 m/s, 2.0 s from 0.26 m/s and more."""
_AFTER_SILENCE_S: Final = 2.7
"""Time until it stands after it noticed the silence [s]: 2.0 to 2.7 in POSHOLD, else up to 3.9."""
_DISARM: Final = 2.0
"""Action of a failsafe: disarm."""
_COASTING_S: Final = 3.9
"""Time until it stands after it was disarmed, before it rises [s]."""
_MODES: Final = {
    0: "stabilize",
    1: "acro",
    2: "depth hold",
    3: "auto",
    4: "guided",
    7: "circle",
    9: "surface",
    16: "position hold",
    19: "manual",
    20: "motor detect",
    21: "surftrak",
}


def _dead(parameters: Parameters, name: str, usual: float) -> float:
    """The dead zone of a stick [us]; one that is none, or as wide as the stick, counts as usual."""
    value = parameters.get(name, usual)
    return value if 0.0 <= value < _STICK_US else usual


def _axis(speed: float, most: float, gain: float, dead: float) -> int:
    """The stick for a speed: its gain and dead zone undone.

    ArduSub makes 400 us * gain of a full stick. THR_DZ of it is dead; the rest is a share of the
    pilot's speed.
    """
    if not speed or not most > 0.0:
        return 0
    return stick(math.copysign(abs(speed) / most / gain + dead / _STICK_US, speed))


def _climb(speed: float, parameters: Parameters, gain: float) -> int:
    """The vertical stick, 0 to 1000, for a speed upwards [m/s]."""
    rise = parameters.get("PILOT_SPEED_UP", math.nan) / 100.0
    if not speed or math.isnan(rise):
        return 500
    sink = parameters.get("PILOT_SPEED_DN", 0.0) / 100.0 or rise
    dead = _dead(parameters, "THR_DZ", 100.0) * gain
    share = min(1.0, abs(speed) / max(0.01, rise if speed > 0.0 else sink))
    travel = dead + (500.0 - dead) * share
    scale = gain * max(0.1, parameters.get("JS_THR_GAIN", 1.0))
    return 500 + round(math.copysign(min(500.0, travel / scale), speed))


def _turn(rate: float, parameters: Parameters, gain: float) -> int:
    """The stick for a turn rate, clockwise positive, for one counter-clockwise [rad/s]."""
    if not rate or "ACRO_YAW_P" not in parameters:
        return 0
    full = _ACRO_TURN * max(0.1, parameters["ACRO_YAW_P"])
    dead = _dead(parameters, "RC4_DZ", 40.0) * gain
    travel = dead + (_STICK_US - dead) * min(1.0, abs(rate) / full)
    return stick(math.copysign(travel / _STICK_US / gain, -rate))


def _squared(value: float) -> float:
    return math.copysign(value * value, value)


def _outputs(ahead: float, left: float) -> tuple[float, float]:
    """The sticks ahead and right, -1 to 1 at full gain, for a speed in depth hold [m/s].

    Four thrusters push at 45 degrees. Their thrust and the drag are quadratic: the thrust in the
    output, the drag in the speed. One output is ahead + right, the other ahead - right.
    """
    drag, aside = _squared(ahead / _FULL_AHEAD), _squared(-left / _FULL_ASIDE)
    one, other = (
        math.copysign(math.sqrt(abs(each)), each) for each in (drag + aside, drag - aside)
    )
    return (one + other) / 2.0, (one - other) / 2.0


def _setpoint(wanted: Setpoint, parameters: Parameters, gain: float) -> tuple[Message, ...]:
    gain = _known_gain(gain, parameters)
    most = parameters.get("PILOT_SPEED", math.nan) / 100.0
    dead = _dead(parameters, "THR_DZ", 100.0)
    flat = {
        "x": _axis(wanted.ahead, most, gain, dead),
        "y": _axis(-wanted.left, most, gain, dead),
    }
    return _sticks(flat, wanted, parameters, gain)


def _thrust_setpoint(wanted: Setpoint, parameters: Parameters, gain: float) -> tuple[Message, ...]:
    gain = _known_gain(gain, parameters)
    ahead, right = _outputs(wanted.ahead, wanted.left)
    flat = {"x": stick(ahead / gain), "y": stick(right / gain)}
    return _sticks(flat, wanted, parameters, gain)


def _known_gain(gain: float, parameters: Parameters) -> float:
    known = gain if math.isfinite(gain) else parameters.get("JS_GAIN_DEFAULT", 1.0)
    return min(1.0, max(0.05, known))


def _sticks(
    flat: dict[str, int], wanted: Setpoint, parameters: Parameters, gain: float
) -> tuple[Message, ...]:
    """The message of sticks ahead and sideways, with those for climbing and turning."""
    z, r = _climb(wanted.up, parameters, gain), _turn(wanted.turn, parameters, gain)
    return (("MANUAL_CONTROL", {**flat, "z": z, "r": r}),)


def _stops(parameters: Parameters, speed: float, *, receiver: bool) -> tuple[float, float]:
    """After the link is cut, sticks end by FS_PILOT_INPUT, or the station's failsafe disarms.

    Other actions of the station's failsafe go on with the last sticks. With a receiver, its own
    sticks keep FS_PILOT_INPUT from acting.
    """
    cuts = [NEVER]
    pilot = parameters.get("FS_PILOT_INPUT", math.nan)
    if pilot and not receiver:
        rest = _COASTING_S if pilot == _DISARM else _AFTER_SILENCE_S
        cuts.append(parameters.get("FS_PILOT_TIMEOUT", math.nan) + rest)
    station = parameters.get("FS_GCS_ENABLE", math.nan)
    if station == _DISARM:
        cuts.append(parameters.get("FS_GCS_TIMEOUT", math.nan) + _COASTING_S)
    unknown = [each for each in (*cuts, pilot, station) if math.isnan(each)]
    known = [each for each in cuts if not math.isnan(each)]
    after_cut = min(known)
    return _BRAKING.time(speed), math.nan if unknown and after_cut == NEVER else after_cut


SUB: Final = VehicleProfile(
    name="sub",
    autopilot="ArduPilot",
    verified=True,
    types=frozenset({12}),
    modes=_MODES,
    drives=(_POSITION_HOLD, _DEPTH_HOLD),
    need_place=frozenset({_POSITION_HOLD}),
    holds=_DEPTH_HOLD,
    offered=(_POSITION_HOLD, _DEPTH_HOLD, _SURFACE, 0, 19),
    alone={
        LeftAlone.STAND: _DEPTH_HOLD,
        LeftAlone.HOLD_HEIGHT: _DEPTH_HOLD,
        LeftAlone.SURFACE: _SURFACE,
    },
    rates={**STREAMS, "GIMBAL_DEVICE_ATTITUDE_STATUS": 5.0},
    wanted=(
        WantedParameter(
            name="FS_PILOT_INPUT",
            allowed=(1.0,),
            why="without a receiver it keeps the last sticks for ever (0), or disarms (2)",
        ),
        WantedParameter(
            name="FS_PILOT_TIMEOUT",
            allowed=(0.5, 0.3),
            why="it keeps the last sticks for this time",
        ),
        WantedParameter(
            name="FS_GCS_ENABLE",
            allowed=(4.0, 3.0),
            why="it does not come up, or is disarmed, when the ground station is silent",
        ),
        WantedParameter(
            name="FS_GCS_TIMEOUT",
            allowed=(2.0, 1.5),
            why="it notices the loss of the ground station late",
        ),
        STATION_WANTED,
    ),
    scales=("PILOT_SPEED", "PILOT_SPEED_UP", "ACRO_YAW_P"),
    reads=(
        "PILOT_SPEED_DN",
        "THR_DZ",
        "RC4_DZ",
        "JS_THR_GAIN",
        "JS_GAIN_DEFAULT",
    ),
    later=(LIGHT_STEPS, *BUTTON_FUNCTIONS),
    frees=("ahead", "left", "up", "turn"),
    setpoint=_setpoint,
    open_loop=(frozenset({_DEPTH_HOLD}), _thrust_setpoint),
    stops=_stops,
    coasts=lambda _: True,
)
