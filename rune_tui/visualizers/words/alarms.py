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
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.rows import TextRow, cut, wrapped
from rune_tui.visualizers.parts.severity import Part, Severity, ink_of
from rune_tui.visualizers.visualizer import PlainVisualizer
from rune_tui.visualizers.words.troubles import is_in_banner, troubles

_SIGNS = {Severity.ALARM: "!! ", Severity.WARNING: "! "}


class Alarms(PlainVisualizer):
    """Alarms after "!!" on the alarm's colour, then warnings after "!", in words."""

    rule: ClassVar = VisualizerRule(
        meaning="what is wrong now, except what the banner says, the worst first; all well if "
        "nothing is",
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
            words = "nothing else" if _alarmed(state) else f"{prefix}all well"
            canvas.text(0, 0, cut(words, canvas.width), theme.faint)
            return
        lines, hidden = _fitting([_block(part, canvas.width) for part in parts], canvas.rows)
        more = f" +{hidden}" if hidden else ""
        for row, line in enumerate(lines):
            behind = more if row == len(lines) - 1 else ""
            _write(canvas, row, line, behind, state.theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word."""
        return (
            state.title(robot.name),
            _not_in_banner(robot, state),
            _alarmed(state),
            state.theme.name,
        )


def _alarmed(state: ConsoleState) -> bool:
    """Whether the banner shows an alarm."""
    return state.banner is not None and not state.banner.calm


def _not_in_banner(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    return tuple(part for part in troubles(robot, state) if not is_in_banner(part, robot, state))


def _block(part: Part, columns: int) -> list[TextRow]:
    sign = _SIGNS[part.severity]
    return [*wrapped(TextRow(sign + part.text, part.severity), columns, " " * len(sign))]


def _fitting(blocks: list[list[TextRow]], rows: int) -> tuple[list[TextRow], int]:
    """The lines that fit, the last one cut where its block goes on; the number of hidden blocks."""
    lines: list[TextRow] = []
    for index, block in enumerate(blocks):
        room = rows - len(lines)
        if room <= 0:
            return lines, len(blocks) - index
        lines += block[:room]
        if len(block) > room and room > 0:
            rest = " ".join(line.text.strip() for line in block[room:])
            lines[-1] = replace(lines[-1], text=f"{lines[-1].text} {rest}")
    return lines, 0


def _write(canvas: Canvas, row: int, line: TextRow, behind: str, theme: Theme) -> None:
    ink = ink_of(line.severity, theme)
    if line.severity is Severity.ALARM:
        ink = theme.on_alarm
        with drawing(canvas) as pen:
            pen.rectangle(0, 2 * row, canvas.width, 2 * row + 2, theme.alarm)
    room = canvas.width - len(behind)
    canvas.text(0, row, cut(line.text, room), ink)
    canvas.text(room, row, behind, ink)
