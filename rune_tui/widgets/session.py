"""Widgets of the session: layouts, pictures, recordings, calibration, and the end."""

from __future__ import annotations

from typing import ClassVar

from rune_tui.layout.rules import HandlerRule, Purpose, Section, TextOption
from rune_tui.model.effects import (
    CalibrateEffect,
    Effect,
    NextLayoutEffect,
    QuitEffect,
    RecordEffect,
    ScreenshotEffect,
)
from rune_tui.widgets.widget import EffectWidget


class NextLayout(EffectWidget):
    """Opens the next layout."""

    rule: ClassVar = HandlerRule(
        section=Section.SESSION,
        says={"": "Open the next layout"},
        meaning="Opens the next of the layouts that the console was started with; with a single "
        "one, that of the option `layout`.",
        options={
            "layout": TextOption(
                longest=64, meaning="a shipped layout that is next where only one was named"
            )
        },
        needs_robot=False,
    )

    def effect(self) -> Effect:
        """The next layout."""
        return NextLayoutEffect()


class Screenshot(EffectWidget):
    """Writes the shown view into files."""

    rule: ClassVar = HandlerRule(
        section=Section.SESSION,
        says={"": "Keep a picture of the screen"},
        meaning="Writes what is shown into files in your pictures folder: PNG and text.",
        also="photo screenshot snapshot image",
        needs_robot=False,
    )

    def effect(self) -> Effect:
        """The files."""
        return ScreenshotEffect()


class RecordWidget(EffectWidget):
    """Records, or ends it."""

    rule: ClassVar = HandlerRule(
        section=Section.SESSION,
        says={"": "Record, or end it"},
        meaning=(
            "Records all that comes from the robots and goes to them into an MCAP file in your "
            "documents folder; again: ends it."
        ),
        needs_robot=False,
    )

    def effect(self) -> Effect:
        """On or off."""
        return RecordEffect()


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
