"""Widgets for what a vehicle has besides its motion: holds, lights, arming, joints, trim."""

from __future__ import annotations

import math
from typing import ClassVar, Final

from hub.gcm.autopilot import AutopilotPhase
from hub.gcm.body import ROBOT_DESCRIPTION, HoldKind, JointBody
from hub.gcm.joints import JOINT_STATES
from hub.gcm.vehicle import (
    VEHICLE_COMMAND,
    VEHICLE_STATE,
    Arming,
    HoldPhase,
    VehicleCommand,
    VehicleOrder,
)
from hub.gcm.vision import CAMERA_STATE
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import (
    ChoiceOption,
    HandlerRule,
    NumberOption,
    Purpose,
    Section,
    TextOption,
)
from rune_tui.layout.spec import ControlKind, EventSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, SendEffect, TrimSpeed
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import (
    VERTICAL,
    autopilot_of,
    brightness,
    hold_named,
    hold_state,
    light_named,
    vehicle_of,
)
from rune_tui.widgets.speed_rule import FREEDOMS
from rune_tui.widgets.widget import OrderWidget, PressWidget

AGAIN_S: Final = 3.0
"""Time in which a second press confirms that the robot shall be armed [s]."""
_PERIOD_S: Final = 0.1
"""Time between two orders to a joint that turns [s]."""
_SENDS = (VEHICLE_COMMAND.name,)
_HOLDS = (VERTICAL, *(each.name.lower() for each in HoldKind))


def _order(robot: RobotState, command: VehicleCommand) -> SendEffect:
    return SendEffect(robot=robot.name, definition=VEHICLE_COMMAND, value=command)


class HoldWidget(OrderWidget):
    """Switches a hold on, or off."""

    rule: ClassVar = HandlerRule(
        section=Section.DRIVE,
        says={"": "Hold: {hold}"},
        meaning=(
            "Switches a hold on or off: with it, the robot keeps its height, depth, heading or "
            "position by itself while you do not move it that way. Without it, the robot drifts."
        ),
        options={
            "hold": ChoiceOption(
                default=VERTICAL,
                choices=_HOLDS,
                words={VERTICAL: "height or depth"},
                meaning="what it keeps; vertical is the height or the depth, as the body has it",
            )
        },
        sends=_SENDS,
        uses=(VEHICLE_STATE.name, ROBOT_DESCRIPTION.name),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The other than now; on, if it is not known."""
        name = self.spec.options.word("hold")
        kind = hold_named(robot, name)
        if kind is None:
            wanted = "height or depth" if name == VERTICAL else name
            text = f"it cannot hold its {wanted}"
            return (Notify.now(state, text, robot=robot.name),)
        known = hold_state(robot, kind)
        on = known is not None and known.phase is not HoldPhase.OFF
        order = VehicleOrder.RELEASE if on else VehicleOrder.HOLD
        text = f"hold {kind.name.lower()}: {'off' if on else 'on'}"
        send = _order(robot, VehicleCommand(order=order, hold=kind))
        return (send, Notify.now(state, text, robot=robot.name))


class LightWidget(OrderWidget):
    """Switches a light on, or off."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Light on or off"},
        meaning="Switches a light of the robot on or off, that of a camera too.",
        options={
            "light": TextOption(longest=64, meaning="name of the light; empty: the first one"),
            "brightness": NumberOption(default=1.0, least=0.05, most=1.0, meaning="how bright"),
        },
        sends=_SENDS,
        uses=(VEHICLE_STATE.name, CAMERA_STATE.name, ROBOT_DESCRIPTION.name),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The other than now; on, if it is not known."""
        name = self.spec.options.word("light")
        light = light_named(robot, name)
        if light is None:
            text = f"it has no light{f' {name!r}' if name else ''}"
            return (Notify.now(state, text, robot=robot.name),)
        lit = brightness(robot, light) > 0.0
        value = 0.0 if lit else self.spec.options.number("brightness")
        command = VehicleCommand(order=VehicleOrder.LIGHT, name=light.name, value=value)
        return (_order(robot, command),)


class ArmWidget(OrderWidget):
    """Gives the motors power, after a second press."""

    rule: ClassVar = HandlerRule(
        section=Section.ROBOT,
        says={"": "Arm the motors: press twice"},
        meaning=(
            "Arms the motors of a robot that can be disarmed. It asks first: only a second press "
            f"within {AGAIN_S:.0f} s arms. Sticks and keys have to be let go before they drive."
        ),
        sends=_SENDS,
        uses=(VEHICLE_STATE.name, ROBOT_DESCRIPTION.name),
    )

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._asked = "", -math.inf

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The question, then the order."""
        if why := _why_no_arming(robot):
            return (Notify.now(state, why, robot=robot.name),)
        known = vehicle_of(robot)
        if known is not None and known.arming is Arming.ARMED:
            return (Notify.now(state, _armed_words(robot, state), robot=robot.name),)
        asked, since = self._asked
        left = state.looked.get(robot.name, -math.inf) >= since
        if asked != robot.name or left or state.now - since > AGAIN_S:
            self._asked = robot.name, state.now
            text = "ARM the motors? They can turn then: press again to arm"
            return (Notify.now(state, text, robot=robot.name, alarm=True, question_s=AGAIN_S),)
        self._asked = "", -math.inf
        send = _order(robot, VehicleCommand(order=VehicleOrder.ARM))
        return (send, Notify.now(state, "the motors shall be armed", robot=robot.name))


