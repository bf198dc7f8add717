"""visualizeMission: the mission, its stored parts, and its unstored parts."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from typing import ClassVar

from hub.gcm.mission import MISSION_STATE, MissionState
from rune_tui.layout.rules import Purpose, VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.mission import OLD_S, mission_of
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.fitting import write_fitted
from rune_tui.visualizers.parts.severity import Part, Severity
from rune_tui.visualizers.parts.staleness import age_look, draw_age, pause_of
from rune_tui.visualizers.visualizer import PlainVisualizer


class VisualizeMission(PlainVisualizer):
    """A row each: the name and the time, stored marks, the stored map, unstored parts."""

    rule: ClassVar = VisualizerRule(
        meaning="the mission: its name, for how long it runs, how many marks are kept, how old the "
        "saved map is, and what is not kept",
        message=MISSION_STATE.name,
    )
    urgency: ClassVar[Urgency] = Urgency.ALARM

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the rows that fit: what is not kept above all, then the number of kept marks."""
        canvas.fill(state.theme.panel)
        write_fitted(canvas, _parts(robot, state), state.theme)
        reported = robot.newest(MISSION_STATE)
        if reported is not None:
            draw_age(canvas, reported.age(state.now), state.theme, pause_of(MISSION_STATE))

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word, and with the fading of its age."""
        reported = robot.newest(MISSION_STATE)
        look = reported and age_look(reported, state.now, pause_of(MISSION_STATE))
        return _parts(robot, state), look, state.theme.name


def _parts(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    key = state.input_of(Purpose.MISSION, robot.name)
    return tuple(mission_rows(mission_of(robot), state.overdue_marks(robot.name), key))


def mission_rows(mission: MissionState | None, unconfirmed: int, key: str = "") -> Iterator[Part]:
    """The rows about a mission, the most important first."""
    if unconfirmed:
        marks = "1 mark" if unconfirmed == 1 else f"{unconfirmed} marks"
        text = f"{marks} NOT CONFIRMED by the robot"
        yield Part(text, 9, Severity.ALARM, short=f"{unconfirmed} NOT CONFIRMED")
    if mission is not None and mission.fault:
        yield Part(f"NOT KEPT: {mission.fault}", 9, Severity.ALARM, short="NOT KEPT")
    if mission is None:
        yield Part("no mission is reported", 0, Severity.FAINT, short="no mission")
    elif not mission.running:
        ended = f"mission {mission.name} is ended" if mission.begun else "no mission runs"
        yield Part(ended, 5, short="ended" if mission.begun else "no mission")
        first = f"{key}, " if key else ""
        short = f"{key} begins one" if key else "a mark begins one"
        text = f"{first}a mark, or who takes control, begins one"
        yield Part(text, 0, Severity.FAINT, short=short)
    else:
        yield _kept(mission)
        yield Part(f"{mission.name}, {_time(mission.running_s)}", 5, short=mission.name)
        yield _saved(mission)


def _kept(mission: MissionState) -> Part:
    count = mission.marks + mission.earlier
    words = f"{count} mark{'' if count == 1 else 's'}"
    short = f"{words}, {mission.unkept} in memory" if mission.unkept else f"{words} kept"
    words += f", {mission.unkept} changes in memory only" if mission.unkept else " kept"
    if mission.sheet > 1:
        words += f"; sheet {mission.sheet}, {mission.earlier} of them on those before"
    severity = Severity.WARNING if mission.unkept else Severity.GOOD
    return Part(words, 8, severity, short=short)


def _saved(mission: MissionState) -> Part:
    if math.isnan(mission.map_age_s):
        return Part("map not saved yet", 3, Severity.FAINT, short="map not saved")
    old = mission.map_age_s > OLD_S
    # A standing robot maps nothing new, and has nothing to save.
    age = _time(mission.map_age_s)
    severity = Severity.FAINT if old else Severity.GOOD
    return Part(f"map saved {age} ago", 3, severity, short=f"map {age} ago")


def _time(seconds: float) -> str:
    """A time in words: "8 s", "12 min", "3:05 h"."""
    whole = int(seconds)
    if whole < 90:
        return f"{whole} s"
    if whole < 5400:
        return f"{whole // 60} min"
    return f"{whole // 3600}:{whole // 60 % 60:02} h"
