"""visualizeEventLog: the console's reports to the operator."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import ClassVar, Self

from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.notices import KEPT_S, by_importance, merged, shortened
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.fitting import clauses
from rune_tui.visualizers.parts.rows import TextRow, cut, fitting_form, wrapped
from rune_tui.visualizers.parts.severity import Severity, ink_of

_NARROW = 40
_INDENT = " " * 4
_SMALL_WORDS = frozenset({"a", "an", "the", "is", "are", "was", "it"})


@dataclass(frozen=True, slots=True)
class EventLog:
    """The newest notices that fit, each with its time; alarms begin with "!".

    Attributes:
        newest_at_top: Whether the newest is the first row, not the last.
        of_all: Whether it shows notices of other robots too.
    """

    newest_at_top: bool
    of_all: bool

    rule: ClassVar = VisualizerRule(
        logs=True,
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
        """Write the notices that fit, those that need the operator first."""
        canvas.fill(state.theme.panel)
        rows = self._chosen(merged(self._notices(robot, state)), canvas.width, canvas.rows, state)
        nothing = fitting_form(canvas.width, "no events yet", "no events")
        for index, row in enumerate(rows or [TextRow(nothing, Severity.FAINT)]):
            canvas.text(0, index, cut(row.text, canvas.width), ink_of(row.severity, state.theme))

    def _chosen(
        self, notices: Sequence[Notice], columns: int, room: int, state: ConsoleState
    ) -> list[TextRow]:
        """The rows of the most important notices, in the order of time.

        Each has one row with the longest form that fits. Where rows are left, it has two.
        """
        places = {id(notice): number for number, notice in enumerate(notices)}
        chosen: dict[int, list[TextRow]] = {}
        ordered = by_importance(notices, state.now)[: max(0, room)]
        left = room - len(ordered)
        for notice in ordered:
            forms = _forms(notice, _robot_name(notice, state), columns)
            rows = _longest(forms, _severity(notice), columns, 2 if left > 0 else 1)
            left -= len(rows) - 1
            chosen[places[id(notice)]] = rows
        order = sorted(chosen, reverse=self.newest_at_top)
        return [row for number in order for row in chosen[number]]

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the notices."""
        notices = self._notices(robot, state)
        titles = tuple(_robot_name(each, state) for each in notices)
        fresh = sum(state.now - each.when < KEPT_S for each in notices)
        return notices, titles, fresh, state.theme.name

    def _notices(self, robot: RobotState, state: ConsoleState) -> tuple[Notice, ...]:
        if self.of_all:
            return state.notices
        return tuple(each for each in state.notices if each.robot in {"", robot.name})


def _robot_name(notice: Notice, state: ConsoleState) -> str:
    """The robot's name, if there are several robots."""
    return "" if len(state.robots) == 1 else state.title(notice.robot)


def _longest(forms: Sequence[str], severity: Severity, columns: int, room: int) -> list[TextRow]:
    """The rows of the longest form that fits, else the last form, cut."""
    for form in forms:
        rows = [*wrapped(TextRow(form, severity), columns, _INDENT)]
        if len(rows) <= room:
            return rows
    return [TextRow(cut(forms[-1], columns), severity)]


def _severity(notice: Notice) -> Severity:
    if notice.past:
        return Severity.FAINT
    return Severity.ALARM if notice.alarm else Severity.PLAIN


def _forms(notice: Notice, robot: str, columns: int) -> tuple[str, ...]:
    """A notice with its time in ever fewer words; the page of messages has the whole text."""
    clock = notice.clock if columns >= _NARROW else _minutes(notice.clock)
    before = (clock, "!" if notice.alarm else "", f"{robot}:" if robot else "")
    texts = (text for each in clauses(shortened(notice.text)) for text in (each, _brief(each)))
    return tuple(" ".join(filter(None, (*before, text))) for text in texts)


def _minutes(clock: str) -> str:
    """A time of day without seconds."""
    return clock.rpartition(":")[0] or clock


def _brief(sentence: str) -> str:
    """A sentence without the words that say little."""
    words = [word for word in sentence.split() if word not in _SMALL_WORDS]
    return " ".join(words) or sentence
