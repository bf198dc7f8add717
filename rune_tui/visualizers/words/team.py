"""visualizeTeam: a row for each robot of the layout, in words."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import ClassVar, Final

from hub.gcm.autonomy import AUTONOMY_STATE
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.control import CONTROL_STATE
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.flight import ALTITUDE
from hub.gcm.navigation import NAVIGATION_STATUS, ROBOT_STATE
from hub.gcm.vehicle import VEHICLE_STATE
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas, printable_text
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.rows import GAP, TextRow, cut, flowing, kept_columns
from rune_tui.visualizers.parts.severity import Severity, ink_of
from rune_tui.visualizers.visualizer import PlainVisualizer
from rune_tui.visualizers.words.team_words import WELL, TeamRow, team_row

_WEIGHTS: Final = (10, 12, 1, 6, 9, 5, 7, 4, 3, 11)
"""Importance of the cells of a row: with little room, the least important are left out."""
_KEY, _NAME, _DOES, _WORST = 0, 1, 4, 9


class Team(PlainVisualizer):
    """Key, name, kind, control, what it does, link, battery, height, last look, worst problem.

    The chosen robot has the mark "▶", one that the operator peeks at "»". With fewer rows than
    robots, the chosen robot and those with the worst problems are shown, and the others counted.
    """

    rule: ClassVar = VisualizerRule(
        meaning="the team: a row for each robot with its key, control, what it does, link, "
        "battery, height or depth, time since you looked at it, and its worst problem",
        message=ROBOT_STATE.name,
        others=(
            ROBOT_DESCRIPTION.name,
            CONTROL_STATE.name,
            AUTONOMY_STATE.name,
            NAVIGATION_STATUS.name,
            ALTITUDE.name,
            VEHICLE_STATE.name,
            DIAGNOSTICS.name,
        ),
        vital=True,
        of_all=True,
    )
    urgency: ClassVar[Urgency] = Urgency.ALARM

    def draw(self, canvas: Canvas, _robot: RobotState, state: ConsoleState) -> None:
        """Write the rows; in one row, the names of all."""
        rows = _rows(state)
        canvas.fill(state.theme.bar)
        if canvas.rows == 1 and len(rows) > 1:
            _write_names(canvas, rows, state.theme)
            return
        shown = _shown(rows, canvas.rows)
        widths = kept_columns([row.cells for row in shown], _WEIGHTS, canvas.width)
        for number, row in enumerate(shown):
            _write_row(canvas, number, row, widths, state.theme)
        if len(shown) < len(rows):
            _write_rest(canvas, [row for row in rows if row not in shown], state.theme)

    def source(self, _robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word."""
        return _rows(state), state.theme.name


def _rows(state: ConsoleState) -> tuple[TeamRow, ...]:
    return tuple(team_row(robot, state) for robot in state.robots.values())


def _by_weight(row: TeamRow) -> tuple[bool, bool, tuple[int, float]]:
    """Key of an order: the chosen robot last, before it the one with the worst problem."""
    return row.chosen, row.peeked, row.rank


def _shown(rows: Sequence[TeamRow], room: int) -> list[TeamRow]:
    """The rows that have room beside the row of the rest, in the order of the layout."""
    if len(rows) <= room:
        return list(rows)
    kept = sorted(rows, key=_by_weight, reverse=True)[: room - 1]
    return [row for row in rows if row in kept]


def _write_row(
    canvas: Canvas, number: int, row: TeamRow, widths: dict[int, int], theme: Theme
) -> None:
    if row.chosen:
        with drawing(canvas) as pen:
            pen.rectangle(0, 2 * number, canvas.width, 2 * number + 2, theme.panel)
    column = 0
    for index, width in widths.items():
        severity = row.severities[index]
        plain = severity is Severity.PLAIN and not row.chosen
        ink = theme.soft if plain else ink_of(severity, theme)
        canvas.text(column, number, cut(row.cells[index], canvas.width - column), ink)
        column += width + GAP


def _write_rest(canvas: Canvas, rest: Sequence[TeamRow], theme: Theme) -> None:
    ill = sum(row.rank[0] > 0 for row in rest)
    well = "all well" if all(row.rank == WELL for row in rest) else "not known yet"
    more = f"{ill} of them with problems" if ill else well
    severity = Severity.WARNING if ill else Severity.FAINT
    words = cut(f"{len(rest)} more: {more}", canvas.width)
    canvas.text(0, canvas.rows - 1, words, ink_of(severity, theme))


def _write_names(canvas: Canvas, rows: Sequence[TeamRow], theme: Theme) -> None:
    """All robots side by side; those without room are shortened, then left out and counted."""
    words = {row.name: _short(row) for row in rows}
    for row in sorted(rows, key=lambda row: row.rank):
        if not _fits(words, canvas):
            words[row.name] = _short(row, bare=True)
    for row in sorted(rows, key=_by_weight)[:-1]:
        if not _fits(words, canvas):
            del words[row.name]
    column = 0
    for word in words.values():
        text = cut(word.text, canvas.width - column)
        canvas.text(column, 0, text, ink_of(word.severity, theme))
        column += len(text) + GAP
    if (left_out := len(rows) - len(words)) and column < canvas.width:
        text = f"+{left_out}"[: canvas.width - column]
        canvas.text(column, 0, text, ink_of(Severity.WARNING, theme))


def _fits(words: Mapping[str, TextRow], canvas: Canvas) -> bool:
    return len(list(flowing(words.values(), canvas.width))) <= 1


def _short(row: TeamRow, *, bare: bool = False) -> TextRow:
    """Key, name and worst problem in one word, or what it does; bare: the problem's sign only."""
    name = f"{row.cells[_KEY]}{row.cells[_NAME]}" if row.cells[_KEY] else row.cells[_NAME]
    said = row.cells[_WORST if row.rank[0] else _DOES].strip()
    if bare:
        said = said.split(" ")[0] if row.rank[0] else ""
    severity = row.severities[_WORST] if row.rank[0] else Severity.PLAIN
    return TextRow(printable_text(f"{name} {said}".rstrip()), severity)
