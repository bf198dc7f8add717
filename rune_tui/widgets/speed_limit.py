"""widgetSpeedLimit: how much of its full speed a robot may be driven with."""

from __future__ import annotations

from typing import ClassVar

from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import HandlerRule, NumberOption, Section
from rune_tui.layout.spec import EventSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, LimitSpeed
from rune_tui.widgets.widget import PressWidget

_STEP = "step"
_TO = "to"


class SpeedLimit(PressWidget):
    """Changes the speed limit of a robot by steps, or sets it."""

    rule: ClassVar = HandlerRule(
        section=Section.DRIVE,
        says={_STEP: "Speed limit {direction}", _TO: "Speed limit {percent}"},
        meaning=(
            "Changes the speed limit of the robot, which holds for keys and sticks. `step` goes "
            "through 10, 25, 50 and 100 %, a positive value up; `to` sets it to the option "
            "`percent`. A console starts with 100 %."
        ),
        controls=(_STEP, _TO),
        options={
            "percent": NumberOption(
                default=100.0, least=1.0, most=100.0, unit="%", meaning="what `to` sets it to"
            )
        },
        words={_STEP: ("up", "down")},
    )

    def press(
        self, _event: ControlEvent, event_spec: EventSpec, _state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The next limit, or the one that the layout gives."""
        if event_spec.control == _TO:
            share = self.spec.options.number("percent") / 100.0
            return (LimitSpeed(robot=self.robot, share=share),)
        return (LimitSpeed(robot=self.robot, up=event_spec.value > 0.0),)
