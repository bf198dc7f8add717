"""The parts of the status line about a robot, with their weights."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Final

from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.navigation import MotionState
from hub.gcm.navigation import RobotState as NavigationState
from hub.gcm.ranges import RANGES
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.joystick_state import Absence, JoystickPhase, JoystickState
from rune_tui.model.robot_ranges import lack_of_ranges, ranges_of
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.model.robot_task import task_of
from rune_tui.model.vehicle import problems_of, remarks_of
from rune_tui.visualizers.parts.control_words import control_parts
from rune_tui.visualizers.parts.nearness import Nearness, avoids_obstacles, nearness_of
from rune_tui.visualizers.parts.recording_words import recording_parts
from rune_tui.visualizers.parts.severity import Part, Severity
from rune_tui.visualizers.parts.staleness import (
    ALARM_AFTER_S,
    HATCH_AFTER_S,
    MENTION_AFTER_S,
    Staleness,
    age_text,
    pause_of,
    staleness,
    usual_age,
)
from rune_tui.visualizers.parts.task_words import task_parts
from rune_tui.visualizers.words.motion_words import (
    READY,
    motion_words,
    other_speed_words,
    other_speeds,
    ready_words,
    short_motion,
)

START_S: Final = 10.0
"""Time after the start of a link in which a starting module is no problem [s]."""
NAME: Final = "name"
"""Cause of the part that names the robot."""
MOTION: Final = "motion"
"""Cause of the part that says how the robot moves."""
LOW_BATTERY = 0.2
CRITICAL_BATTERY = 0.1
OFF_CENTRE_DEG = 5.0
_LEAST_ZOOM = 0.01
_LET_GO_S = 1.0
"""Time without keys that shows that they are up, where their releases are not reported [s]."""
_HELD_BACK = 0.05

_SIDES = ("ahead", "left", "behind", "right")
_FAULTS = frozenset({MotionState.SILENCE, MotionState.NO_DRIVER})
"""Unintended states of motion; a stop is intended."""
_UNKNOWN_MOTION = "NO DRIVER: nobody knows whether it moves"
"""The motion once the driver's last measurement is outdated."""
_CAUSES = (("tilt", "tilted"), ("edge", "edge near"), ("range ", "sensor silent"))
"""Beginnings of the names of navigation's problems that slow the robot down, and their words."""


_WRITTEN: Final = tuple(
    each.name
    for each in dataclasses.fields(ConsoleState)
    if each.name not in ("banner", "attention", "drawn")
)
"""The fields of the console's state that decide about the parts."""
_newest: dict[str, tuple[RobotState, ConsoleState, tuple[Part, ...]]] = {}
"""The parts that were made last, by robot: a frame needs them three times."""


