"""visualizeTopicPlot: the chosen number of a recording over time."""

from __future__ import annotations

from collections.abc import Hashable
from typing import ClassVar

from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.topics import Topics, topics_of
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.history import History, Slot
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.parts.plot_lines import draw_line, limits_of, write_limits
from rune_tui.visualizers.parts.rows import fitting_form
from rune_tui.visualizers.visualizer import PlainVisualizer
from rune_tui.visualizers.words.topic_words import NO_TOPICS

_GAP_SHARE = 0.1
"""Part of the shown time without a value that makes a gap."""


class TopicPlot(PlainVisualizer):
    """A line with the present at the right; it has the values before the first drawing too."""

    rule: ClassVar = VisualizerRule(
        meaning="the chosen field of the chosen topic of a recording over time"
    )

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the line, and write the newest value."""
        canvas.fill(state.theme.panel)
        received = topics_of(robot)
        if received is None:
            write_notice(canvas, NO_TOPICS, state.theme)
            return
        topics = received.value
        slots = _slots(topics)
        if not topics.field or not slots:
            what = f"{topics.field} of " * bool(topics.field)
            text = f"no numbers of {what}{topics.chosen or 'a topic'} in {topics.seconds:g} s"
            write_notice(canvas, text, state.theme)
            return
        limits = limits_of(slots)
        span = (received.measured - topics.seconds, received.measured)
        draw_line(canvas, slots, limits, span, state.theme)
        low, high = (f"{limit:.3g}" for limit in limits)
        value = f"{slots[-1].last:.4g}"
        head = fitting_form(
            canvas.width,
            f"{topics.chosen} {topics.field} {value}, {low} to {high} in {topics.seconds:g} s",
            f"{topics.field} {value}, {topics.seconds:g} s",
            f"{topics.field} {value}",
            value,
        )
        canvas.text(0, 0, head, state.theme.ink)
        write_limits(canvas, limits, state.theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with each frame of the recording."""
        received = topics_of(robot)
        if received is None:
            return state.theme.name
        topics = received.value
        return received.number, topics.chosen, topics.field, state.theme.name


def _slots(topics: Topics) -> list[Slot]:
    history = History(topics.seconds, topics.seconds * _GAP_SHARE)
    series = topics.read_series()
    for when, value in zip(series.times.tolist(), series.values.tolist(), strict=True):
        history.add(when, value)
    return [*history.since(-float("inf"))]
