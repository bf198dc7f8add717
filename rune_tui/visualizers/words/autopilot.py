"""visualizeAutopilot: whether a vehicle is armed, why it does not move, and what it says."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import ClassVar, Final

from hub.gcm.autopilot import AUTOPILOT_STATE, AUTOPILOT_TEXT
from hub.gcm.diagnostics import Severity as Level
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.vehicle import VEHICLE_STATE
from rune_tui.layout.rules import Purpose, VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.model.vehicle import autopilot_of
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.autopilot_words import autopilot_parts, head_of, shorter_heads
from rune_tui.visualizers.parts.fitting import write_fitted
from rune_tui.visualizers.parts.rows import fitting_form
from rune_tui.visualizers.parts.severity import Part, Severity, ink_of
from rune_tui.visualizers.parts.staleness import age_look, draw_age, pause_of
from rune_tui.visualizers.visualizer import PlainVisualizer

_PAUSE_S = pause_of(AUTOPILOT_STATE)
_MOST_TEXTS: Final = 5
_LEVELS: Final = {
    Level.OK: Severity.FAINT,
    Level.WARN: Severity.WARNING,
    Level.ERROR: Severity.ALARM,
}


class VisualizeAutopilot(PlainVisualizer):
    """A coloured row says whether it is armed; then a row each, and its last texts."""

    rule: ClassVar = VisualizerRule(
        meaning="a vehicle with an autopilot: whether it is armed, its mode, why it does not move, "
        "when it stops, its link, place and battery, unsafe parameters, and what it said last",
        message=AUTOPILOT_STATE.name,
        others=(AUTOPILOT_TEXT.name, VEHICLE_STATE.name, ROBOT_STATE.name),
    )
    urgency: ClassVar[Urgency] = Urgency.DRIVE

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the rows that fit, the most important ones where room is short."""
        canvas.fill(state.theme.panel)
        head, *parts = _parts(robot, state)
        short = [_in_one_row(part, canvas.width) for part in parts]
        write_fitted(canvas, short, state.theme, top=1)
        autopilot = autopilot_of(robot)
        forms = shorter_heads(head, autopilot) if autopilot is not None else (head.text, head.short)
        _write_head(canvas, head, forms, state.theme)
        known = robot.newest(AUTOPILOT_STATE)
        if known is not None:
            draw_age(canvas, known.age(state.now), state.theme, _PAUSE_S)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word, and with the fading of its age."""
        known = robot.newest(AUTOPILOT_STATE)
        look = known and age_look(known, state.now, _PAUSE_S)
        return _parts(robot, state), look, state.theme.name


def _parts(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    autopilot = autopilot_of(robot)
    if autopilot is None:
        return (Part("no state of the autopilot", 10, Severity.FAINT, "no state"),)
    texts = [each.value for each in robot.texts[-_MOST_TEXTS:]]
    # The newest texts are the last ones to be left out.
    said = [Part(each.text, place / 10.0, _LEVELS[each.level]) for place, each in enumerate(texts)]
    follow = state.input_of(Purpose.FOLLOW, robot.name)
    return (head_of(robot, autopilot), *autopilot_parts(robot, autopilot, follow), *said)


def _in_one_row(part: Part, columns: int) -> Part:
    """The part in its short form, if it has one and the long form needs several rows."""
    return replace(part, text=part.short) if part.short and len(part.text) > columns else part


def _write_head(canvas: Canvas, head: Part, forms: tuple[str, ...], theme: Theme) -> None:
    """The first row, in the first form that fits, on a ground where it is a caution or an alarm."""
    grounds = {Severity.WARNING: theme.warning, Severity.ALARM: theme.alarm}
    inks = {Severity.WARNING: theme.panel, Severity.ALARM: theme.on_alarm}
    if head.severity in grounds:
        with drawing(canvas) as pen:
            pen.rectangle(0, 0, canvas.width, 2, grounds[head.severity])
    ink = inks.get(head.severity) or ink_of(head.severity, theme)
    canvas.text(0, 0, fitting_form(canvas.width, *forms), ink)
