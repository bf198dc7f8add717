"""visualizeStatus: one line of words on a dark bar."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterable, Sequence
from typing import ClassVar, Self

from hub.gcm.autonomy import AUTONOMY_STATE
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.navigation import NAVIGATION_STATUS
from hub.gcm.ranges import RANGES
from hub.gcm.vehicle import VEHICLE_STATE
from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas, printable_text
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.rows import cut
from rune_tui.visualizers.parts.severity import Part, Severity, ink_of
from rune_tui.visualizers.words.status_words import MOTION, NAME, status_parts
from rune_tui.visualizers.words.troubles import is_in_banner

_GAP = 2
_NOTHING, _ALARMS, _ATTENTION, _GAUGES = "nothing", "alarms", "attention", "gauges"
_TROUBLE = frozenset({Severity.WARNING, Severity.ALARM})


@dataclass(frozen=True, slots=True)
class Status:
    """Name, link, control, motion, own task, speed, battery, obstacle and so on.

    Attributes:
        alarms: Whether another pane shows all alarms and warnings.
        attention: Whether another pane shows those with a cause.
        gauges: Whether other panes show speed and battery.
    """

    alarms: bool = False
    attention: bool = False
    gauges: bool = False

    rule: ClassVar = VisualizerRule(
        meaning="one line: link, who has control, motion, what it does by itself, speed, battery",
        message="GCM_RobotState",
        others=(
            "GCM_CameraState",
            "GCM_Control_State",
            AUTONOMY_STATE.name,
            NAVIGATION_STATUS.name,
            RANGES.name,
            VEHICLE_STATE.name,
            DIAGNOSTICS.name,
        ),
        options={
            "beside": ChoiceOption(
                default=_NOTHING,
                choices=(
                    _NOTHING,
                    _ALARMS,
                    _ATTENTION,
                    _GAUGES,
                    f"{_ALARMS} and {_GAUGES}",
                    f"{_ATTENTION} and {_GAUGES}",
                ),
                meaning="what other panes say, and this line then does not: alarms what is wrong, "
                "attention the same without what you can change, such as keys to let go of, gauges "
                "speed, battery and that it is linked",
            )
        },
        vital=True,
    )
    whole_cells: ClassVar[bool] = True
    urgency: ClassVar[Urgency] = Urgency.ALARM

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        beside = spec.options.word("beside")
        return cls(
            alarms=_ALARMS in beside, attention=_ATTENTION in beside, gauges=_GAUGES in beside
        )

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the parts that fit into the first row."""
        canvas.fill(state.theme.bar)
        parts = fitting(_deciding(self._shown_parts(robot, state), canvas.width), canvas.width)
        column = 0 if _width(parts) + 2 > canvas.width else 1
        for part in parts:
            canvas.text(
                column, 0, cut(part.text, canvas.width - column), ink_of(part.severity, state.theme)
            )
            column += len(printable_text(part.text)) + _GAP

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word of it."""
        return self._shown_parts(robot, state), state.theme.name

    def _shown_parts(self, robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
        """The parts that neither the banner nor another pane shows.

        Full screen and pages hide the gauges.
        """
        gauges = self.gauges and not (state.full or state.paged)
        return tuple(
            part
            for part in status_parts(robot, state)
            if not (
                (part.severity in _TROUBLE and (self.alarms or (self.attention and part.cause)))
                or (gauges and part.gauge)
                or is_in_banner(part, robot, state)
            )
        )


def _deciding(parts: Sequence[Part], columns: int) -> Sequence[Part]:
    """The parts, without the robot's name where its motion has no room beside it."""
    pair = [part for part in parts if part.cause in (NAME, MOTION)]
    narrow = [dataclasses.replace(part, text=part.short or part.text) for part in pair]
    if len(pair) < 2 or _width(narrow) <= columns:
        return parts
    return [part for part in parts if part.cause != NAME]


def fitting(parts: Sequence[Part], columns: int) -> tuple[Part, ...]:
    """The parts that fit side by side, at least one.

    Parts of the least weight are shortened first, then left out.
    """
    if _width(parts) <= columns:
        return tuple(parts)
    kept: dict[int, Part] = dict(enumerate(parts))
    for weight in sorted({part.weight for part in parts}):
        places = [place for place in reversed(kept) if kept[place].weight == weight]
        for place in places:
            if kept[place].short and _width(kept.values()) > columns:
                kept[place] = dataclasses.replace(kept[place], text=kept[place].short)
        for place in places:
            if len(kept) > 1 and _width(kept.values()) > columns:
                del kept[place]
    return tuple(kept.values())


def _width(parts: Iterable[Part]) -> int:
    return sum(len(printable_text(part.text)) + _GAP for part in parts) - _GAP
