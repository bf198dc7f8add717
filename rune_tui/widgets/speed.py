"""Widgets that drive: speed while keys are held, and the stop."""

from __future__ import annotations

from typing import ClassVar, Self

from hub.gcm.navigation import STOP, VELOCITY_COMMAND, Stop, Twist
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import HandlerRule, NumberOption
from rune_tui.layout.spec import EventSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, SendEffect
from rune_tui.widgets.widget import PressWidget

ACTIVE_PERIOD_S = 0.05
NEUTRAL_PERIOD_S = 0.2
_EARLY_S = 0.025
"""A tick this much too early counts, half of the time between two ticks [s]."""


class SetSpeed:
    """Keys to velocity: a command at each change, then at a steady rate, slower while neutral.

    Each control (translate, rotate) follows the newest of its keys that are held, so of two
    opposed keys the newest wins.
    """

    rule: ClassVar = HandlerRule(
        meaning=(
            "Drives while keys are held. Positive `translate` is forward, positive `rotate` "
            "counter-clockwise (to the left). Each control follows the newest of its keys that are "
            "held."
        ),
        controls=("translate", "rotate"),
        options={
            "linear": NumberOption(
                default=0.5, least=0.0, most=10.0, unit="m/s", meaning="speed at value 1"
            ),
            "angular": NumberOption(
                default=1.0, least=0.0, most=10.0, unit="rad/s", meaning="turn rate at value 1"
            ),
        },
        sends=("GCM_Velocity_Command",),
        words={"translate": ("forward", "backward"), "rotate": ("left", "right")},
        held=True,
    )

    def __init__(self, robot: str, *, linear: float, angular: float) -> None:
        """Drive a robot.

        Args:
            robot: Its name in the layout.
            linear: Forward speed at value 1 [m/s].
            angular: Turn rate at value 1 [rad/s], counter-clockwise.
        """
        self.robot = robot
        self._linear = linear
        self._angular = angular
        self._held: list[EventSpec] = []
        self._due = 0.0

    @classmethod
    def from_spec(cls, spec: WidgetSpec, robot: str) -> Self:
        """The widget that a layout describes."""
        return cls(
            robot, linear=spec.options.number("linear"), angular=spec.options.number("angular")
        )

    def forget(self) -> None:
        """Forget held keys without a word; their repeats no longer drive, only a new press does."""
        self._held.clear()

    def velocity(self) -> Twist:
        """What the held keys command."""
        newest = {spec.control: spec.value for spec in self._held}
        return Twist.planar(
            newest.get("translate", 0.0) * self._linear, newest.get("rotate", 0.0) * self._angular
        )

    def handle(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The new velocity, at once; nothing for repeats and for keys that no longer count."""
        if event.repeat:
            return ()
        known = event_spec in self._held
        if known:
            self._held.remove(event_spec)
        if event.pressed:
            self._held.append(event_spec)
        elif not known:
            return ()
        return self._send(state.now)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """The velocity again if it is time: 20 times a second while a key is held, else 5 times."""
        late = state.now - self._due
        if late < -_EARLY_S:
            return ()
        effects = self._send(state.now)
        if late < self._period():
            # Counted on from when it was due, so that a jittering clock does not lower the rate.
            self._due -= late
        return effects

    def release(self, state: ConsoleState) -> tuple[Effect, ...]:
        """One zero velocity, whether or not a key was held."""
        self.forget()
        return self._send(state.now)

    def _period(self) -> float:
        return NEUTRAL_PERIOD_S if self.velocity().neutral else ACTIVE_PERIOD_S

    def _send(self, now: float) -> tuple[Effect, ...]:
        self._due = now + self._period()
        return (SendEffect(robot=self.robot, definition=VELOCITY_COMMAND, value=self.velocity()),)


class StopRobot(PressWidget):
    """Stops a robot; dispatch then releases the robot's other widgets."""

    rule: ClassVar = HandlerRule(
        meaning=(
            "Stops the robot at once. Keys that are still held no longer drive; press them anew."
        ),
        sends=("GCM_Stop",),
        under_help=True,
    )
    repeats: ClassVar[bool] = True

    def press(
        self,
        event: ControlEvent,
        event_spec: EventSpec,
        state: ConsoleState,  # noqa: ARG002 - a stop is a stop at any time
    ) -> tuple[Effect, ...]:
        """A stop for every press; a hammered key looks like repeats, so they count as well."""
        reason = f"the operator pressed {event.name} (layout line {event_spec.line})"
        return (SendEffect(robot=self.robot, definition=STOP, value=Stop(reason=reason)),)
