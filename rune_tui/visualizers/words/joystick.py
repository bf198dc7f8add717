"""visualizeJoystick: the device of a joystick, and the position of each control."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from typing import ClassVar, Self

from hub.values import dataclass
from rune_tui.layout.rules import TextOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.joystick_state import JoystickPhase, JoystickState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.rows import TextRow, wrapped, write_rows
from rune_tui.visualizers.parts.severity import Severity
from rune_tui.visualizers.words.status_words import joystick_words

_LONGEST_BAR = 20
_VALUE = 6
"""Width of a value such as " -0.25" [cells]."""
_AGE_STEP_S = 0.05


@dataclass(frozen=True, slots=True)
class Joystick:
    """A line on the device, then a row for each control: its name, a bar, its value.

    Attributes:
        name: Name of the joystick; empty: the first of the layout.
    """

    name: str

    rule: ClassVar = VisualizerRule(
        meaning="a joystick: its device, or that it is unplugged, and how each control is moved",
        options={"joystick": TextOption(names="joystick", meaning="which one; empty: the first")},
    )
    whole_cells: ClassVar[bool] = True
    urgency: ClassVar[Urgency] = Urgency.DRIVE

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls(spec.options.word("joystick"))

    def draw(self, canvas: Canvas, _robot: RobotState, state: ConsoleState) -> None:
        """Write the rows."""
        canvas.fill(state.theme.panel)
        write_rows(canvas, self._rows(state, canvas.width), state.theme)

    def source(self, _robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any shown value."""
        joystick = self._joystick(state)
        if joystick is None:
            return None, state.theme.name
        values = tuple((name, round(value, 2)) for name, value in joystick.values.items())
        device = joystick.device, joystick.phase, joystick.why, joystick.absence
        about = device, _age(joystick, state.now)
        return about, values, joystick.waiting, state.theme.name

    def _joystick(self, state: ConsoleState) -> JoystickState | None:
        if self.name:
            return state.joysticks.get(self.name)
        return next(iter(state.joysticks.values()), None)

    def _rows(self, state: ConsoleState, columns: int) -> list[TextRow]:
        joystick = self._joystick(state)
        if joystick is None:
            return [TextRow(f"the layout has no joystick {self.name}".rstrip(), Severity.WARNING)]
        words, severity = joystick_words(joystick)
        device = f" {joystick.device}" if joystick.device else ""
        rows = [TextRow(f"{joystick.name}{device}: {words}", severity)]
        if age := _age(joystick, state.now):
            rows.append(TextRow(age))
        if joystick.phase is not JoystickPhase.CONNECTED and joystick.why:
            rows += wrapped(TextRow(joystick.why), columns)
        return [*rows, *_bars(joystick, columns)]


def _age(joystick: JoystickState, now: float) -> str:
    """Age of the state of another machine's device, in steps that do not flicker."""
    if joystick.measured is None:
        return ""
    steps = round(max(0.0, now - joystick.measured) / _AGE_STEP_S)
    return f"what it says is {steps * _AGE_STEP_S:.2f} s old"


def _bars(joystick: JoystickState, columns: int) -> Iterator[TextRow]:
    longest = max(map(len, joystick.values), default=0)
    names = min(longest, max(4, columns // 2 - _VALUE))
    length = min(_LONGEST_BAR, columns - names - _VALUE - 2)
    for name, value in joystick.values.items():
        drawn = f" {bar(value, length)}" if length >= 3 else ""
        moved = Severity.GOOD if value else Severity.PLAIN
        yield TextRow(f"{name[:names]:{names}}{drawn} {value:+.2f}".rstrip(), moved)


def bar(value: float, length: int) -> str:
    """A position of -1 to 1 as a row of signs, with the rest position in the middle."""
    half = (length - 1) // 2
    moved = min(half, round(abs(value) * half))
    rest = "·" * (half - moved)
    left, right = ("█" * moved, "") if value < 0 else ("", "█" * moved)
    return f"{rest if value < 0 else '·' * half}{left}┃{right}{rest if value >= 0 else '·' * half}"
