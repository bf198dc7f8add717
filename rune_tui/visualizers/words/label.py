"""visualizeLabel: fixed words, such as the name of a robot or of a viewport."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import ClassVar, Final, Self

from hub.gcm.body import ROBOT_DESCRIPTION, Freedom, RobotBody
from hub.values import dataclass
from rune_tui.layout.rules import VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas, printable_text
from rune_tui.raster.lettering import Font, check_font, letter, measured
from rune_tui.visualizers.parts.text_colour import COLOUR_OPTION, USUAL, colour_of

_BETWEEN = " · "
"""Separates the pieces of a list; pieces that do not fit into one row are left out."""
_ABILITIES: Final[Mapping[str, Callable[[RobotBody], bool]]] = {
    "look": lambda body: any(
        each.pan_limit or each.tilt_lowest < each.tilt_highest for each in body.cameras[:1]
    ),
    "hold": lambda body: bool(body.holds),
    "light": lambda body: bool(body.lights),
    "arm": lambda body: bool(body.arms),
}
"""Conditions of pieces besides degrees of freedom: whether a body has something."""
_CONDITION = re.compile(
    rf"\{{({'|'.join((*(each.name.lower() for each in Freedom), *_ABILITIES))})\}}"
)
"""Begins a piece for robots whose body moves so, or has that."""


@dataclass(frozen=True, slots=True)
class Label:
    """Wrapped text from the upper left corner; the rest is clear.

    A piece that begins with a degree of freedom in braces, such as `{heave}`, is shown only for
    robots whose body moves so. `_ABILITIES` has further conditions.

    Attributes:
        text: Its text.
        font: Letters of its own; None: the terminal's.
        colour: Its colour, as in the option `colour`.
    """

    text: str
    font: Font | None = None
    colour: str = USUAL

    rule: ClassVar = VisualizerRule(
        heads=True,
        meaning="its `text`, in letters of the terminal or of a `font`; a piece between ` · ` that "
        "begins with a degree of freedom in braces, such as `{heave}` or `{sway}`, is shown only "
        "for robots that move so; `{look}` is for a main camera that turns, `{hold}`, `{light}` "
        "and `{arm}` for a body that has holds, has lights, or can be disarmed",
        others=(ROBOT_DESCRIPTION.name,),
        text=True,
        font=True,
        options={"colour": COLOUR_OPTION},
    )
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer of a layout, with its text."""
        font = Font(file=spec.font.file, points=spec.font.points) if spec.font else None
        if font:
            check_font(font)
        return cls(printable_text(spec.text), font, spec.options.word("colour"))

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the text."""
        pieces = self._pieces(robot)
        if self.font:
            ink = colour_of(self.colour, state.theme, state.theme.ink)
            text = _BETWEEN.join(pieces)
            for row, line in enumerate(_wrapped(text, self.font, canvas.width)):
                height = measured(line, self.font)[1]
                letter(canvas, (0.0, row * height), line, self.font, ink)
            return
        for row, line in enumerate(_lines(pieces, canvas)):
            soft = colour_of(self.colour, state.theme, state.theme.soft)
            canvas.text(0, row, line, soft)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with the pieces and the colours."""
        return self._pieces(robot), state.theme.name

    def _pieces(self, robot: RobotState) -> tuple[str, ...]:
        """The pieces for a robot, without their conditions."""
        pieces = self.text.split(_BETWEEN)
        met = _met(robot)
        known = ((_CONDITION.match(piece), piece) for piece in pieces)
        return tuple(
            piece[found.end() :] if found else piece
            for found, piece in known
            if found is None or found[1] in met
        )


def _met(robot: RobotState) -> frozenset[str]:
    """The conditions that a robot meets; none before its body is known."""
    if robot.body is None:
        return frozenset()
    body = robot.body
    moves = {motion.freedom.name.lower() for motion in body.motions}
    return frozenset(moves | {name for name, has in _ABILITIES.items() if has(body)})


def _lines(pieces: Sequence[str], canvas: Canvas) -> list[str]:
    """The text wrapped; in one row, the pieces of a list that fit, the first one always."""
    if canvas.rows > 1 or len(pieces) < 3:
        return textwrap.wrap(_BETWEEN.join(pieces), max(1, canvas.width))
    kept = list(pieces)
    while len(kept) > 1 and len(_BETWEEN.join(kept)) > canvas.width:
        # The first is about the stop; the last two are about help and the end.
        del kept[{3: -2, 2: -1}.get(len(kept), -3)]
    return [_BETWEEN.join(kept)]


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
