"""The words of one row of the team: who a robot is, what it does, and what is wrong with it."""

from __future__ import annotations

import math
from typing import Final

from hub.gcm.flight import ALTITUDE
from hub.gcm.navigation import MotionState
from hub.gcm.vehicle import HoldPhase
from hub.values import dataclass
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.control import Standing, asks, control_of, standing
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.model.robot_task import task_of
from rune_tui.model.vehicle import hears_problems, vehicle_of
from rune_tui.visualizers.parts.severity import Part, Severity
from rune_tui.visualizers.parts.staleness import Staleness, age_text, staleness
from rune_tui.visualizers.parts.task_words import duration, head
from rune_tui.visualizers.words.motion_words import (
    HOLD_FAILS,
    activity,
    is_disarmed,
    moves_on,
    words_apart,
)
from rune_tui.visualizers.words.status_words import CRITICAL_BATTERY, LOW_BATTERY
from rune_tui.visualizers.words.troubles import troubles
from rune_tui.visualizers.words.vehicle import target_words

_SIMULATED = "simulated-"
_DOES = {
    MotionState.STANDING: "stands",
    MotionState.MOVING: "drives",
    MotionState.SILENCE: "STOPPED: silence",
    MotionState.STOPPED: "STOPPED",
    MotionState.NO_DRIVER: "NO DRIVER",
    MotionState.WAITING: "ready",
    MotionState.GOING: "goes by itself",
}
_QUIET = frozenset({MotionState.STANDING, MotionState.MOVING})
"""States of motion that the vehicle's own word describes better."""
_LEAST_WIDTHS = (1, 0, 0, 4, 8, 8, 4, 11, 13, 0)
"""Widths of the cells, so that columns stay where they are while words change [cells]."""
_SIGNS = {Severity.ALARM: "!! ", Severity.WARNING: "! "}