def status_parts(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    """All parts, in the order of the status line."""
    known = _newest.get(robot.name)
    if known is not None and known[0] is robot and _alike(known[1], state):
        return known[2]
    parts = _parts(robot, state)
    _newest[robot.name] = robot, state, parts
    return parts


def _alike(one: ConsoleState, other: ConsoleState) -> bool:
    """Whether two states are copies with the same values, besides what the view sets itself."""
    return one is other or all(getattr(one, name) is getattr(other, name) for name in _WRITTEN)


def _parts(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    return (
        *_stop_key(robot, state),
        *_peek(robot, state),
        Part(state.title(robot.name), 2 if len(state.robots) == 1 else 8, cause=NAME),
        _link(robot, state.now),
        *_permission(robot),
        *control_parts(robot, state),
        *_motion(robot, state),
        *_limit(robot, state),
        *_camera(robot, state.now),
        *_picture_age(robot, state),
        *_joysticks(state),
        *_recording(state),
        *recording_parts(robot),
        *_held(state),
        _release(state),
    )


def _stop_key(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """The stop key, while no line of keys says it."""
    if (words := stop_words(robot.name, state)) and not state.stop_shown:
        yield Part(words, 10)


def stop_words(robot: str, state: ConsoleState) -> str:
    """How a robot is stopped; empty: no key does."""
    key = state.input_of(Purpose.STOP, robot)
    return f"{key[:1].upper()}{key[1:]} STOP" if key else ""


def _peek(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """That the operator only looks at this robot."""
    if robot.name == state.peeked:
        yield Part("PEEK: keys drive nothing", 10, short="PEEK")


def _link(robot: RobotState, now: float) -> Part:
    seconds = f"{int(max(0.0, now - robot.link.since))} s"
    if robot.link.phase is LinkPhase.CONNECTED:
        return Part("linked", 2, Severity.GOOD, gauge=True)
    if robot.link.phase is LinkPhase.CONNECTING:
        return Part(f"connecting {seconds}", 9, Severity.WARNING, cause="link")
    lost = f"LINK LOST {seconds}"
    why = f": {robot.link.detail}" if robot.link.detail else ""
    return Part(lost + why, 9, Severity.ALARM, short=lost, cause="link")


def _permission(robot: RobotState) -> Iterator[Part]:
    if not robot.link.may_command:
        yield Part("OBSERVER: this key may watch and stop, not drive", 8, Severity.WARNING)


def _motion(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    now = state.now
    if robot.navigation is None:
        yield Part("no robot state yet", 7, Severity.WARNING, cause="state")
        return
    age = robot.navigation.age(now)
    navigation = robot.navigation.value
    old = staleness(age) is not Staleness.FRESH
    if old and robot.link.phase is LinkPhase.CONNECTED:
        yield Part(f"STATE {age_text(age)} OLD", 9, Severity.ALARM, cause="state")
    stale = _outdated(robot, age)
    lost = robot.link.phase is LinkPhase.CONNECTED and navigation.motion is MotionState.NO_DRIVER
    for part in (*_moving(robot, navigation, state), *_battery(navigation)):
        if stale and lost and part.cause == MOTION:  # nothing newer comes, and this is so now
            yield Part(_UNKNOWN_MOTION, part.weight, part.severity, "NO DRIVER", cause=part.cause)
        else:
            yield _past(part) if stale else part
    yield from _obstacles(robot, now, silent=old)


def _obstacles(robot: RobotState, now: float, *, silent: bool) -> Iterator[Part]:
    """The nearest obstacle, or why it is not known.

    Args:
        robot: The robot.
        now: Present time [s].
        silent: Whether the words about the robot's state report its silence already.
    """
    linked = robot.link.phase is LinkPhase.CONNECTED
    measured = robot.newest(RANGES)
    if (lack := lack_of_ranges(robot)) and linked:
        late = now - robot.link.since >= START_S
        cause = "ranges" if late else ""
        yield Part(lack, 5, Severity.WARNING, short="no ranges", cause=cause)
    if lack or measured is None:
        return
    age = measured.age(now)
    if linked and not silent and staleness(age) is not Staleness.FRESH:
        yield Part(f"RANGES {age_text(age)} OLD", 8, Severity.ALARM, cause="ranges")
    nearest = _nearest(robot, now)
    yield from map(_past, nearest) if _outdated(robot, age) else nearest


def _outdated(robot: RobotState, age: float) -> bool:
    """Whether what was reported this long ago [s] may have changed: at once without a link."""
    return robot.link.phase is LinkPhase.LOST or staleness(age) is Staleness.STALE


def _past(part: Part) -> Part:
    """The words of an outdated report."""
    short = f"was {part.short}" if part.short else ""
    weight = min(part.weight, 4)
    return Part(f"was {part.text}", weight, Severity.FAINT, short, part.gauge, part.cause)


def _moving(robot: RobotState, navigation: NavigationState, state: ConsoleState) -> Iterator[Part]:
    """The robot's motion and its speed."""
    motion, now = navigation.motion, state.now
    if motion is MotionState.WAITING and not robot.link.may_command:
        motion = MotionState.STANDING  # an observer sends no neutral command
    text = motion_words(robot, motion, now)
    text = ready_words(robot, state) if text == READY else text
    by_itself = tuple(task_parts(robot, state))
    if motion is not MotionState.GOING or not by_itself:
        severity = Severity.ALARM if motion in _FAULTS else Severity.PLAIN
        yield Part(text, 7, severity, short=short_motion(text), cause=MOTION)
    yield from by_itself
    turning = turn_words(-math.degrees(navigation.angular))
    speed = f"{signed(navigation.linear, 2)} m/s"
    yield Part(f"{speed} {turning}°/s", 6, short=speed, gauge=True)
    for words in other_speed_words(*other_speeds(robot, navigation)):
        yield Part(words, 6, gauge=True)
    if motion is MotionState.MOVING and navigation.held_back >= _HELD_BACK:
        held = f"HELD BACK {navigation.held_back:.0%}"
        why = _causes(robot, now)
        yield Part(f"{held} ({why})" if why else held, 6, Severity.WARNING, short=held)


def _causes(robot: RobotState, now: float) -> str:
    """Present problems that slow the robot down, besides obstacles."""
    names = [
        problem.value.name
        for problem in problems_of(robot)
        if staleness(problem.age(now), pause_of(DIAGNOSTICS)) is Staleness.FRESH
    ]
    return ", ".join(
        words for start, words in _CAUSES if any(name.startswith(start) for name in names)
    )


def turn_words(degrees: float) -> str:
    """A turn [deg/s, positive to the right] without its unit, such as "left 13"."""
    if not math.isfinite(degrees):
        return "?"
    shown = round(abs(degrees))
    side = "right " if degrees > 0.0 else "left "
    return f"{side if shown else ''}{shown}"


def _battery(navigation: NavigationState) -> Iterator[Part]:
    words = []
    if math.isfinite(navigation.battery_fraction):
        words.append(f"{100.0 * navigation.battery_fraction:.0f}%")
    if math.isfinite(navigation.battery_voltage):
        words.append(f"{navigation.battery_voltage:.1f} V")
    if not words:
        return
    low = navigation.battery_fraction < LOW_BATTERY
    grave = "CRITICAL" if navigation.battery_fraction < CRITICAL_BATTERY else "LOW"
    text = " ".join([f"BATTERY {grave}" if low else "battery", *words])
    severity = (
        (Severity.ALARM if grave == "CRITICAL" else Severity.WARNING) if low else Severity.PLAIN
    )
    short = " ".join(text.split()[: 3 if low else 2])
    yield Part(text, 6 if low else 4.5, severity, short, gauge=not low, cause="battery")


def _nearest(robot: RobotState, now: float) -> Iterator[Part]:
    """The nearest obstacle and its distance from the robot's footprint."""
    ranges = ranges_of(robot)
    number = ranges.nearest if ranges is not None else None
    if ranges is None or number is None:
        return
    room = float(ranges.room[number])
    word, weight, severity = _NEAREST[nearness_of(room, avoids=avoids_obstacles(robot, now))]
    text = f"{word} {room:.2f} m {side_of(ranges.bearing(number))}"
    yield Part(text, weight, severity, cause="near" if severity is Severity.ALARM else "")


_NEAREST = {
    Nearness.FAR: ("nearest", 5, Severity.PLAIN),
    Nearness.NEAR: ("NEAR", 5, Severity.WARNING),
    Nearness.CLOSE: ("CLOSE", 7, Severity.ALARM),
}
"""The name of the nearest obstacle, its weight, and its severity."""


def _limit(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """The share of its speed at which hands drive the robot, apart from its own tasks."""
    task = task_of(robot)
    if _goes(robot) or (task is not None and task.under_way):
        return
    limit = state.speed_limit(robot.name)
    text = f"limit {100.0 * limit:.0f}%"
    yield Part(text, 6) if limit < 1.0 else Part(text, 0, Severity.FAINT)


def _goes(robot: RobotState) -> bool:
    """Whether the robot moves by itself."""
    return robot.navigation is not None and robot.navigation.value.motion is MotionState.GOING


def _camera(robot: RobotState, now: float) -> Iterator[Part]:
    """The camera's direction, if it is not straight ahead and wide."""
    if robot.camera is None:
        return
    if robot.camera.age(now) > HATCH_AFTER_S:
        return
    pan, zoom = math.degrees(robot.camera.value.pan), robot.camera.value.zoom
    if math.isfinite(pan) and abs(pan) > OFF_CENTRE_DEG:
        yield Part(f"camera {abs(pan):.0f}° {'left' if pan > 0 else 'right'}", 4, Severity.WARNING)
    if math.isfinite(zoom) and zoom >= _LEAST_ZOOM:
        yield Part(f"zoom {zoom:.0%}", 3)


def _picture_age(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """The age of the oldest picture on the screen, if it matters."""
    pictures = robot.all_pictures
    if not pictures or robot.link.phase is not LinkPhase.CONNECTED:
        return
    camera = min(pictures, key=lambda name: pictures[name].measured)
    age = pictures[camera].age(state.now) + state.latency
    prefix = f"{camera} " if camera else ""
    usual = usual_age(pictures[camera].value)
    if age > max(ALARM_AFTER_S, usual):
        text = f"{prefix.upper()}PICTURE {age_text(age)} OLD"
        yield Part(text, 8, Severity.ALARM, cause="picture")
    elif age > max(MENTION_AFTER_S, usual):
        yield Part(f"{prefix}picture {age_text(age)} old", 5)
    for remark in remarks_of(robot):
        if staleness(remark.age(state.now), pause_of(DIAGNOSTICS)) is Staleness.FRESH:
            yield Part(remark.value.message, 4)


def _joysticks(state: ConsoleState) -> Iterator[Part]:
    """Joysticks that do not work; equal ones are counted."""
    alike: dict[tuple[str, Severity, bool], list[str]] = {}
    for joystick in state.joysticks.values():
        lacks = joystick.phase is JoystickPhase.CONNECTED and bool(joystick.why)
        alike.setdefault((*joystick_words(joystick), lacks), []).append(joystick.name)
    for (text, severity, lacks), names in alike.items():
        name = names[0] if len(names) == 1 else f"{len(names)} joysticks"
        if lacks:
            yield Part(f"{name} {text}", 2, severity, short=f"{name} LACKS CONTROLS")
        elif severity is Severity.PLAIN:
            short = f"no {names[0] if len(names) == 1 else 'joysticks'}"
            yield Part(f"{name} {text}", 0, severity, short=short)
        elif severity is not Severity.GOOD:
            yield Part(f"{name} {text}", 8, severity)


def joystick_words(joystick: JoystickState) -> tuple[str, Severity]:
    """The state of a joystick and its device, in few words."""
    match joystick.phase:
        case JoystickPhase.CONNECTED if joystick.why:
            return joystick.why, Severity.WARNING
        case JoystickPhase.CONNECTED if joystick.waiting:
            return f"LET GO OF {', '.join(sorted(joystick.waiting))} FIRST", Severity.WARNING
        case JoystickPhase.CONNECTED:
            return "plugged in", Severity.GOOD
        case JoystickPhase.FORBIDDEN:
            return "NO PERMISSION", Severity.WARNING
        case JoystickPhase.UNSUITABLE:
            return "UNUSABLE", Severity.WARNING
        case JoystickPhase.MISSING if joystick.lost:
            return _absence(joystick), Severity.ALARM
        case JoystickPhase.MISSING:
            return "not plugged in", Severity.PLAIN


def _absence(joystick: JoystickState) -> str:
    there = " there" if joystick.machine and joystick.absence is not Absence.SILENT else ""
    return f"{joystick.absence.name}{there}"


def _recording(state: ConsoleState) -> Iterator[Part]:
    if state.recording:
        yield Part("REC", 8)


def _held(state: ConsoleState) -> Iterator[Part]:
    if state.must_release:
        keys = " ".join(state.must_release)
        go = f"LET GO OF {keys}"
        text = f"{go} FIRST" if state.releases_reported else f"{go} FOR {_LET_GO_S:.0f} s FIRST"
        text = f"{go}, TAP, THEN HOLD" if state.tap_first else text
        yield Part(text, 8, Severity.WARNING, short=go)
    if state.held:
        yield Part(f"keys {' '.join(state.held)}", 1)


def _release(state: ConsoleState) -> Part:
    """The duration of a hold."""
    if state.releases_reported:
        return Part("release: exact", 0, Severity.FAINT)
    return Part(f"release: timed {state.hold_s:.2f} s", 0, Severity.FAINT, short="release: timed")


def side_of(bearing: float) -> str:
    """The side of a direction [rad]; each takes a quarter of the circle around its middle."""
    # A rounding error must not decide about a corner.
    return _SIDES[round(round(bearing / (math.pi / 2.0), 6)) % 4]


def signed(value: float, digits: int) -> str:
    """A number with its sign; zero has none."""
    if not math.isfinite(value):
        return "?"
    rounded = round(value, digits)
    return f"{rounded:+.{digits}f}" if rounded else f"{0.0:.{digits}f}"


def signed_forms(value: float, digits: int) -> Iterator[str]:
    """A number with its sign, the most exact first: "+0.37", "+.37", "+0.4", "+.4", "+…".

    No form but the last one shows a value as zero that is not.
    """
    exact = signed(value, digits)
    for count in range(digits, -1, -1):
        form = signed(value, count)
        if form == "?" or (float(form) == 0.0) == (float(exact) == 0.0):
            yield form
            yield form.replace("0.", ".", 1) if form[:2] in ("+0", "-0") and count else form
    if exact[0] in "+-":
        yield f"{exact[0]}…"
