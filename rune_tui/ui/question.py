"""One line for the operator to type, over the view."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Label

LONGEST = 500


class Question(ModalScreen[None]):
    """Asks for a text; enter accepts it, escape changes nothing."""

    CSS = """
    Question { align: center middle; }
    Question > Vertical { width: 80%; max-width: 80; height: auto; border: round $accent; }
    Question Label { width: 100%; }
    """
    BINDINGS: ClassVar = [Binding("escape", "leave", "cancel", show=False)]

    def __init__(
        self, asked: str, text: str, answered: Callable[[str], None], stop: str = ""
    ) -> None:
        """Prepare.

        Args:
            asked: What is asked for.
            text: What stands there already.
            answered: Called with what was typed.
            stop: The stop key, in words; empty: there is none.
        """
        super().__init__()
        self._asked = asked
        self._hints = "enter: accept, escape: cancel"
        if stop:
            self._hints += f", {stop} twice: stop"
        self._text = text
        self._answered = answered
        self._over = False

    def compose(self) -> ComposeResult:
        """The question over the line."""
        with Vertical():
            yield Label(f"{self._asked} ({self._hints})", markup=False)
            yield Input(self._text, max_length=LONGEST)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """It is typed."""
        if self._end():
            self._answered(event.value.strip())

    def action_leave(self) -> None:
        """Nothing is changed."""
        self._end()

    def _end(self) -> bool:
        """Take the question away; False if it is over already.

        Keys that come at once with the first enter or escape are for nobody: to take a screen away
        twice ends the program.
        """
        first, self._over = not self._over, True
        if first and self.is_current:
            self.dismiss()
        return first
