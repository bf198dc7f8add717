"""Events of the mouse, as a part of it that goes down, goes up, turns or moves."""

from __future__ import annotations

from abc import abstractmethod

from textual import events
from textual.app import App

_BUTTONS = {1: "left", 2: "middle", 3: "right"}


class MouseApp(App[None], inherit_bindings=False):
    """Passes all events of the mouse to one method."""

    @abstractmethod
    def mouse(
        self, event: events.MouseEvent, part: str, *, pressed: bool = True, value: float = 1.0
    ) -> None:
        """Handle a move of a part of the mouse.

        Args:
            event: The terminal's report.
            part: "left", "middle", "right", "wheel" or "motion"; empty: a button without a name.
            pressed: Whether it went down.
            value: 1 for the wheel away from the operator, -1 towards the operator.
        """

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """A button went down."""
        self.mouse(event, _BUTTONS.get(event.button, ""))

    def on_mouse_up(self, event: events.MouseUp) -> None:
        """A button went up."""
        self.mouse(event, _BUTTONS.get(event.button, ""), pressed=False)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """The mouse moved."""
        self.mouse(event, "motion")

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """The wheel turned away from the operator."""
        self.mouse(event, "wheel")

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """The wheel turned towards the operator."""
        self.mouse(event, "wheel", value=-1.0)
