"""What every visualizer is: made from the layout, draws one robot's state on a canvas."""

from __future__ import annotations

from collections.abc import Hashable
from typing import ClassVar, Protocol, Self

from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas


class Visualizer(Protocol):
    """Turns what is known of a robot into pixels and characters.

    Attributes:
        whole_cells: Whether it writes characters and so wants a viewport made of whole cells.
    """

    whole_cells: ClassVar[bool]

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        ...

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw on a clear canvas of the viewport's size."""
        ...

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """A token that changes when, and only when, `draw` would draw something else."""
        ...
