"""Widgets that go by steps: one for each press, and more while a button or a stick is held."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from rune_tui.controls.events import ControlEvent
from rune_tui.layout.spec import ControlKind, EventSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect
from rune_tui.widgets.widget import PressWidget

_PERIOD_S = 0.1
"""Time between two steps while held [s]."""
_DELAY_S = 0.4
"""Time from a button's first step to its second, as on keyboards [s]."""
_EARLY_S = 0.025
"""A tick this much too early counts, half of the time between two ticks [s]."""
_HELD = {ControlKind.AXIS: _PERIOD_S, ControlKind.BUTTON: _DELAY_S, ControlKind.HAT: _DELAY_S}
"""Time of the second step while held [s]."""


class SteppingWidget(PressWidget):
    """A widget of steps.

    A press, a repeat, and a click of a wheel or a ball is a step. Terminals repeat held keys;
    devices do not repeat held buttons and hats, so those are repeated here. An axis that is not
    neutral makes steps all the time, the smaller the less it is deflected.
    """

    repeats: ClassVar[bool] = True

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._held: dict[EventSpec, tuple[float, float]] = {}
        """The held controls of joysticks, with the size of a step and the time of the next."""

    @abstractmethod
    def step(self, value: float, control: str, state: ConsoleState) -> Effect:
        """Effects of a step; its value is 1 for a press, unless the layout sets another."""

    def handle(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The first step at once; held input gives further ones at each tick."""
        if not event.pressed:
            self._held.pop(event_spec, None)
        elif event_spec.kind is ControlKind.AXIS and event.repeat:
            # One that was deflected before all was forgotten has to be neutral first.
            if event_spec in self._held:
                self._held[event_spec] = _value(event, event_spec), self._held[event_spec][1]
            return ()
        elif event_spec.kind in _HELD and not event_spec.released:
            due = state.now + _HELD[event_spec.kind]
            self._held[event_spec] = _value(event, event_spec), due
        return super().handle(event, event_spec, state)

    def press(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """One step."""
        return (self.step(_value(event, event_spec), event_spec.control, state),)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """The due steps of held input."""
        effects: list[Effect] = []
        for event_spec, (value, due) in self._held.items():
            late = state.now - due
            if late >= -_EARLY_S:
                # Counted on from when it was due, so that jitter does not lower the rate.
                then = due if late < _PERIOD_S else state.now
                self._held[event_spec] = value, then + _PERIOD_S
                effects.append(self.step(value, event_spec.control, state))
        return tuple(effects)

    def release(self, _state: ConsoleState) -> tuple[Effect, ...]:
        """Forget held inputs."""
        self._held.clear()
        return ()


def _value(event: ControlEvent, event_spec: EventSpec) -> float:
    pressed = event_spec.kind in {ControlKind.BUTTON, ControlKind.HAT}
    return event_spec.value * (1.0 if pressed else event.value)
