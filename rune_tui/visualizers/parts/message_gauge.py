"""Common part of visualizers of one message: they take a reading of it, and draw only that."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable
from typing import Any, ClassVar, Generic, Self, TypeVar

from hub.ipc.definition import MessageDefinition
from hub.values import dataclass
from rune_tui.layout.rules import Options
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.parts.staleness import age_look, draw_age, pause_of

T = TypeVar("T")
R = TypeVar("R", bound=Hashable)


@dataclass(frozen=True)
class MessageGauge(ABC, Generic[T, R]):
    """Draws a value of a message, and its age.

    `reading` rounds the value to the visible precision, and `show` draws only the reading. So the
    picture changes only with the reading.

    Attributes:
        options: The options in the layout.
        option: Its numeric option.
    """

    options: Options
    option: float

    definition: ClassVar[MessageDefinition[Any]]
    subject: ClassVar[str]
    """The missing message, in words."""
    whole_cells: ClassVar[bool] = True
    urgency: ClassVar[Urgency] = Urgency.OTHER

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        return cls(spec.options, spec.option)

    @abstractmethod
    def reading(self, value: T, robot: RobotState) -> R:
        """The visible part of a message."""

    @abstractmethod
    def show(self, canvas: Canvas, reading: R, theme: Theme) -> None:
        """Draw a reading on a canvas that is filled with the theme's panel."""

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the newest message and its age."""
        canvas.fill(state.theme.panel)
        received = robot.newest(self.definition)
        if received is None:
            write_notice(canvas, self._missing(robot), state.theme)
            return
        age, pause = received.age(state.now), pause_of(self.definition)
        self.show(canvas, self.reading(received.value, robot), state.theme)
        draw_age(canvas, age, state.theme, pause)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the reading and the drawing of its age."""
        received = robot.newest(self.definition)
        if received is None:
            return self._missing(robot), state.theme.name
        look = age_look(received, state.now, pause_of(self.definition))
        return self.reading(received.value, robot), look, state.theme.name

    def _missing(self, robot: RobotState) -> str:
        return f"no {self.subject} from {robot.title}"
