"""The widget that ends the console."""

from __future__ import annotations

from typing import ClassVar

from rune_tui.layout.rules import HandlerRule, Purpose, Section
from rune_tui.model.effects import Effect, QuitEffect
from rune_tui.widgets.widget import EffectWidget


class Quit(EffectWidget):
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

    def effect(self) -> Effect:
        """The end."""
        return QuitEffect()
