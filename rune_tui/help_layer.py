"""The help: a page over everything that says what each input of the layout does."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterator, Sequence
from itertools import groupby

from rune_tui.compositor.blend import Layer
from rune_tui.layout.actions import Action, actions_of
from rune_tui.layout.spec import CHOSEN, LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas

_TWO_COLUMNS = 110
"""From this width on, the page has two columns [cells]."""
_MOST_INPUTS = 22
"""Room for the names of inputs [cells]."""
_CLOSE = "? or escape closes this; driving keys rest while it is open"

Line = tuple[str, str]
"""The inputs and what they do, or a heading and nothing."""


class HelpLayer:
    """Draws the page when it is wanted, and again only if it would look different."""

    def __init__(self, layout: LayoutSpec) -> None:
        self._actions = actions_of(layout)
        self._look: tuple[object, ...] = ()
        self.layers: tuple[Layer, ...] = ()

    def refresh(self, columns: int, rows: int, state: ConsoleState) -> bool:
        """Bring `layers` up to date; whether they changed."""
        look = (columns, rows, state.theme.name) if state.help else ()
        if look == self._look:
            return False
        self._look = look
        self.layers = ()
        if state.help:
            canvas = Canvas.blank(columns, 2 * rows)
            draw_help(canvas, self._actions, state.theme)
            self.layers = (Layer(canvas=canvas, x=0, y=0, zpos=sys.maxsize),)
        return True


def draw_help(canvas: Canvas, actions: Sequence[Action], theme: Theme) -> None:
    """Fill a canvas with the page; what does not fit is counted at its end."""
    canvas.fill(theme.panel)
    blocks = 2 if canvas.width >= _TWO_COLUMNS else 1
    width = (canvas.width - 2) // blocks - 1
    lines = list(_lines(actions, width))
    room = max(1, canvas.rows - 2)
    canvas.text(1, 0, _CLOSE, theme.faint)
    shown = lines[: blocks * room]
    if len(lines) > len(shown):
        left = len(lines) - len(shown) + 1
        shown[-1] = ("", f"and {left} more lines: make the terminal larger, or press ctrl+p")
    for number, (inputs, words) in enumerate(shown):
        column, row = 1 + number // room * (width + 1), 2 + number % room
        if not words:
            canvas.text(column, row, inputs, theme.accent)
            continue
        canvas.text(column, row, inputs, theme.ink)
        canvas.text(column + _MOST_INPUTS + 1, row, words, theme.faint)


def _lines(actions: Sequence[Action], width: int) -> Iterator[Line]:
    room = max(8, width - _MOST_INPUTS - 1)
    for robot, group in groupby(actions, key=lambda action: action.robot):
        yield robot_words(robot).upper(), ""
        for action in group:
            names = textwrap.wrap(", ".join(action.inputs), _MOST_INPUTS)
            words = textwrap.wrap(action.words, room)
            for index in range(max(len(names), len(words))):
                name = names[index] if index < len(names) else ""
                yield name, words[index] if index < len(words) else " "


def robot_words(robot: str) -> str:
    """Whom an action concerns, for people."""
    if robot == CHOSEN:
        return "the chosen robot"
    return robot or "the console"
