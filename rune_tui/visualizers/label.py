"""visualizeLabel: fixed words, such as the name of a robot or of a viewport."""

from __future__ import annotations

import textwrap
from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar, Self

from rune_tui.layout.rules import VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas, printable_text


@dataclass(frozen=True, slots=True)
class Label:
    """Text from the upper left corner on, wrapped; everything else is clear.

    Attributes:
        text: What it says.
    """

    text: str

    rule: ClassVar = VisualizerRule(meaning="its `text`", text=True)
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for; its text is what it says."""
        return cls(printable_text(spec.text))

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:  # noqa: ARG002
        """Write the text."""
        for row, line in enumerate(textwrap.wrap(self.text, max(1, canvas.width))):
            canvas.text(0, row, line, state.theme.ink)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:  # noqa: ARG002
        """Changes with the colours only."""
        return state.theme.name
