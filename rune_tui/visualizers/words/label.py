"""visualizeLabel: fixed words, such as the name of a robot or of a viewport."""

from __future__ import annotations

import textwrap
from collections.abc import Hashable
from typing import ClassVar, Self

from hub.values import dataclass
from rune_tui.layout.rules import VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas, printable_text
from rune_tui.raster.lettering import Font, check_font, letter, measured

_BETWEEN = " · "
"""Separates the pieces of a list; pieces that do not fit into one row are left out."""


@dataclass(frozen=True, slots=True)
class Label:
    """Wrapped text from the upper left corner; the rest is clear.

    Attributes:
        text: Its text.
        font: Letters of its own; None: the terminal's.
    """

    text: str
    font: Font | None = None

    rule: ClassVar = VisualizerRule(
        heads=True,
        meaning="its `text`, in letters of the terminal or of a `font`",
        text=True,
        font=True,
    )
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer of a layout, with its text."""
        font = Font(file=spec.font.file, points=spec.font.points) if spec.font else None
        if font:
            check_font(font)
        return cls(printable_text(spec.text), font)

    def draw(self, canvas: Canvas, _robot: RobotState, state: ConsoleState) -> None:
        """Write the text."""
        if self.font:
            for row, line in enumerate(_wrapped(self.text, self.font, canvas.width)):
                height = measured(line, self.font)[1]
                letter(canvas, (0.0, row * height), line, self.font, state.theme.ink)
            return
        for row, line in enumerate(self._lines(canvas)):
            canvas.text(0, row, line, state.theme.soft)

    def _lines(self, canvas: Canvas) -> list[str]:
        """The text wrapped; in one row, the pieces of a list that fit, the first one always."""
        pieces = self.text.split(_BETWEEN)
        if canvas.rows > 1 or len(pieces) < 3:
            return textwrap.wrap(self.text, max(1, canvas.width))
        while len(pieces) > 1 and len(_BETWEEN.join(pieces)) > canvas.width:
            # The first is about the stop; the last two are about help and the end.
            del pieces[{3: -2, 2: -1}.get(len(pieces), -3)]
        return [_BETWEEN.join(pieces)]

    def source(self, _robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the colours only."""
        return state.theme.name


def _wrapped(text: str, font: Font, width: int) -> list[str]:
    """The text in lines up to this width [pixels], as far as its words allow."""
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and measured(longer, font)[0] <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
