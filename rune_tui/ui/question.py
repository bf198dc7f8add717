"""A question over the view, with one line for the answer."""

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
    """Asks for a text; enter accepts it, escape cancels."""

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
            asked: The question.
            text: Text in the line at first.
            answered: Called with the typed text.
            stop: The stop key, in words; empty if there is none.
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
        """Accept the text."""
        if self._end():
            self._answered(event.value.strip())

    def action_leave(self) -> None:
        """Cancel."""
        self._end()

    def _end(self) -> bool:
        """Close the question; False if it is closed already.

        A second enter or escape must not close another screen: without any, the program ends.
        """
        first, self._over = not self._over, True
        if first and self.is_current:
            self.dismiss()
        return first
