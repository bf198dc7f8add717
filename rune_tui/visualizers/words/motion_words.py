"""How a robot moves, in words; the status line and the team use them.

| motion | the robot | words |
| --- | --- | --- |
| NO_DRIVER | any | the motion |
| another | is disarmed | DISARMED |
| MOVING | does not follow, because its autopilot is in a mode of its own | DOES NOT FOLLOW |
| MOVING, GOING | any other | the motion |
| another | moves in a mode of its autopilot's own | MOVES BY ITSELF |
| another | moves without a command | STOPPING |
| STANDING | has a word of its own | that word, such as HOLDS |
| another | none of these | the motion |

Air and water carry a body that flies or dives. It moves without a command from 0.1 m/s on. While
one of its holds works, and the motion is STANDING or WAITING, it never does.
"""

from __future__ import annotations

import math

from hub.gcm.autopilot import AutopilotPhase
from hub.gcm.body import Freedom
from hub.gcm.navigation import MotionState
from hub.gcm.navigation import RobotState as NavigationState
from hub.gcm.vehicle import VEHICLE_STATE, Arming, HoldPhase, VehicleState
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.control import Standing, standing
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import autopilot_of
from rune_tui.visualizers.parts.staleness import Staleness, pause_of, staleness

ROLLING = 0.02
"""Least speed of a moving robot: along [m/s], and turning twice that [rad/s]."""
DRIFTING = 0.1
"""The same of a robot that flies or dives."""
_DRIVEN = frozenset({MotionState.MOVING, MotionState.GOING})
_READY = frozenset({MotionState.STANDING, MotionState.WAITING})
_USUAL = frozenset({"stands", "drives"})
"""Activities that say no more than the state of motion."""

HOLD_FAILS = "HOLD FAILS"
READY = "READY"
_LET_GO = "WAITING: let go of all keys"
_MOTION = {
    MotionState.STANDING: "STANDING",
    MotionState.MOVING: "MOVING",
    MotionState.SILENCE: "STOPPED: commands fell silent",
    MotionState.STOPPED: "STOPPED: a stop was sent",
    MotionState.NO_DRIVER: "NO DRIVER: cannot move",
    MotionState.WAITING: READY,
    MotionState.GOING: "GOING by itself",
}
_ROLLING_ON = {
    MotionState.STANDING: "STOPPING",
    MotionState.SILENCE: "STOPPING: commands fell silent",
    MotionState.STOPPED: "STOPPING: a stop was sent",
    MotionState.NO_DRIVER: "NO DRIVER, and it moves",
    MotionState.WAITING: "STOPPING",
}
"""The same while the robot still moves without a command."""
_SHORT_MOTION = {
    _LET_GO: "LET GO",
    "STOPPED: commands fell silent": "STOPPED: silence",
    "STOPPED: a stop was sent": "STOPPED",
    "STOPPING: commands fell silent": "STOPPING",
    "STOPPING: a stop was sent": "STOPPING",
}


def motion_words(robot: RobotState, motion: MotionState, now: float) -> str:
    """The state of motion, in the words of the table."""
    if is_disarmed(robot, motion, now):
        return "DISARMED"
    if apart := words_apart(robot, motion, now):
        return apart
    if moves_on(robot, motion, now):
        return _ROLLING_ON[motion]
    own = activity(robot, now)
    return own.upper() if motion is MotionState.STANDING and own else _MOTION[motion]


def short_motion(words: str) -> str:
    """Fewer words for these `motion_words`; empty: there are none."""
    if words.startswith(f"{READY}:"):
        return READY
    return "NO HOLD" if words.startswith(HOLD_FAILS) else _SHORT_MOTION.get(words, "")


def ready_words(robot: RobotState, state: ConsoleState) -> str:
    """The words for a robot that stands and waits for a neutral command.

    | control | keys | words |
    | --- | --- | --- |
    | another console's, or the operator may not drive | any | STANDING |
    | another | some are down | they must go up first |
    | another | all are up | READY, and the key that drives |
    """
    if not robot.link.may_command or standing(robot) is Standing.OTHERS:
        return _MOTION[MotionState.STANDING]
    if state.held or state.must_release:
        return _LET_GO
    key = state.input_of(Purpose.DRIVE, robot.name)
    return f"{READY}: press {key.upper() if len(key) == 1 else key}" if key else READY


