"""widgetCalibrate: asks for the ends of a joystick's axes."""

from __future__ import annotations

from typing import ClassVar

from rune_tui.layout.rules import HandlerRule, Section, TextOption
from rune_tui.model.effects import CalibrateEffect, Effect
from rune_tui.widgets.widget import EffectWidget


class Calibrate(EffectWidget):
    """Starts the calibration of a joystick, or ends it."""

    rule: ClassVar = HandlerRule(
        section=Section.SESSION,
        says={"": "Calibrate a joystick"},
        meaning=(
            "Asks for the ends and the rest of a joystick's axes, one after the other, and keeps "
            "them for that device; again: ends it. Meanwhile the joystick drives nothing."
        ),
        options={
            "joystick": TextOption(names="joystick", meaning="which one; empty: the first"),
            "control": TextOption(
                longest=64,
                meaning="which axis; empty: those with `calibrate`, or all if there are none",
            ),
        },
        needs_robot=False,
    )

    def effect(self) -> Effect:
        """The calibration."""
        word = self.spec.options.word
        return CalibrateEffect(joystick=word("joystick"), control=word("control"))
