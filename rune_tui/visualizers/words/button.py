"""visualizeButton: an area to click at, with a text and the state that it toggles, if any."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import ClassVar, Final, Self

from hub.gcm.navigation import ROBOT_STATE, Assistance
from hub.values import dataclass
from rune_tui.layout.names import canonical_key
from rune_tui.layout.rules import ChoiceOption, TextOption, VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.raster.canvas import Canvas, printable_text
from rune_tui.raster.shapes import drawing
from rune_tui.visualizers.parts.rows import fitting_form
from rune_tui.visualizers.parts.staleness import Staleness, fade_by_age, staleness

_NOTHING: Final = "nothing"
_LEAST_FRAME = (5, 6)
"""Least width and height of a button with a frame [pixels]."""


def _assistance(robot: RobotState, state: ConsoleState) -> bool | None:
    received = robot.navigation
    if received is None or staleness(received.age(state.now)) is Staleness.STALE:
        return None
    return received.value.assistance is Assistance.ON


_STATES: Final[Mapping[str, Callable[[RobotState, ConsoleState], bool | None]]] = {
    _NOTHING: lambda _robot, _state: None,
    "assistance": _assistance,
    "chosen": lambda robot, state: state.chosen == robot.name,
    "help": lambda _robot, state: state.help,
    "night": lambda robot, state: robot.name in state.night,
}
"""The states that a button can show; None: not known."""
_SHOWN: Final = frozenset({"assistance"})
"""The states that come from the robot."""


@dataclass(frozen=True, slots=True)
class _Face:
    """The visible part of a button.

    Attributes:
        text: Its text.
        on: Whether its subject is on; None: it has none, or that is not known.
        known: Whether it is known.
        pressed: Whether its key is held.
        look: Fading by the age of that.
    """

    text: str
    on: bool | None
    known: bool
    pressed: bool
    look: Staleness


@dataclass(frozen=True, slots=True)
class Button:
    """A plate with a text; an active one is on the accent and has a word, a pressed one has arrows.

    Attributes:
        text: Its text.
        key: The key that does the same, or none.
        shows: The state that it turns, of `_STATES`.
    """

    text: str
    key: str
    shows: str

    rule: ClassVar = VisualizerRule(
        meaning="an area to click at, with its `text`",
        others=(ROBOT_STATE.name,),
        text=True,
        options={
            "key": TextOption(
                longest=20, meaning="the key that does the same; it looks pressed while it is held"
            ),
            "shows": ChoiceOption(
                default=_NOTHING,
                choices=tuple(_STATES),
                meaning="what it says on or off of; chosen is whether its robot is the chosen one",
            ),
        },
    )
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        """The visualizer that a layout asks for."""
        key = canonical_key(spec.options.word("key"))
        return cls(printable_text(spec.text), key, spec.options.word("shows"))

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Draw the plate with its text."""
        face, theme = self._face(robot, state), state.theme
        lit = face.on or face.pressed
        plate, ink = (theme.ink, theme.panel) if lit else (theme.panel, theme.ink)
        canvas.fill(plate)
        framed = canvas.width >= _LEAST_FRAME[0] and canvas.height >= _LEAST_FRAME[1]
        if framed:
            with drawing(canvas) as pen:
                pen.rectangle(0, 0, canvas.width, canvas.height, theme.faint)
                pen.rectangle(1, 1, canvas.width - 1, canvas.height - 1, plate)
        words = _words(face, canvas.width - 2 * framed)
        canvas.text((canvas.width - len(words)) // 2, (canvas.rows - 1) // 2, words, ink)
        fade_by_age(canvas, self._age(robot, state))

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with its text and its press."""
        return self._face(robot, state), state.theme.name

    def _face(self, robot: RobotState, state: ConsoleState) -> _Face:
        on = _STATES[self.shows](robot, state)
        pressed = bool(self.key) and self.key in state.held
        known = on is not None or self.shows == _NOTHING
        return _Face(self.text, on, known, pressed, staleness(self._age(robot, state)))

    def _age(self, robot: RobotState, state: ConsoleState) -> float:
        """Age of its state [s]; 0 for the console's own."""
        if robot.navigation is None or self.shows not in _SHOWN:
            return 0.0
        return robot.navigation.age(state.now)


def _words(face: _Face, columns: int) -> str:
    # Without room the first word stays, then the last one, which is the key.
    first, *others = face.text.split() or [""]
    forms = [face.text, *([first, others[-1]] if others else ())]
    if not face.known:
        forms = [f"{face.text}: ?", f"{face.text}?"]
    elif face.on is not None:
        word, sign = ("on", "+") if face.on else ("off", "-")
        forms = [f"{face.text}: {word}", f"{face.text} {word}", f"{face.text}{sign}"]
    if face.pressed:
        forms = [f"> {forms[0]} <", *(f">{form}<" for form in forms)]
    return fitting_form(columns, *forms)
