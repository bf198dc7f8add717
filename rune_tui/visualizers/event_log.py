"""visualizeEventLog: what happened, as the console told the operator."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import ClassVar, Self

from rune_tui.layout.rules import ChoiceOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.mood import Mood, ink_of
from rune_tui.visualizers.rows import Row, cut, wrapped

_NARROW = 40
_INDENT = " " * 4


@dataclass(frozen=True, slots=True)
class EventLog:
    """The newest notices that there is room for, each with its time; alarms begin with "!".

    Attributes:
        newest_at_top: Whether the newest is the first row, not the last.
        of_all: Whether notices of other robots are shown as well.
    """

    newest_at_top: bool
    of_all: bool

    rule: ClassVar = VisualizerRule(
        meaning="what happened: notices with their time, alarms marked by an exclamation mark",
        options={
            "newest": ChoiceOption(
                default="bottom", choices=("bottom", "top"), meaning="where the newest is"
            ),
            "robots": ChoiceOption(
                default="all",
                choices=("all", "its own"),
                meaning="whose notices; the console's own are always shown",
            ),
        },
    )
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls(spec.options.word("newest") == "top", spec.options.word("robots") == "all")

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the newest notices, of the newest the beginning at least."""
        canvas.fill(state.theme.panel)
        rows: list[Row] = []
        for notice in reversed(self._notices(robot, state)):
            lines = [*_rows(notice, state.title(notice.robot), canvas.width)]
            if not rows:
                lines = lines[: canvas.rows]
            rows += lines if self.newest_at_top else reversed(lines)
            if len(rows) >= canvas.rows:
                break
        rows = rows[: canvas.rows] or [Row("nothing has happened yet", Mood.FAINT)]
        if not self.newest_at_top:
            rows.reverse()
        for index, row in enumerate(rows):
            canvas.text(0, index, cut(row.text, canvas.width), ink_of(row.mood, state.theme))

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the notices."""
        notices = self._notices(robot, state)
        return notices, tuple(state.title(each.robot) for each in notices), state.theme.name

    def _notices(self, robot: RobotState, state: ConsoleState) -> tuple[Notice, ...]:
        if self.of_all:
            return state.notices
        return tuple(each for each in state.notices if each.robot in {"", robot.name})


def _rows(notice: Notice, robot: str, columns: int) -> Iterator[Row]:
    clock = notice.clock if columns >= _NARROW else notice.clock[: len("14:03")]
    whom = f"{robot}:" if robot else ""
    words = (clock, "!" if notice.alarm else "", whom, notice.text)
    row = Row(" ".join(filter(None, words)), Mood.ALARM if notice.alarm else Mood.PLAIN)
    return wrapped(row, columns, _INDENT)
