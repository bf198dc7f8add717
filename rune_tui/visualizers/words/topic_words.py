"""visualizeTopics and visualizeFields: the topics of a recording as a tree, and one as a table."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Sequence
from typing import ClassVar, Final

from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.topics import TopicEntry, Topics, topics_of
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.parts.rows import TextRow, cut, fitting_form
from rune_tui.visualizers.parts.severity import Severity, ink_of
from rune_tui.visualizers.visualizer import PlainVisualizer

NO_TOPICS: Final = "topics are in recordings only: `rune replay FILE` shows them"
_RATE: Final = 8
_COUNT: Final = 8
_LEAST_NAME: Final = 14
_SHARE: Final = 0.45
"""Most of the width that the names of fields take."""


class TopicTree(PlainVisualizer):
    """A row for each topic and each part of their names that several share."""

    rule: ClassVar = VisualizerRule(
        meaning="the topics of a recording as a tree, with their types, rates and numbers of "
        "messages; the chosen one is marked"
    )

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the rows around the chosen topic."""
        canvas.fill(state.theme.panel)
        received = topics_of(robot)
        if received is None:
            write_notice(canvas, NO_TOPICS, state.theme)
            return
        topics = received.value
        rows = [*_tree(topics.entries, canvas.width)]
        names = [name for name, _ in rows]
        chosen = names.index(topics.chosen) if topics.chosen in names else -1
        _write_around(canvas, [row for _, row in rows], chosen, state)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the topics and the chosen one."""
        received = topics_of(robot)
        if received is None:
            return state.theme.name
        return received.value.entries, received.value.chosen, state.theme.name


class TopicFields(PlainVisualizer):
    """A row for each field of the chosen topic's newest message."""

    rule: ClassVar = VisualizerRule(
        meaning="the fields of the chosen topic of a recording, with the values of its newest "
        "message; the chosen field is marked"
    )

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the topic, and the rows around the chosen field."""
        canvas.fill(state.theme.panel)
        received = topics_of(robot)
        if received is None:
            write_notice(canvas, NO_TOPICS, state.theme)
            return
        topics = received.value
        entry = _entry(topics)
        if entry is None:
            write_notice(canvas, "the recording has no topics", state.theme)
            return
        canvas.text(0, 0, fitting_form(canvas.width, *_titles(topics)), state.theme.soft)
        if entry.trouble:
            write_notice(canvas, entry.trouble, state.theme)
            return
        fields = topics.read_fields()
        if not fields:
            notice = f"no message of {entry.name} until now"
            if topics.newest:
                notice = f"the newest message of {entry.name} does not fit its type"
            write_notice(canvas, notice, state.theme)
            return
        widest = max(len(each.path) for each in fields)
        column = min(widest, max(_LEAST_NAME, int(canvas.width * _SHARE)))
        rows = [TextRow(f"{_ending(each.path, column):<{column}}  {each.text}") for each in fields]
        paths = [each.path for each in fields]
        chosen = paths.index(topics.field) if topics.field in paths else -1
        _write_around(canvas, rows, chosen, state, first=1)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the message and the chosen field."""
        received = topics_of(robot)
        if received is None:
            return state.theme.name
        topics = received.value
        return topics.chosen, topics.field, topics.newest, _titles(topics), state.theme.name


def _entry(topics: Topics) -> TopicEntry | None:
    return next((each for each in topics.entries if each.name == topics.chosen), None)


def _titles(topics: Topics) -> tuple[str, ...]:
    """The chosen topic, its type, and the age of its newest message, the longest form first."""
    entry = _entry(topics)
    if entry is None:
        return ("",)
    age = f"  {topics.age_s:.1f} s ago" if topics.age_s >= 1.0 else ""
    leaf = entry.name.rpartition("/")[2]
    kind = entry.kind.rpartition("/")[2]
    return f"{entry.name}  {kind}{age}", f"{entry.name}{age}", f"{leaf}{age}", leaf


def _ending(text: str, columns: int) -> str:
    """The end of a path, which tells it from others."""
    return text if len(text) <= columns else f"…{text[len(text) - columns + 1 :]}"


def _write_around(
    canvas: Canvas, rows: Sequence[TextRow], chosen: int, state: ConsoleState, *, first: int = 0
) -> None:
    """Write the rows that fit, with the chosen one among them and marked."""
    room = canvas.rows - first
    if room <= 0:
        return
    begin = max(0, min(chosen - room // 2, len(rows) - room))
    for index, row in enumerate(rows[begin : begin + room]):
        at, marked = first + index, begin + index == chosen
        if marked:
            with drawing(canvas) as pen:
                pen.rectangle(0, 2 * at, canvas.width, 2 * at + 2, state.theme.track)
        text = cut(row.text, canvas.width) if row.severity is Severity.FAINT else row.text
        canvas.text(0, at, text[: canvas.width], ink_of(row.severity, state.theme))
    left = len(rows) - begin - room
    if left > 0 and room > 1:
        more = f" {left} more below "
        canvas.text(max(0, canvas.width - len(more)), canvas.rows - 1, more, state.theme.soft)


def _tree(entries: Sequence[TopicEntry], columns: int) -> Iterator[tuple[str, TextRow]]:
    """Name and row of each topic, and rows without a name for the parts that several share."""
    known: tuple[str, ...] = ()
    for entry in entries:
        *folders, leaf = entry.name.strip("/").split("/")
        shared = 0
        while shared < min(len(folders), len(known)) and folders[shared] == known[shared]:
            shared += 1
        for depth in range(shared, len(folders)):
            yield "", TextRow(f"{'  ' * depth}{folders[depth]}/", Severity.FAINT)
        known = tuple(folders)
        yield entry.name, _leaf(f"{'  ' * len(folders)}{leaf}", entry, columns)


def _leaf(name: str, entry: TopicEntry, columns: int) -> TextRow:
    """The row of a topic: its type is left out first, then the number of its messages."""
    rate = "" if math.isnan(entry.rate_hz) else f"{_short(entry.rate_hz)}/s"
    count = "" if entry.count < 0 else str(entry.count)
    kind = entry.kind.rpartition("/")[2]
    numbers = f"{rate:>{_RATE}}{count:>{_COUNT}}"
    if columns < _LEAST_NAME + _RATE + _COUNT:
        numbers = f"{rate:>{_RATE}}"
    room = max(1, columns - len(numbers))
    if entry.trouble:
        kind = f"{kind} not read"
    beside = room - len(name) - 2
    text = f"{name}  {kind[:beside]}" if beside >= len(kind) or beside > _RATE else name
    severity = Severity.WARNING if entry.trouble else Severity.PLAIN
    return TextRow(f"{text[:room]:<{room}}{numbers}", severity)


def _short(rate: float) -> str:
    return f"{rate:.0f}" if rate >= 100.0 else f"{rate:.1f}" if rate >= 1.0 else f"{rate:.2f}"
