"""visualizeControl: the owner of control, the requests for it, and the keys to answer."""

from __future__ import annotations

from collections.abc import Hashable
from typing import ClassVar

from hub.gcm.control import CONTROL_STATE
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.control_words import control_rows
from rune_tui.visualizers.parts.fitting import write_fitted
from rune_tui.visualizers.parts.severity import Part
from rune_tui.visualizers.parts.staleness import age_look, draw_age, pause_of
from rune_tui.visualizers.visualizer import PlainVisualizer


class Control(PlainVisualizer):
    """Rows about control; a request that this console must answer has the alarm's colour."""

    rule: ClassVar = VisualizerRule(
        meaning="who has control of the robot, who asks for it and for how long, who moves it, "
        "and which keys take and hand over control",
        message=CONTROL_STATE.name,
        vital=True,
    )
    urgency: ClassVar[Urgency] = Urgency.ALARM

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the rows that fit, a request above all."""
        canvas.fill(state.theme.panel)
        write_fitted(canvas, _parts(robot, state), state.theme)
        reported = robot.newest(CONTROL_STATE)
        if reported is not None:
            draw_age(canvas, reported.age(state.now), state.theme, pause_of(CONTROL_STATE))

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word, and with the fading of its age."""
        reported = robot.newest(CONTROL_STATE)
        look = reported and age_look(reported, state.now, pause_of(CONTROL_STATE))
        return _parts(robot, state), look, state.theme.name


def _parts(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    return tuple(control_rows(robot, state))