WELL: Final = (0, 0.0)
"""The rank of a robot without problems, as its modules report; not known is above it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamRow:
    """One robot of the team.

    Attributes:
        name: Its role.
        chosen: Whether it is the chosen robot.
        peeked: Whether the operator peeks at it.
        cells: Key, name, kind, control, what it does, link, battery, height or depth, time since
            it was looked at, worst problem.
        severities: The severity of each cell.
        rank: The order of its problems: more is worse.
    """

    name: str
    chosen: bool
    peeked: bool
    cells: tuple[str, ...]
    severities: tuple[Severity, ...]
    rank: tuple[int, float]


def team_row(robot: RobotState, state: ConsoleState) -> TeamRow:
    """The row of a robot."""
    name, title = robot.name, state.title(robot.name)
    chosen, peeked = name == state.chosen, name == state.peeked
    worst, rank = _worst(robot, state)
    cells = (
        Part(state.inputs.get((Purpose.CHOOSE_ROBOT, name), ""), 0),
        Part(f"{'▶' if chosen else '»' if peeked else ' '} {title}", 0),
        Part(_kind(robot, title), 0),
        _control(robot),
        does(robot, state.now),
        _link(robot, state.now),
        _battery(robot, state.now),
        Part(_level(robot, state.now), 0),
        Part(_looked(robot, state), 0),
        worst,
    )
    return TeamRow(
        name=name,
        chosen=chosen,
        peeked=peeked,
        cells=tuple(
            part.text and part.text.ljust(width)
            for part, width in zip(cells, _LEAST_WIDTHS, strict=True)
        ),
        severities=tuple(part.severity for part in cells),
        rank=rank,
    )


def _worst(robot: RobotState, state: ConsoleState) -> tuple[Part, tuple[int, float]]:
    """The worst problem with the number of the others, and its rank."""
    found = [part for part in troubles(robot, state) if part.cause]
    if not found:
        if hears_problems(robot, state.now):
            return Part("all well", 0, Severity.FAINT), WELL
        return Part("not known yet", 0, Severity.FAINT), (0, 1.0)
    worst = found[0]
    more = f" +{len(found) - 1}" if len(found) > 1 else ""
    text = f"{_SIGNS[worst.severity]}{worst.short or worst.text}{more}"
    rank = 2 if worst.severity is Severity.ALARM else 1
    return Part(text, 0, worst.severity), (rank, worst.weight)


def _kind(robot: RobotState, title: str) -> str:
    kind = robot.body.kind.removeprefix(_SIMULATED) if robot.body is not None else ""
    return "" if kind == title else kind


def _control(robot: RobotState) -> Part:
    control, stands = control_of(robot), standing(robot)
    if control is None:
        return Part("", 0)
    if stands is Standing.MINE and control.asker:
        return Part(f"{control.asker_operator} ASKS", 0, Severity.ALARM)
    if stands is Standing.MINE:
        return Part("you", 0, Severity.GOOD)
    if stands is Standing.FREE:
        return Part("free", 0, Severity.FAINT)
    return Part(f"{control.operator}{', asked' if asks(robot) else ''}", 0, Severity.WARNING)


def does(robot: RobotState, now: float) -> Part:
    """What a robot does, in few words; "?" if that is not known now."""
    known = robot.navigation
    old = known is None or staleness(known.age(now)) is Staleness.STALE
    if known is None or old or robot.link.phase is not LinkPhase.CONNECTED:
        return Part("?", 0, Severity.WARNING)
    motion = known.value.motion
    task = task_of(robot)
    if motion is MotionState.GOING and task is not None and task.under_way:
        return Part(head(task).lower(), 0)
    if is_disarmed(robot, motion, now):
        return Part("disarmed", 0)
    if apart := words_apart(robot, motion, now):
        return Part(apart, 0)
    if motion is not MotionState.NO_DRIVER and moves_on(robot, motion, now):
        return Part("STOPPING", 0)
    if motion in _QUIET and (own := activity(robot, now)):
        if own.startswith(HOLD_FAILS):
            return Part(own, 0, Severity.ALARM)
        return Part(f"{own}{_targets(robot)}", 0)
    severity = Severity.ALARM if motion is MotionState.NO_DRIVER else Severity.PLAIN
    return Part(_DOES[motion], 0, severity)


def _targets(robot: RobotState) -> str:
    """The targets of the holds."""
    vehicle = vehicle_of(robot)
    return "".join(
        f" {target_words(hold)}"
        for hold in (vehicle.holds if vehicle is not None else ())
        if hold.phase is HoldPhase.HOLDING and math.isfinite(hold.target)
    )


def _link(robot: RobotState, now: float) -> Part:
    seconds = duration(now - robot.link.since)
    if robot.link.phase is LinkPhase.LOST:
        return Part(f"LOST {seconds}", 0, Severity.ALARM)
    if robot.link.phase is LinkPhase.CONNECTING:
        return Part(f"connecting {seconds}", 0, Severity.WARNING)
    age = robot.navigation.age(now) if robot.navigation is not None else 0.0
    if staleness(age) is Staleness.FRESH:
        return Part("linked", 0, Severity.GOOD)
    return Part(f"{age_text(age)} OLD", 0, Severity.ALARM)


def _battery(robot: RobotState, now: float) -> Part:
    known = robot.navigation
    if known is None or staleness(known.age(now)) is Staleness.STALE:
        return Part("", 0)
    charge = known.value.battery_fraction
    if not math.isfinite(charge):
        return Part("", 0)
    text = f"{100.0 * charge:.0f}%"
    if charge < LOW_BATTERY:
        critical = charge < CRITICAL_BATTERY
        return Part(f"LOW {text}", 0, Severity.ALARM if critical else Severity.WARNING)
    return Part(text, 0)


def _level(robot: RobotState, now: float) -> str:
    """The depth, else the height over the ground, else the height."""
    known = robot.newest(ALTITUDE)
    if known is None or staleness(known.age(now)) is Staleness.STALE:
        return ""
    at = known.value
    levels = (("depth", at.depth), ("height", at.above_ground), ("height", at.height))
    return next((f"{name} {level:.1f} m" for name, level in levels if math.isfinite(level)), "")


def _looked(robot: RobotState, state: ConsoleState) -> str:
    if robot.name == state.peeked:
        return "PEEK"
    seconds = state.unseen_s(robot.name)
    if not seconds:
        return "seen now"
    return f"seen {duration(seconds)} ago" if math.isfinite(seconds) else "not seen yet"
