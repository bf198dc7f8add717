"""Widgets that drive: velocity from held keys and sticks, and the stop.

| event | terminal reports releases | terminal does not |
| --- | --- | --- |
| press of a key | drive until the release | drive a step |
| repeat | go on | drive until the repeats end |
| release | stand | stand |
| an axis moves, after it was neutral | drive by its value | the same |
| an axis was deflected at a release of all input | wait until all such are neutral | the same |
| the dead-man button is up | axes do not count | the same |
| input that must be released first, or is stale | ignore it | the same |

A control that the robot's body does not have drives nothing, and a press of it says so. The trim
of the robot's controls is added while any of them drives; it does not change steps.

A step is a distance: velocity times time, at the step's own low velocity. The speed limit of the
robot holds for steps, keys and sticks. Shift makes steps shorter and driving slower.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import ClassVar, Final, Self

from hub.gcm.body import Freedom, RobotBody
from hub.gcm.geometry import Twist, TwistStamped, Vector3
from hub.gcm.navigation import STOP, VELOCITY_COMMAND, Stop
from hub.values import dataclass
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.names import joystick_input
from rune_tui.layout.rules import HandlerRule, Purpose, Section
from rune_tui.layout.spec import CHOSEN, ControlKind, EventSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, SendEffect
from rune_tui.widgets.speed_rule import (
    ENABLE,
    FREEDOMS,
    ROTATE,
    SPEED_RULE,
    TRANSLATE,
    TURBO,
    WHEELED,
)
from rune_tui.widgets.widget import PressWidget

ACTIVE_PERIOD_S = 0.05
NEUTRAL_PERIOD_S = 0.2
STEP_S: Final = 0.35
"""How long a step takes [s], unless the speed limit makes it slower."""
_EARLY_S = 0.025
"""A tick this much too early counts, half of the time between two ticks [s]."""
_LEAST_PERIOD_S = 0.02
"""Shortest time between two commands for the movement of a stick [s]."""


@dataclass(slots=True)
class _Step:
    """A step that a key drives.

    Attributes:
        left: How much of it is left to be commanded [m or rad].
        speed: How fast it goes [m/s or rad/s].
        commanded: The speed that was commanded last [m/s or rad/s].
    """

    left: float
    speed: float
    commanded: float = 0.0


class SetSpeed:
    """Turns keys and sticks into velocity: a command at each change, then at a steady rate.

    Each control (translate, rotate) follows its newest input that is not neutral, so of two
    opposite keys the newer one wins. See the table of the module for keys.

    An axis counts when it leaves neutral. An axis waits if it was deflected when all input was
    released, when its device appeared, or while the dead-man button was up. While one axis waits,
    no other begins to count. So a small sideways motion of a stick that is still held forward
    does not drive either.
    """

    rule: ClassVar = SPEED_RULE

    def __init__(
        self,
        robot: str,
        *,
        linear: float,
        angular: float,
        strafe: float = 0.0,
        climb: float = 0.0,
        tilt: float = 0.0,
        turbo: float = 1.0,
        guarded: bool = False,
        axes: Iterable[EventSpec] = (),
        step: float = 0.0,
        turn_step: float = 0.0,
        fine: float = 1.0,
    ) -> None:
        """Drive a robot.

        Args:
            robot: Its name in the layout.
            linear: Forward velocity at value 1 [m/s].
            angular: Turn rate at value 1 [rad/s], counter-clockwise.
            strafe: Velocity to the left at value 1 [m/s]; 0: that of `linear`.
            climb: Upward velocity at value 1 [m/s].
            tilt: Rate of pitch and roll at value 1 [rad/s].
            turbo: Factor of the velocity while turbo is held.
            guarded: Whether axes count only while a dead-man button is held.
            axes: The axes that may drive.
            step: Length of a step [m]; 0: no steps.
            turn_step: Turn of a step [rad]; 0: no steps.
            fine: Share of steps and velocity with Shift.
        """
        self.robot = robot
        self._speeds = {
            TRANSLATE: linear,
            "strafe": strafe or linear,
            "climb": climb,
            "pitch": tilt,
            "roll": tilt,
            ROTATE: angular,
        }
        self._turbo = turbo
        self._guarded = guarded
        self._axes = frozenset(axis.name for axis in axes)
        self._step_sizes = {
            control: step if freedom <= Freedom.HEAVE else turn_step
            for control, freedom in FREEDOMS.items()
        }
        self._fine = fine
        self._limit = 1.0
        self._trims: Mapping[str, float] = {}
        self._body: RobotBody | None = None
        self._held: dict[EventSpec, float] = {}
        """The inputs that count, with their shares, -1 to 1, the newest last."""
        self._steps: dict[EventSpec, _Step] = {}
        """Of keys that count and have not repeated yet."""
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
            strafe=spec.options.number("strafe"),
            climb=spec.options.number("climb"),
            tilt=spec.options.number("tilt"),
            turbo=spec.options.number("turbo_factor"),
            guarded=any(event.control == ENABLE for event in spec.events),
            axes=[event for event in spec.events if event.kind is ControlKind.AXIS],
            step=spec.options.number("step"),
            turn_step=math.radians(spec.options.number("turn_step_deg")),
            fine=spec.options.number("fine"),
        )

    def forget(self) -> None:
        """Forget held inputs, without an event.

        Repeats of keys no longer drive, only a new press does; axes have to be neutral first.
        """
        self._wait_for_neutral()
        self._held.clear()
        self._steps.clear()

    def accepts(self, event_spec: EventSpec, state: ConsoleState) -> bool:
        """Whether this input would drive if it left neutral now."""
        if event_spec.kind is not ControlKind.AXIS:
            return True
        if self._guarded and not self._holds(ENABLE):
            return False
        unseen = (
            joystick_input(joystick.name, axis)
            for joystick in state.joysticks.values()
            for axis in joystick.waiting
        )
        return self._waiting <= {event_spec} and self._axes.isdisjoint(unseen)

    def velocity(self) -> Twist:
        """The command of the held inputs; what they drive is trimmed, neutral is not."""
        newest = {spec.control: spec for spec in self._held}
        speeds = dict.fromkeys(FREEDOMS, 0.0)
        for control in FREEDOMS.keys() & newest:
            speeds[control] = self._speed(newest[control])
        if any(speeds.values()) and not self._steps:
            for control, trim in self._trims.items():
                most = self._most(control)
                speeds[control] = max(-most, min(most, speeds[control] + trim))
        return Twist(
            linear=Vector3(x=speeds[TRANSLATE], y=speeds["strafe"], z=speeds["climb"]),
            angular=Vector3(x=speeds["roll"], y=speeds["pitch"], z=speeds[ROTATE]),
        )

    def _speed(self, spec: EventSpec) -> float:
        """The command of an input [m/s or rad/s]."""
        if (step := self._steps.get(spec)) is not None:
            return step.commanded
        factor = self._turbo if self._holds(TURBO) else 1.0
        most = self._most(spec.control)
        return max(-most, min(most, self._held[spec] * factor * self._full(spec)))

    def _full(self, spec: EventSpec) -> float:
        """The speed at value 1 within the speed limit [m/s or rad/s]."""
        return self._limit * min(self._speeds[spec.control], self._most(spec.control))

    def _most(self, control: str) -> float:
        """The largest speed of a control on the robot's body [m/s or rad/s]; 0: it has none."""
        if control in WHEELED:
            return math.inf
        motions = self._body.motions if self._body is not None else ()
        limits = (each.limit for each in motions if each.freedom is FREEDOMS[control])
        return next(limits, 0.0)

    def _look(self, state: ConsoleState) -> None:
        """Take the limits of the robot and its body."""
        robot = state.robot(self.robot)
        self._limit = state.speed_limit(self.robot)
        self._trims = state.trim(self.robot)
        self._body = robot.body if robot is not None else None

    def handle(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The new velocity, at once unless a stick moves; nothing for input that does not count."""
        self._look(state)
        control = event_spec.control
        if event.pressed and control in FREEDOMS and not self._most(control):
            return () if event.repeat else self._refused(control, state)
        if event_spec.kind is ControlKind.AXIS and event.pressed:
            return self._deflected(event, event_spec, state)
        if event.pressed and event.repeat:
            stepped = self._steps.pop(event_spec, None) is not None
            return self._send(state.now) if stepped else ()
        self._waiting.discard(event_spec)
        self._steps.pop(event_spec, None)
        known = self._held.pop(event_spec, None) is not None
        if event.pressed:
            self._press(event, event_spec)
        elif not known:
            return ()
        elif event_spec.control == ENABLE and not self._holds(ENABLE):
            self._wait_for_neutral()
        return self._send(state.now)

    def _refused(self, control: str, state: ConsoleState) -> tuple[Effect, ...]:
        """Say that a control drives nothing on this robot."""
        robot = state.robot(self.robot)
        if robot is None:
            return ()
        why = "its body has no such motion" if self._body is not None else "its body is not known"
        text = f"{control} does nothing: {why}"
        return (Notify.now(state, text, robot=robot.name),)

    def _press(self, event: ControlEvent, event_spec: EventSpec) -> None:
        share = event_spec.value * (self._fine if event.fine else 1.0)
        self._held[event_spec] = share
        size = abs(share) * self._step_sizes.get(event_spec.control, 0.0)
        if event.timed and size:
            self._steps[event_spec] = _Step(left=size, speed=math.copysign(size / STEP_S, share))

    def _deflected(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        known, now = event_spec in self._held, state.now
        if not known and (event.repeat or not self.accepts(event_spec, state)):
            self._waiting.add(event_spec)
            return ()
        if not event.repeat:
            self._waiting.discard(event_spec)
            self._held.pop(event_spec, None)
        self._held[event_spec] = event_spec.value * event.value
        if event.repeat and now - self._sent < _LEAST_PERIOD_S:
            self._due = now  # the next tick sends it
            return ()
        return self._send(now)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """The velocity again if it is time: 20 times a second while it drives, else 5 times."""
        self._look(state)
        late = state.now - self._due
        if late < -_EARLY_S:
            return ()
        effects = self._send(state.now)
        if late < self._due - state.now:
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

    def _go_on(self, seconds: float) -> None:
        """Count the steps commanded in this time; command at most the rest of them."""
        for spec, step in self._steps.items():
            if step.commanded:
                step.left = max(0.0, step.left - abs(step.commanded) * seconds)
            most = min(abs(step.speed), abs(self._full(spec)), step.left / ACTIVE_PERIOD_S)
            step.commanded = math.copysign(most, step.speed)

    def _send(self, now: float) -> tuple[Effect, ...]:
        self._go_on(now - self._sent)
        self._sent = now
        velocity = self.velocity()
        self._due = now + (NEUTRAL_PERIOD_S if velocity.neutral else ACTIVE_PERIOD_S)
        command = TwistStamped.of(velocity)
        return (SendEffect(robot=self.robot, definition=VELOCITY_COMMAND, value=command),)


class StopRobot(PressWidget):
    """Stops a robot; dispatch then releases the robot's other widgets."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.STOP,
        section=Section.DRIVE,
        says={"": "Stop"},
        meaning=(
            "Stops the robot at once. Keys that are still held no longer drive; press them again. "
            "A stick has to be let go first."
        ),
        sends=("GCM_Stop",),
        under_help=True,
    )
    repeats: ClassVar[bool] = True

    def press(
        self, event: ControlEvent, _event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Stops the robot at every press and repeat: fast presses look like repeats.

        A stop of the chosen robot also stops the one that the operator peeks at.
        """
        reason = f"{state.operator or 'the operator'} pressed {event.name}"
        robots = [self.robot]
        if self.robot == CHOSEN and state.peeked:
            robots.append(state.peeked)
        return tuple(
            SendEffect(robot=robot, definition=STOP, value=Stop(reason=reason)) for robot in robots
        )
