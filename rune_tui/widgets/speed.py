"""Widgets that drive: speed while keys are held or sticks are moved, and the stop."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import ClassVar, Self

from hub.gcm.navigation import ROBOT_STATE, STOP, VELOCITY_COMMAND, Stop, Twist
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.names import joystick_input
from rune_tui.layout.rules import HandlerRule, NumberOption, Section
from rune_tui.layout.spec import ControlKind, EventSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, SendEffect
from rune_tui.widgets.widget import PressWidget

ACTIVE_PERIOD_S = 0.05
NEUTRAL_PERIOD_S = 0.2
_EARLY_S = 0.025
"""A tick this much too early counts, half of the time between two ticks [s]."""
_LEAST_PERIOD_S = 0.02
"""How soon after a command the next movement of a stick is worth another one [s]."""
_ENABLE = "enable"
_TURBO = "turbo"


class SetSpeed:
    """Keys and sticks to velocity: a command at each change, then at a steady rate.

    Each control (translate, rotate) follows the newest of its inputs that are not neutral, so of
    two opposed keys the newest wins.

    An axis counts from the moment it leaves neutral. One that was deflected already, when what is
    held was forgotten, while the dead-man button was up or when its device appeared, waits; while
    any waits, none begins to count. So nothing drives before all of them have been neutral: not the
    wobble aside of a stick that is still held forward, either.
    """

    rule: ClassVar = HandlerRule(
        section=Section.DRIVE,
        says={
            "translate": "Drive {direction}",
            "rotate": "Turn {direction}",
            _ENABLE: "Hold it: sticks drive",
            _TURBO: "Hold it: faster",
        },
        meaning=(
            "Drives while held; positive `translate` is forward, positive `rotate` is "
            "counter-clockwise (to the left). Each control follows the newest of its keys, buttons "
            "and axes that is not neutral. Where `enable` is bound, axes count only while it is "
            "held; while `turbo` is held, all is faster."
        ),
        controls=("translate", "rotate", _ENABLE, _TURBO),
        options={
            "linear": NumberOption(
                default=0.5, least=0.0, most=10.0, unit="m/s", meaning="speed at value 1"
            ),
            "angular": NumberOption(
                default=1.0, least=0.0, most=10.0, unit="rad/s", meaning="turn rate at value 1"
            ),
            "turbo_factor": NumberOption(
                default=2.0, least=1.0, most=10.0, meaning="how many times faster turbo is"
            ),
        },
        sends=("GCM_Velocity_Command",),
        uses=(ROBOT_STATE.name,),
        words={"translate": ("forward", "backward"), "rotate": ("left", "right")},
        plane=("rotate", "translate"),
        held=True,
    )

    def __init__(
        self,
        robot: str,
        *,
        linear: float,
        angular: float,
        turbo: float = 1.0,
        guarded: bool = False,
        axes: Iterable[EventSpec] = (),
    ) -> None:
        """Drive a robot.

        Args:
            robot: Its name in the layout.
            linear: Forward speed at value 1 [m/s].
            angular: Turn rate at value 1 [rad/s], counter-clockwise.
            turbo: How many times faster it is while turbo is held.
            guarded: Whether there is a dead-man button, without which axes do not count.
            axes: All that may drive.
        """
        self.robot = robot
        self._linear = linear
        self._angular = angular
        self._turbo = turbo
        self._guarded = guarded
        self._axes = tuple(axes)
        self._held: dict[EventSpec, float] = {}
        """What counts and its share, -1 to 1, the newest last."""
        self._waiting: set[EventSpec] = set()
        """Axes that are not neutral and do not count."""
        self._sent = -math.inf
        self._due = 0.0

    @classmethod
    def from_spec(cls, spec: WidgetSpec, robot: str) -> Self:
        """The widget that a layout describes."""
        return cls(
            robot,
            linear=spec.options.number("linear"),
            angular=spec.options.number("angular"),
            turbo=spec.options.number("turbo_factor"),
            guarded=any(event.control == _ENABLE for event in spec.events),
            axes=[event for event in spec.events if event.kind is ControlKind.AXIS],
        )

    def forget(self) -> None:
        """Forget what is held without a word.

        Repeats of keys no longer drive, only a new press does; axes have to be neutral first.
        """
        self._wait_for_neutral()
        self._held.clear()

    def heeds(self, event_spec: EventSpec, state: ConsoleState) -> bool:
        """Whether it would count if this input left neutral now."""
        if event_spec.kind is not ControlKind.AXIS:
            return True
        if self._guarded and not self._holds(_ENABLE):
            return False
        unseen = {
            joystick_input(joystick.name, axis)
            for joystick in state.joysticks.values()
            for axis in joystick.waiting
        }
        return self._waiting <= {event_spec} and not any(axis.name in unseen for axis in self._axes)

    def velocity(self) -> Twist:
        """What the held inputs command."""
        newest = {spec.control: share for spec, share in self._held.items()}
        factor = self._turbo if self._holds(_TURBO) else 1.0
        return Twist.planar(
            newest.get("translate", 0.0) * factor * self._linear,
            newest.get("rotate", 0.0) * factor * self._angular,
        )

    def handle(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The new velocity, at once unless a stick moves on; nothing for what does not count."""
        if event_spec.kind is ControlKind.AXIS and event.pressed:
            return self._deflected(event, event_spec, state)
        if event.pressed and event.repeat:
            return ()
        self._waiting.discard(event_spec)
        known = self._held.pop(event_spec, None) is not None
        if event.pressed:
            self._held[event_spec] = event_spec.value
        elif not known:
            return ()
        elif event_spec.control == _ENABLE and not self._holds(_ENABLE):
            self._wait_for_neutral()
        return self._send(state.now)

    def _deflected(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        known, now = event_spec in self._held, state.now
        if not known and (event.repeat or not self.heeds(event_spec, state)):
            self._waiting.add(event_spec)
            return ()
        if not event.repeat:
            self._waiting.discard(event_spec)
            self._held.pop(event_spec, None)
        self._held[event_spec] = event_spec.value * event.value
        if event.repeat and now - self._sent < _LEAST_PERIOD_S:
            self._due = now  # the next tick has it
            return ()
        return self._send(now)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """The velocity again if it is time: 20 times a second while it drives, else 5 times."""
        late = state.now - self._due
        if late < -_EARLY_S:
            return ()
        effects = self._send(state.now)
        if late < self._period():
            # Counted on from when it was due, so that a jittering clock does not lower the rate.
            self._due -= late
        return effects

    def release(self, state: ConsoleState) -> tuple[Effect, ...]:
        """One zero velocity, whether or not anything was held."""
        self.forget()
        return self._send(state.now)

    def _wait_for_neutral(self) -> None:
        """From now on, axes that are not neutral do not count."""
        axes = [spec for spec in self._held if spec.kind is ControlKind.AXIS]
        self._waiting.update(axes)
        for spec in axes:
            del self._held[spec]

    def _holds(self, control: str) -> bool:
        return any(spec.control == control for spec in self._held)

    def _period(self) -> float:
        return NEUTRAL_PERIOD_S if self.velocity().neutral else ACTIVE_PERIOD_S

    def _send(self, now: float) -> tuple[Effect, ...]:
        self._sent = now
        self._due = now + self._period()
        return (SendEffect(robot=self.robot, definition=VELOCITY_COMMAND, value=self.velocity()),)


class StopRobot(PressWidget):
    """Stops a robot; dispatch then releases the robot's other widgets."""

    rule: ClassVar = HandlerRule(
        section=Section.DRIVE,
        says={"": "Stop"},
        meaning=(
            "Stops the robot at once. Keys that are still held no longer drive; press them anew. "
            "A stick has to be let go first."
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
