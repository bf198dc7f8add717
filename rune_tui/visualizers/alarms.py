"""visualizeAlarms: what is wrong now, the worst first; a quiet line while nothing is."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import ClassVar, Self

from hub.gcm.navigation import ROBOT_STATE, Assistance
from rune_tui.layout.rules import VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LackKind, RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.mood import Mood, Part, ink_of
from rune_tui.visualizers.range_data import pressed_bumpers
from rune_tui.visualizers.rows import Row, cut, wrapped
from rune_tui.visualizers.status_words import side_of, status_parts

START_S = 10.0
"""Modules that are not ready yet are no alarm for this time after a link began [s]."""
_SIGNS = {Mood.ALARM: "!! ", Mood.WARNING: "! "}


@dataclass(frozen=True, slots=True)
class Alarms:
    """Alarms on the alarm's colour behind "!!", then warnings behind "!", in words."""

    rule: ClassVar = VisualizerRule(
        meaning="what is wrong now, the worst first; all well if nothing is",
        message=ROBOT_STATE.name,
        others=("GCM_CameraState", "GCM_Control_State"),
        vital=True,
    )
    whole_cells: ClassVar[bool] = True
    urgency: ClassVar[Urgency] = Urgency.ALARM

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:  # noqa: ARG003 it has no options
        """The visualizer that a layout asks for."""
        return cls()

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write what fits; behind it stands how many more there are."""
        theme = state.theme
        canvas.fill(theme.panel)
        parts = _troubles(robot, state)
        if not parts:
            canvas.text(0, 0, f"{robot.title}: all well", theme.faint)
            return
        blocks = [_block(part, canvas.width) for part in parts]
        shown = _fitting(blocks, canvas.rows)
        lines = [line for block in blocks[:shown] for line in block][: canvas.rows]
        more = f" +{len(blocks) - shown}" if shown < len(blocks) else ""
        for row, line in enumerate(lines):
            behind = more if row == len(lines) - 1 else ""
            _write(canvas, row, line, behind, state.theme)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word of it."""
        return robot.title, _troubles(robot, state), state.theme.name


def _troubles(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    parts = [part for part in status_parts(robot, state) if part.mood in _SIGNS]
    parts += _more(robot, state)
    # Python's sort keeps the order of equals.
    return tuple(sorted(parts, key=lambda part: (part.mood is not Mood.ALARM, -part.weight)))


def _more(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """What the status line has no room for."""
    if robot.navigation is not None:
        navigation = robot.navigation.value
        sides = dict.fromkeys(map(side_of, pressed_bumpers(navigation)))
        if sides:
            yield Part(f"BUMPER PRESSED {' and '.join(sides)}", 8, Mood.ALARM)
        if navigation.assistance is Assistance.OFF:
            yield Part("ASSISTANCE OFF: it drives into walls", 5, Mood.WARNING)
    starts = state.now - robot.link.since < START_S
    for name, lack in sorted(robot.link.lacking.items()):
        if lack.kind is LackKind.BROKEN or (lack.kind is LackKind.COMING and not starts):
            yield Part(f"{name} MISSING: {lack.why}", 4, Mood.WARNING)


def _block(part: Part, columns: int) -> list[Row]:
    sign = _SIGNS[part.mood]
    return [*wrapped(Row(sign + part.text, part.mood), columns, " " * len(sign))]


def _fitting(blocks: list[list[Row]], rows: int) -> int:
    """How many blocks fit, but one at least."""
    used = 0
    for index, block in enumerate(blocks):
        used += len(block)
        if used > rows:
            return max(1, index)
    return len(blocks)


def _write(canvas: Canvas, row: int, line: Row, behind: str, theme: Theme) -> None:
    ink = ink_of(line.mood, theme)
    if line.mood is Mood.ALARM:
        ink = theme.on_alarm
        with drawing(canvas) as pen:
            pen.rectangle(0, 2 * row, canvas.width, 2 * row + 2, theme.alarm)
    room = canvas.width - len(behind)
    canvas.text(0, row, cut(line.text, room), ink)
    canvas.text(room, row, behind, ink)
