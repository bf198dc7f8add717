"""visualizeAttention: the alarms of all robots, in the order in which they need the operator."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from typing import ClassVar, Final

from rune_tui.layout.rules import Purpose, VisualizerRule
from rune_tui.model.attention import AttentionEntry, next_robot
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import hears_problems
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.rows import (
    LEAST_TEXT,
    TextRow,
    cut,
    cut_anywhere,
    kept_columns,
    tabled,
)
from rune_tui.visualizers.parts.severity import Severity, ink_of
from rune_tui.visualizers.parts.task_words import duration
from rune_tui.visualizers.visualizer import PlainVisualizer
from rune_tui.visualizers.words.alarms import Alarms

_WEIGHTS: Final = (9, 10, 3, 11)
"""Importance of mark, robot, age and words."""
_ROBOT: Final = 1
"""The column of the robot."""
_WORDS: Final = 3
"""The column of the words."""
_LEAST_WORDS: Final = len("BATTERY CRITICAL…")
"""Columns in which the words of an alarm still say what it is."""


class Attention(PlainVisualizer):
    """A row for each alarm: mark, sign, robot, age, words; alarms first, then the oldest.

    "»" marks an entry whose robot the operator did not look at since it was raised, "»»" one that
    was raised again. The key of the next alarm is before the mark of the entry where it leads.
    """

    rule: ClassVar = VisualizerRule(
        meaning="the alarms and warnings of all robots in one queue: alarms first, then the "
        "oldest; » marks those that you did not look at",
        message=Alarms.rule.message,
        others=Alarms.rule.others,
        vital=True,
        of_all=True,
    )
    urgency: ClassVar[Urgency] = Urgency.ALARM

    def draw(self, canvas: Canvas, _robot: RobotState, state: ConsoleState) -> None:
        """Write the entries that fit, and the number of the others."""
        theme = state.theme
        canvas.fill(theme.panel)
        columns = canvas.width
        rows = _rows(state, columns)
        more = f" +{len(rows) - canvas.rows}"
        if len(rows) > canvas.rows:
            rows = _rows(state, columns - len(more))
        for number, (row, waits) in enumerate(rows[: canvas.rows]):
            ink = ink_of(row.severity, theme)
            if waits and row.severity is Severity.ALARM:
                ink = theme.on_alarm
                with drawing(canvas) as pen:
                    pen.rectangle(0, 2 * number, canvas.width, 2 * number + 2, theme.alarm)
            canvas.text(0, number, row.text, ink)
        if len(rows) > canvas.rows:
            canvas.text(columns - len(more), canvas.rows - 1, more, theme.ink)
        if not rows:
            canvas.text(0, 0, cut(_no_rows(state), canvas.width), theme.faint)

    def source(self, _robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word."""
        return tuple(_rows(state, 1000)), _no_rows(state), state.theme.name


def _no_rows(state: ConsoleState) -> str:
    """The words where nothing waits; of a single robot, its own pane says whether it is well."""
    robots = state.robots.values()
    well = len(robots) > 1 and all(hears_problems(each, state.now) for each in robots)
    return "no alarms: all well" if well else "no alarms"


def _rows(state: ConsoleState, columns: int) -> list[tuple[TextRow, bool]]:
    """Each entry in words, and whether it waits for the operator."""
    cells = list(_cells(state))
    if not cells:
        return []
    # Mark and age make room for the words that decide; the robot does not.
    named = _ROBOT in kept_columns(cells, _WEIGHTS, columns, _LEAST_WORDS)
    least = _LEAST_WORDS if named else LEAST_TEXT
    lines = tabled(cells, _WEIGHTS, columns, least)
    if [*kept_columns(cells, _WEIGHTS, columns, least)] == [_WORDS]:
        # A part of the word that decides says more than none: "BATTERY CRIT…".
        lines = tuple(cut_anywhere(each[_WORDS], columns) for each in cells)
    return [
        (TextRow(line, _severity(entry)), not (entry.answered or entry.over))
        for entry, line in zip(state.attention, lines, strict=True)
    ]


def _cells(state: ConsoleState) -> Iterator[tuple[str, ...]]:
    key = state.inputs.get((Purpose.NEXT_ALARM, ""), "")
    target = next_robot(state.attention, state.chosen)
    for entry in state.attention:
        leads = entry.robot == target and not entry.over
        target = "" if leads else target
        waits = not (entry.answered or entry.over)
        mark = ("»»" if entry.times > 1 else "»") if waits else ""
        sign = "" if entry.over else "!!" if entry.alarm else "!"
        yield (
            f"{key if leads else ' ' * len(key)}{mark:<2} {sign}".rstrip(),
            state.title(entry.robot),
            duration(state.now - entry.since),
            f"over: {entry.text}" if entry.over else entry.text,
        )


def _severity(entry: AttentionEntry) -> Severity:
    if entry.over:
        return Severity.FAINT
    return Severity.ALARM if entry.alarm else Severity.WARNING
