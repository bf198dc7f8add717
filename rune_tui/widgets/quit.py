"""The widget that ends the console."""

from __future__ import annotations

from typing import ClassVar

from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import HandlerRule, Purpose, Section
from rune_tui.layout.spec import EventSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, QuitEffect
from rune_tui.widgets.widget import PressWidget


class Quit(PressWidget):
    """Ends the console."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.QUIT,
        section=Section.SESSION,
        says={"": "Quit"},
        meaning=(
            "Ends the console; every robot is sent zero speed first. It asks first while a "
            "recording runs or a robot goes by itself; pressed again, it ends."
        ),
        needs_robot=False,
        under_help=True,
    )

    def press(
        self,
        event: ControlEvent,  # noqa: ARG002 - every key of it means the same
        event_spec: EventSpec,  # noqa: ARG002
        state: ConsoleState,  # noqa: ARG002
    ) -> tuple[Effect, ...]:
        """The end."""
        return (QuitEffect(),)
