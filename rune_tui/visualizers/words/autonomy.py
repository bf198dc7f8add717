"""visualizeAutonomy: the robot's own task, its distance, and its outcome."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, ClassVar

from hub.gcm.autonomy import AUTONOMY_STATE
from hub.gcm.navigation import NAVIGATION_STATUS
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Received, RobotState
from rune_tui.model.robot_task import task_of, tasks_heard
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.fitting import write_fitted
from rune_tui.visualizers.parts.severity import Part
from rune_tui.visualizers.parts.staleness import age_look, draw_age, pause_of
from rune_tui.visualizers.parts.task_words import task_rows
from rune_tui.visualizers.visualizer import PlainVisualizer
from rune_tui.visualizers.words.troubles import is_in_banner


class VisualizeAutonomy(PlainVisualizer):
    """A row each: the task, its reason, its goal and distance, its time; else the last outcome."""

    rule: ClassVar = VisualizerRule(
        meaning="what the robot does by itself, where it goes, how far it is and why; "
        "afterwards how that ended and why",
        message=AUTONOMY_STATE.name,
        others=(NAVIGATION_STATUS.name,),
    )
    urgency: ClassVar[Urgency] = Urgency.DRIVE

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the rows that fit, and their age."""
        canvas.fill(state.theme.panel)
        write_fitted(canvas, _parts(robot, state), state.theme)
        report = _task_report(robot)
        if report is not None:
            draw_age(canvas, report.age(state.now), state.theme, pause_of(AUTONOMY_STATE))

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word, and with the fading of its age."""
        report = _task_report(robot)
        look = report and age_look(report, state.now, pause_of(AUTONOMY_STATE))
        return _parts(robot, state), look, state.theme.name


def _parts(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    """All rows that the banner does not show."""
    rows = task_rows(robot, state.now)
    return tuple(part for part in rows if not is_in_banner(part, robot, state))


def _task_report(robot: RobotState) -> Received[Any] | None:
    """The report that is written; without a task the newest one, which says so."""
    task = task_of(robot)
    if task is None:
        return tasks_heard(robot)
    return Received(value=None, measured=task.measured, number=0)
