"""The present problems of a robot, and those on the banner."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Final

from hub.gcm.autonomy import Phase
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.diagnostics import Severity as Level
from hub.gcm.navigation import Assistance
from rune_tui.model.attention import Problem
from rune_tui.model.autopilot_watch import is_fault
from rune_tui.model.body import pressed_bumpers
from rune_tui.model.console_state import Banner, ConsoleState, Notice
from rune_tui.model.control import Standing, standing
from rune_tui.model.mission import mission_of
from rune_tui.model.robot_state import LackKind, LinkPhase, RobotState
from rune_tui.model.robot_task import task_of
from rune_tui.model.vehicle import autopilot_of, hears_problems, problems_of
from rune_tui.visualizers.parts.autopilot_words import ARMED, never_words, unsafe_words
from rune_tui.visualizers.parts.severity import Part, Severity
from rune_tui.visualizers.parts.staleness import Staleness, age_text, pause_of, staleness
from rune_tui.visualizers.parts.task_words import SILENT_S, task_parts
from rune_tui.visualizers.words.status_words import START_S, side_of, status_parts

REPORT_S: Final = 5.0
"""Time of a recent event on the banner [s]."""
FAULT_S: Final = 25.0
"""Time in which a fault that an autopilot reported holds: it repeats a leak every 20 s [s]."""

ITSELF: Final = " by itself"
"""Ends the banner of a robot that moves by itself."""
_SIGNED: Final = frozenset({Severity.ALARM, Severity.WARNING})
_REPORT_WEIGHT: Final = 8.5
"""Weight of a refusal: it is short, so only a lost link, an old state and a request win."""


def troubles(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    """Alarms, then cautions, the most severe first."""
    parts = [part for part in status_parts(robot, state) if part.severity in _SIGNED]
    parts += _more(robot, state)
    # Python's sort keeps the order of equals.
    return tuple(
        sorted(parts, key=lambda part: (part.severity is not Severity.ALARM, -part.weight))
    )


def troubles_of_all(state: ConsoleState) -> Mapping[str, tuple[Part, ...]]:
    """The troubles of each robot, by its name."""
    return {robot.name: troubles(robot, state) for robot in state.robots.values()}


def problems(all_troubles: Mapping[str, tuple[Part, ...]]) -> Iterator[Problem]:
    """The troubles with a cause, for the attention queue."""
    for robot, parts in all_troubles.items():
        for part in parts:
            if part.cause:
                alarm = part.severity is Severity.ALARM
                yield Problem(robot=robot, cause=part.cause, text=part.text, alarm=alarm)


def banner_of(state: ConsoleState, all_troubles: Mapping[str, tuple[Part, ...]]) -> Banner | None:
    """The most severe alarm of all robots, else a robot's own task, else None."""
    found: list[tuple[float, str, str]] = []
    for robot, parts in all_troubles.items():
        alarms = [part for part in parts if part.severity is Severity.ALARM]
        found += [(part.weight, robot, part.text) for part in alarms]
    newest = state.notices[-1] if state.notices else None
    worst = max(found, key=lambda each: each[0], default=None)
    # An event is not shown beside its result, such as a lost link.
    recent = worst is None or worst[0] < _REPORT_WEIGHT
    if recent and newest is not None and newest.alarm and _is_fresh(newest, state):
        return Banner(robot=newest.robot, text=newest.text, more=len(found))
    if worst is None:
        return next(_own_tasks(state), None)
    return Banner(robot=worst[1], text=worst[2], more=len(found) - 1)


def _is_fresh(notice: Notice, state: ConsoleState) -> bool:
    """Whether the banner still shows an alarm: a question only while it can be answered."""
    left = bool(notice.question_s) and state.looked.get(notice.robot, -math.inf) >= notice.when
    return not left and state.now - notice.when <= (notice.question_s or REPORT_S)


def _own_tasks(state: ConsoleState) -> Iterator[Banner]:
    """Tasks of robots, which matter to a driver."""
    for robot in state.robots.values():
        task = task_of(robot)
        if task is None or not task.under_way or state.now - task.measured > SILENT_S:
            continue
        for part in task_parts(robot, state):
            itself = ITSELF if task.phase is Phase.ACTIVE else ""
            text = f"{part.text}{itself}"
            yield Banner(robot=robot.name, text=text, advice=_advice(robot), calm=True)