class DisarmWidget(OrderWidget):
    """Takes the power from the motors, at once."""

    rule: ClassVar = HandlerRule(
        purpose=Purpose.DISARM,
        section=Section.ROBOT,
        says={"": "Disarm the motors"},
        meaning=(
            "Disarms the motors at once, even if another operator has control: a blimp sinks "
            "then, an underwater robot rises."
        ),
        under_help=True,
        sends=_SENDS,
        uses=(VEHICLE_STATE.name, ROBOT_DESCRIPTION.name),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The order, or why there is nothing to disarm."""
        if why := _why_no_arming(robot):
            return (Notify.now(state, why, robot=robot.name),)
        send = _order(robot, VehicleCommand(order=VehicleOrder.DISARM))
        return (send, Notify.now(state, "motors off", robot=robot.name))


def _armed_words(robot: RobotState, state: ConsoleState) -> str:
    """That it is armed, and the key that asks its autopilot to follow, if it does not."""
    autopilot, key = autopilot_of(robot), state.input_of(Purpose.FOLLOW, robot.name)
    follows = autopilot is None or autopilot.phase is AutopilotPhase.DRIVING
    return "it is armed already" + ("" if follows or not key else f": {key} asks it to follow you")


def _why_no_arming(robot: RobotState) -> str:
    arms = robot.body is not None and robot.body.arms
    return "" if arms else "it cannot be armed or disarmed"


class JointWidget(PressWidget):
    """Turns a joint while an input is held."""

    rule: ClassVar = HandlerRule(
        section=Section.DRIVE,
        says={"": "Move {joint} {direction}"},
        meaning=(
            "Turns a joint of the robot, such as a pair of flippers, while it is held; positive is "
            "up. The robot stops it when you let go, or when orders end. With several inputs the "
            "newest counts."
        ),
        options={
            "joint": TextOption(
                longest=64,
                unnamed="the first joint",
                meaning="name of the joint; empty: the first one",
            ),
            "share": NumberOption(
                default=1.0, least=0.05, most=1.0, meaning="share of its largest turn rate"
            ),
        },
        sends=_SENDS,
        uses=(JOINT_STATES.name, ROBOT_DESCRIPTION.name),
        words={"": ("up", "down")},
        held=True,
    )

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._held: dict[EventSpec, float] = {}
        """The inputs that count, with their shares, -1 to 1, the newest last."""
        self._moving: tuple[str, str] | None = None
        """Robot and joint that turn."""
        self._due = -math.inf

    def handle(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """An order at each change."""
        known = self._held.pop(event_spec, None) is not None
        if not event.pressed:
            return self._ordered(state) if known else ()
        if event.repeat and not known:
            return ()  # it was held before all was released
        value = event.value if event_spec.kind is ControlKind.AXIS else 1.0
        self._held[event_spec] = event_spec.value * value * (0.3 if event.fine else 1.0)
        return () if event.repeat else self._ordered(state)

    def press(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The same as any change."""
        return self.handle(event, event_spec, state)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """The order again while an input is held."""
        return self._ordered(state) if self._held and state.now >= self._due else ()

    def release(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Stop the joint; inputs must be released first."""
        self._held.clear()
        return self._ordered(state)

    def _ordered(self, state: ConsoleState) -> tuple[Effect, ...]:
        """The order for the inputs that are held; the first one is 0, which the robot waits for."""
        robot = state.robot(self.robot)
        joint = self._joint(robot)
        if robot is None or joint is None:
            fresh = bool(self._held) and robot is not None
            self._held.clear()
            return (self._none(robot, state),) if fresh and robot is not None else ()
        self._due = state.now + _PERIOD_S
        share = max(-1.0, min(1.0, next(reversed(self._held.values()), 0.0)))
        rate = share * joint.speed * self.spec.options.number("share")
        before, self._moving = self._moving, (robot.name, joint.name) if rate else None
        if self._moving is None:
            return () if before is None else (_turn(*before, 0.0),)
        first = () if before == self._moving else (_turn(*self._moving, 0.0),)
        return (*first, _turn(*self._moving, rate))

    def _joint(self, robot: RobotState | None) -> JointBody | None:
        joints = robot.body.joints if robot is not None and robot.body is not None else ()
        name = self.spec.options.word("joint")
        return next((each for each in joints if name in ("", each.name)), None)

    def _none(self, robot: RobotState, state: ConsoleState) -> Notify:
        name = self.spec.options.word("joint")
        text = f"it has no joint{f' {name!r}' if name else ''}"
        return Notify.now(state, text, robot=robot.name)


def _turn(robot: str, joint: str, rate: float) -> SendEffect:
    command = VehicleCommand(order=VehicleOrder.JOINT, name=joint, value=rate)
    return SendEffect(robot=robot, definition=VEHICLE_COMMAND, value=command)


class TrimWidget(PressWidget):
    """Changes the trim of a control."""

    rule: ClassVar = HandlerRule(
        section=Section.DRIVE,
        says={
            "reset": "No trim any more",
            **{control: f"Trim {control} {{direction}}" for control in FREEDOMS},
        },
        meaning=(
            "Trims a control of `widgetSetSpeed`: a small velocity that is added while you drive "
            "any control of the robot, against a draft, a current or a crooked wheel. At rest "
            "nothing is added, and steps of keys keep their way. `reset` ends all trims."
        ),
        controls=(*FREEDOMS, "reset"),
        options={
            "step": NumberOption(
                default=0.02, least=0.001, most=0.1, unit="m/s or rad/s", meaning="change a press"
            )
        },
        words={
            "translate": ("forward", "backward"),
            "rotate": ("left", "right"),
            "climb": ("up", "down"),
            "strafe": ("left", "right"),
            "pitch": ("nose down", "nose up"),
            "roll": ("right side down", "left side down"),
        },
    )
    repeats: ClassVar[bool] = True

    def press(
        self, _event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The change, and the trim that it makes."""
        robot = state.robot(self.robot)
        if robot is None:
            return ()
        if event_spec.control == "reset":
            text = "no trim"
            return (TrimSpeed(robot=robot.name), Notify.now(state, text, robot=robot.name))
        change = event_spec.value * self.spec.options.number("step")
        trim = state.trim(robot.name).get(event_spec.control, 0.0) + change
        text = f"trim {event_spec.control} {trim:+.3g}"
        effect = TrimSpeed(robot=robot.name, control=event_spec.control, change=change)
        return (effect, Notify.now(state, text, robot=robot.name))