def is_disarmed(robot: RobotState, motion: MotionState, now: float) -> bool:
    """Whether the motors are off, and the driver still reports."""
    vehicle = fresh_vehicle(robot, now)
    reports = motion is not MotionState.NO_DRIVER
    return reports and vehicle is not None and vehicle.arming is Arming.DISARMED


def words_apart(robot: RobotState, motion: MotionState, now: float) -> str:
    """What a vehicle does whose autopilot does not follow commands; empty: no more than others."""
    autopilot = autopilot_of(robot)
    if autopilot is None or autopilot.phase is AutopilotPhase.DRIVING:
        return ""
    if motion is MotionState.MOVING:
        return "DOES NOT FOLLOW"
    by_itself = motion is not MotionState.NO_DRIVER and moves_on(robot, motion, now)
    return "MOVES BY ITSELF" if by_itself else ""


def moves_on(robot: RobotState, motion: MotionState, now: float) -> bool:
    """Whether the robot moves without a command, so that people have to keep clear."""
    known = robot.navigation
    if known is None or motion in _DRIVEN:
        return False
    floats = has_freedom(robot, Freedom.HEAVE)
    vehicle = fresh_vehicle(robot, now)
    holds = vehicle is not None and any(hold.phase is HoldPhase.HOLDING for hold in vehicle.holds)
    if floats and holds and motion in _READY:
        return False
    least = DRIFTING if floats else ROLLING
    state = known.value
    along = math.hypot(*map(_known, (state.linear, state.sway, state.heave)))
    return max(along, abs(_known(state.angular)) / 2.0) >= least


def activity(robot: RobotState, now: float) -> str:
    """The vehicle's own word for what it does; empty: the state of motion says as much."""
    vehicle = fresh_vehicle(robot, now)
    if vehicle is None:
        return ""
    failing = [hold for hold in vehicle.holds if hold.phase is HoldPhase.FAILING]
    if failing:
        return f"{HOLD_FAILS}: {' '.join(hold.kind.name.lower() for hold in failing)}"
    return "" if vehicle.activity in _USUAL else vehicle.activity


def fresh_vehicle(robot: RobotState, now: float) -> VehicleState | None:
    """The state of the vehicle; None: none, or an outdated one."""
    known = robot.newest(VEHICLE_STATE)
    if known is None or staleness(known.age(now), pause_of(VEHICLE_STATE)) is Staleness.STALE:
        return None
    return known.value


def has_freedom(robot: RobotState, freedom: Freedom) -> bool:
    """Whether commands move the robot in this degree of freedom."""
    motions = robot.body.motions if robot.body is not None else ()
    return any(motion.freedom is freedom for motion in motions)


def other_speeds(robot: RobotState, state: NavigationState) -> tuple[float, float]:
    """Speeds to the left and upward [m/s]; 0 without that freedom, or too slow to matter.

    A robot that flies or dives drifts to the side too. Without a description both count.
    """
    floats = robot.body is None or has_freedom(robot, Freedom.HEAVE)
    sideways = floats or has_freedom(robot, Freedom.SWAY)
    sway, heave = _known(state.sway) * sideways, _known(state.heave) * floats
    return (sway if abs(sway) >= ROLLING else 0.0, heave if abs(heave) >= ROLLING else 0.0)


def other_speed_words(sway: float, heave: float) -> tuple[str, ...]:
    """The speeds of `other_speeds` that are not 0, in words."""
    side = f"{abs(sway):.2f} m/s to the {'left' if sway > 0.0 else 'right'}"
    climb = f"{abs(heave):.2f} m/s {'up' if heave > 0.0 else 'down'}"
    return (side,) * bool(sway) + (climb,) * bool(heave)


def along_words(ahead: str, sway: float, heave: float) -> str:
    """The speed ahead, in words, with those of `other_speeds`: "+0.25, right 0.40 m/s"."""
    side = f"{'left' if sway > 0.0 else 'right'} {abs(sway):.2f}"
    climb = f"{'up' if heave > 0.0 else 'down'} {abs(heave):.2f}"
    return f"{', '.join((ahead, *(side,) * bool(sway), *(climb,) * bool(heave)))} m/s"


def _known(speed: float) -> float:
    return speed if math.isfinite(speed) else 0.0