def _advice(robot: RobotState) -> str:
    """How this console ends a task of the robot; empty: it may not drive it."""
    drives = robot.link.may_command and standing(robot) is not Standing.OTHERS
    return "a key that drives ends it" if drives else ""


def _diagnosed(robot: RobotState, now: float) -> Iterator[Part]:
    """What the robot's modules find wrong; what is old says its age."""
    for problem in problems_of(robot):
        status, age = problem.value, problem.age(now)
        old = staleness(age, pause_of(DIAGNOSTICS)) is not Staleness.FRESH
        text = f"{status.message} ({age_text(age)} ago)" if old else status.message
        error = status.level is Level.ERROR
        severity = Severity.ALARM if error else Severity.WARNING
        yield Part(text, 8 if error else 5, severity, cause=status.name)


def _of_autopilot(robot: RobotState, now: float) -> Iterator[Part]:
    """What is wrong with an autopilot besides what its driver diagnoses."""
    autopilot = autopilot_of(robot)
    if autopilot is None:
        return
    said = [each for each in robot.texts if is_fault(each.value) and each.age(now) < FAULT_S]
    for text in dict.fromkeys(each.value.text for each in said):
        yield Part(f"THE AUTOPILOT SAYS: {text}", 8, Severity.ALARM, cause=f"says {text}")
    if autopilot.phase in ARMED and not autopilot.position:
        text = "the autopilot does not know its place"
        yield Part(text, 5, Severity.WARNING, cause="no place")
    if never := never_words(autopilot):
        severity = Severity.ALARM if autopilot.phase in ARMED else Severity.WARNING
        yield Part(never, 8, severity, cause="never stops")
    if autopilot.unsafe:
        text = f"{unsafe_words(autopilot)}: see the help"
        unknown = any(math.isnan(each.value) for each in autopilot.unsafe)
        alarm = unknown and autopilot.phase in ARMED
        severity = Severity.ALARM if alarm else Severity.WARNING
        yield Part(text, 8 if alarm else 3, severity, cause="unsafe parameters")


def is_in_banner(part: Part, robot: RobotState, state: ConsoleState) -> bool:
    """Whether the banner shows this already."""
    banner = state.banner
    if banner is None or banner.robot != robot.name:
        return False
    said = banner.text.removesuffix(ITSELF).casefold()
    return said == part.text.casefold() or said.startswith(f"{part.text.casefold()} (")


def _more(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """The parts that the status line has no room for."""
    known = robot.navigation
    if known is not None and staleness(known.age(state.now)) is not Staleness.STALE:
        navigation = known.value
        pressed = pressed_bumpers(robot.body, navigation.bumpers)
        sides = dict.fromkeys(side_of(bumper.direction) for bumper in pressed)
        if sides:
            text = f"BUMPER PRESSED {' and '.join(sides)}"
            yield Part(text, 8, Severity.ALARM, cause="bumper")
        if navigation.assistance is Assistance.OFF:
            yield Part("ASSISTANCE OFF: it drives into walls", 5, Severity.WARNING)
        late = state.now - robot.link.since >= START_S
        if (
            late
            and robot.link.phase is LinkPhase.CONNECTED
            and not hears_problems(robot, state.now)
        ):
            text = "its problems are not known: no module reports them"
            yield Part(text, 5, Severity.WARNING, short="problems not known", cause="diagnostics")
    yield from _diagnosed(robot, state.now)
    yield from _of_autopilot(robot, state.now)
    mission = mission_of(robot)
    if mission is not None and mission.fault:
        yield Part(f"NOT KEPT: {mission.fault}", 8, Severity.ALARM, cause="mission")
    if waiting := state.overdue_marks(robot.name):
        marks = "1 mark" if waiting == 1 else f"{waiting} marks"
        text = f"NOT CONFIRMED BY THE ROBOT: {marks}"
        yield Part(text, 8, Severity.ALARM, cause="marks")
    starts = state.now - robot.link.since < START_S
    for name, lack in sorted(robot.link.lacking.items()):
        if lack.kind is LackKind.BROKEN or (lack.kind is LackKind.COMING and not starts):
            text = f"{name} MISSING: {lack.why}"
            yield Part(text, 4, Severity.WARNING, cause=f"missing {name}")
