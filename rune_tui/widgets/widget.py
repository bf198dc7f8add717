"""The interface of widgets, which dispatch uses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Protocol, Self

from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import HandlerRule
from rune_tui.layout.spec import CHOSEN, EventSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect
from rune_tui.model.robot_state import RobotState


class Widget(Protocol):
    """A handler in use: it turns control events into effects and keeps history.

    Attributes:
        rule: Its element in layouts.
        robot: The robot that it commands; empty: a global widget.
    """

    rule: ClassVar[HandlerRule]
    robot: str

    @classmethod
    def from_spec(cls, spec: WidgetSpec, robot: str) -> Self:
        """The widget that a layout describes, for a robot of the layout."""

    def handle(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects of a press, repeat or release that matches one of its events."""

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of time going by; called 20 times a second."""

    def release(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Forget held input and stop the robot, after any command."""


class DrivingWidget(Widget, Protocol):
    """A widget with the purpose `DRIVE`."""

    def accepts(self, event_spec: EventSpec, state: ConsoleState) -> bool:
        """Whether an input would drive if it left neutral now."""

    def forget(self) -> None:
        """Nothing is held any longer; axes must be neutral before they drive."""


class TakingWidget(Widget, Protocol):
    """A widget with the purpose `TAKE_CONTROL`."""

    def takes_by_driving(self) -> bool:
        """Whether keys that drive take control as well."""


def commanded(widget: Widget, state: ConsoleState) -> str:
    """The robot that a widget commands now; still `CHOSEN` while none is chosen."""
    return (state.chosen or CHOSEN) if widget.robot == CHOSEN else widget.robot


class PressWidget(ABC):
    """A widget for single events, without held input.

    Attributes:
        rule: Its element in layouts.
        repeats: Whether each repeat of a key counts as a press.
    """

    rule: ClassVar[HandlerRule]
    repeats: ClassVar[bool] = False

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        self.spec = spec
        self.robot = robot

    @classmethod
    def from_spec(cls, spec: WidgetSpec, robot: str) -> Self:
        """The widget that a layout describes, for a robot of the layout."""
        return cls(spec, robot)

    @abstractmethod
    def press(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects of a press, or of a release, as the layout chooses."""

    def handle(
        self,
        event: ControlEvent,
        event_spec: EventSpec,
        state: ConsoleState,
    ) -> tuple[Effect, ...]:
        """Effects of the press or of the release, as the layout says; the other has none."""
        again = event.pressed and event.repeat
        known = self.repeats if event.second else again and not self.repeats
        if event.pressed == event_spec.released or known:
            return ()
        return self.press(event, event_spec, state)

    def tick(self, _state: ConsoleState) -> tuple[Effect, ...]:
        """No effects."""
        return ()

    def release(self, _state: ConsoleState) -> tuple[Effect, ...]:
        """No effects."""
        return ()


class EffectWidget(PressWidget):
    """A widget with an effect that depends on the layout alone."""

    @abstractmethod
    def effect(self) -> Effect:
        """Effects of a press."""

    def press(
        self, _event: ControlEvent, _event_spec: EventSpec, _state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The effect."""
        return (self.effect(),)


class OrderWidget(PressWidget):
    """A widget with the same order to a robot for each press; without a robot, none."""

    @abstractmethod
    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """Effects of the order."""

    def press(
        self, _event: ControlEvent, _event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The order, if there is a robot to give it to."""
        robot = state.robot(self.robot)
        return () if robot is None else self.order(robot, state)
