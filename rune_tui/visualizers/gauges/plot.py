"""visualizePlot: a number of any message over time."""

from __future__ import annotations

import copy
import math
from collections.abc import Hashable, Sequence
from typing import ClassVar, Self

from hub.gcm.catalog import BY_NAME
from hub.gcm.navigation import ROBOT_STATE
from rune_tui.layout.rules import NumberOption, TextOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.history import History, Slot, number_at
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.parts.plot_lines import draw_line, limits_of, write_limits
from rune_tui.visualizers.parts.rows import fitting_form
from rune_tui.visualizers.parts.staleness import DIM_AFTER_S, age_look, draw_age, pause_of

_LATE = 2.5
"""Periods without a message that make a gap."""


class Plot:
    """A line over time, with the present at the right and gaps where no value came.

    It starts at the first drawing, and keeps a history for each robot.
    """

    rule: ClassVar = VisualizerRule(
        meaning="a number of any message over time; GCM_RobotState if none is named",
        message=ROBOT_STATE.name,
        any_message=True,
        options={
            "field": TextOption(
                default="linear",
                longest=100,
                names="field",
                meaning="number of the message, such as linear, scans[0].ranges[3] or points[1].x",
            ),
            "seconds": NumberOption(
                default=30.0, least=1.0, most=86_400.0, unit="s", meaning="time from left to right"
            ),
            "least": NumberOption(
                default=0.0, least=-1e9, most=1e9, meaning="value at the lower edge"
            ),
            "most": NumberOption(
                default=0.0,
                least=-1e9,
                most=1e9,
                meaning="value at the upper edge; both are found by themselves where it is least",
            ),
        },
    )
    whole_cells: ClassVar[bool] = True

    def __init__(self, spec: VisualizerSpec) -> None:
        """Begin with nothing.

        Args:
            spec: The layout's values.
        """
        self._definition = BY_NAME[spec.message]
        self._field = spec.options.word("field")
        self._seconds = self.memory_s = spec.options.number("seconds")
        self._range = (spec.options.number("least"), spec.options.number("most"))
        self._pause = pause_of(self._definition)
        rate = self._definition.rate_hz
        self._gap = max(DIM_AFTER_S, _LATE / rate if rate else 0.0)
        self._histories: dict[str, History] = {}
        self._seen: dict[str, int] = {}
        self._width = 1

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls(spec)

    def __copy__(self) -> Self:
        """A visualizer with the same histories, which grow by themselves."""
        twin = object.__new__(type(self))
        histories = {name: copy.copy(each) for name, each in self._histories.items()}
        vars(twin).update(vars(self), _histories=histories, _seen=dict(self._seen))
        return twin

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with each value, and with each pixel that the line moves."""
        history = self._note(robot)
        received = robot.newest(self._definition)
        if received is None:
            return robot.name, state.theme.name
        look = age_look(received, state.now, self._pause) if self._definition.rate_hz else None
        return robot.name, history.count, self._pixel(state.now), look, state.theme.name

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the history, and write the newest value."""
        canvas.fill(state.theme.panel)
        self._width = max(1, canvas.width)
        history = self._note(robot)
        received = robot.newest(self._definition)
        if received is None:
            write_notice(canvas, f"no {self._definition.name} from {robot.title}", state.theme)
            return
        newest = number_at(received.value, self._field)
        if newest is None:
            text = f"{self._definition.name} has no number {self._field}"
            write_notice(canvas, text, state.theme)
            return
        end = (self._pixel(state.now) + 1) * self._seconds / self._width
        slots = [*history.since(end - self._seconds)]
        low, high = self._limits(slots)
        draw_line(canvas, slots, (low, high), (end - self._seconds, end), state.theme)
        self._write(canvas, newest, (low, high), state.theme)
        if self._definition.rate_hz:
            draw_age(canvas, received.age(state.now), state.theme, self._pause)

    def _note(self, robot: RobotState) -> History:
        """Add the newest message to the history."""
        history = self._histories.setdefault(robot.name, History(self._seconds, self._gap))
        received = robot.newest(self._definition)
        if received is not None and self._seen.get(robot.name) != received.number:
            self._seen[robot.name] = received.number
            value = number_at(received.value, self._field)
            history.add(received.measured, math.nan if value is None else value)
        return history

    def _pixel(self, now: float) -> int:
        """Number of pixels that the line has moved since the start of the clock."""
        return int(now * self._width / self._seconds)

    def _limits(self, slots: Sequence[Slot]) -> tuple[float, float]:
        """Values at the lower and the upper edge."""
        least, most = self._range
        if least != most:
            return min(least, most), max(least, most)
        return limits_of(slots)

    def _write(
        self, canvas: Canvas, newest: float, limits: tuple[float, float], theme: Theme
    ) -> None:
        low, high = (f"{limit:.3g}" for limit in limits)
        value = f"{newest:.4g}"
        head = fitting_form(
            canvas.width,
            f"{self._definition.name} {self._field} {value}, {low} to {high} in "
            f"{self._seconds:g} s",
            f"{self._field} {value}, {self._seconds:g} s",
            f"{self._field} {value}",
            value,
        )
        canvas.text(0, 0, head, theme.ink)
        write_limits(canvas, limits, theme)
