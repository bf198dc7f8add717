"""visualizeAlarms: the present problems, the worst first; a quiet line without any."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import ClassVar

from hub.gcm.autopilot import AUTOPILOT_STATE, AUTOPILOT_TEXT
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.ranges import RANGES
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.model.vehicle import hears_problems
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.fitting import write_fitted
from rune_tui.visualizers.parts.rows import fitting_form
from rune_tui.visualizers.parts.severity import Part, Severity
from rune_tui.visualizers.visualizer import PlainVisualizer
from rune_tui.visualizers.words.troubles import is_in_banner, troubles

_TASKS = "visualizeAutonomy"
"""Shows how a task waits or ended."""
_SIGNS = {Severity.ALARM: "!! ", Severity.WARNING: "! "}


class Alarms(PlainVisualizer):
    """Alarms after "!!" on the alarm's colour, then warnings after "!", in words."""

    rule: ClassVar = VisualizerRule(
        meaning="what is wrong now, except what the banner says, the worst first; all well if "
        "modules report and nothing is",
        message=ROBOT_STATE.name,
        others=(
            "GCM_CameraState",
            "GCM_Control_State",
            "GCM_AutonomyState",
            "GCM_NavigationStatus",
            RANGES.name,
            DIAGNOSTICS.name,
            AUTOPILOT_STATE.name,
            AUTOPILOT_TEXT.name,
        ),
        vital=True,
    )
    urgency: ClassVar[Urgency] = Urgency.ALARM

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the alarms that fit, and the number of the others."""
        theme = state.theme
        canvas.fill(theme.panel)
        parts = _not_in_banner(robot, state)
        if not parts:
            prefix = "" if len(state.robots) == 1 else f"{state.title(robot.name)}: "
            words = _nothing(robot, state)
            canvas.text(0, 0, fitting_form(canvas.width, f"{prefix}{words}", words), theme.faint)
            return
        write_fitted(canvas, [_signed(part) for part in parts], theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word."""
        return (
            state.title(robot.name),
            _not_in_banner(robot, state),
            _nothing(robot, state),
            state.theme.name,
        )


def _alarmed(state: ConsoleState) -> bool:
    """Whether the banner shows an alarm."""
    return state.banner is not None and not state.banner.calm


def _not_in_banner(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    return tuple(part for part in troubles(robot, state) if not _is_elsewhere(part, robot, state))


def _is_elsewhere(part: Part, robot: RobotState, state: ConsoleState) -> bool:
    """Whether the banner or another pane says it."""
    by_itself = part.cause == "task" and (_TASKS, robot.name) in state.drawn
    return by_itself or is_in_banner(part, robot, state)


def _signed(part: Part) -> Part:
    sign = _SIGNS[part.severity]
    short = f"{sign}{part.short}" if part.short else ""
    return replace(part, text=f"{sign}{part.text}", short=short)


def _nothing(robot: RobotState, state: ConsoleState) -> str:
    """The words without further problems; what is wrong with a lost robot is not known."""
    if robot.link.phase is not LinkPhase.CONNECTED:
        return "not known: no link"
    if _alarmed(state) or troubles(robot, state):
        return "nothing else"
    return "all well" if hears_problems(robot, state.now) else "not known yet"
