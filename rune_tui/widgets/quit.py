"""The widget that ends the console."""

from __future__ import annotations

from rune_tui.controls.events import ControlEvent
from rune_tui.layout.spec import EventSpec
from rune_tui.model.effects import Effect, QuitEffect
from rune_tui.widgets.widget import PressWidget


class Quit(PressWidget):
    """Ends the console."""

    def press(self, event: ControlEvent, event_spec: EventSpec) -> tuple[Effect, ...]:  # noqa: ARG002 - every key of it means the same
        """The end."""
        return (QuitEffect(),)
