"""Keys of holds, lights, arming, joints and trim."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest

from hub.gcm.body import (
    ROBOT_DESCRIPTION,
    Freedom,
    HoldBody,
    HoldKind,
    JointBody,
    LightBody,
    Motion,
    RobotBody,
)
from hub.gcm.geometry import TwistStamped
from hub.gcm.vehicle import (
    VEHICLE_STATE,
    Arming,
    HoldPhase,
    HoldState,
    LightState,
    VehicleCommand,
    VehicleOrder,
    VehicleState,
)
from rune_tui.layout.spec import EventSpec
from rune_tui.model.console_state import Banner, ConsoleState
from rune_tui.model.effects import ChooseRobot, Effect, Notify, SendEffect, TrimSpeed
from rune_tui.model.state_changes import changed
from rune_tui.visualizers.words.troubles import banner_of
from rune_tui.widgets.speed_rule import FREEDOMS
from rune_tui.widgets.vehicle import AGAIN_S
from tests.console.visualizers.conftest import Made, received
from tests.console.widgets.presses import again, down, event_spec, up, widget_of
from tests.support.car import CAR
from tests.support.messages import camera_state

UP, DOWN = event_spec("2"), event_spec("1", value=-1.0)
KEY = event_spec("x")
BODY = dataclasses.replace(
    CAR,
    motions=tuple(Motion(freedom=each, limit=1.0, acceleration=1.0) for each in Freedom),
    holds=(HoldBody(kind=HoldKind.DEPTH), HoldBody(kind=HoldKind.HEADING)),
    lights=(LightBody(name="headlight", camera="front"), LightBody(name="beacon")),
    joints=(JointBody(name="front", lowest=-1.0, highest=1.0, speed=0.5),),
    arms=1,
)
OFF = HoldState(kind=HoldKind.DEPTH)
HOLDING = HoldState(kind=HoldKind.DEPTH, phase=HoldPhase.HOLDING, target=1.0, error=0.0)


def state(
    vehicle: VehicleState | None = None, body: RobotBody = BODY, now: float = 1.0, **parts: Any
) -> ConsoleState:
    robot = Made().robot(**parts)
    messages = {**robot.messages, ROBOT_DESCRIPTION.name: received(body)}
    if vehicle is not None:
        messages[VEHICLE_STATE.name] = received(vehicle)
    robots = {"magellan": robot.with_(messages=messages)}
    return ConsoleState(now=now, robots=robots, chosen="magellan")


def orders(effects: tuple[Effect, ...]) -> list[VehicleCommand]:
    found = [effect.value for effect in effects if isinstance(effect, SendEffect)]
    assert all(isinstance(each, VehicleCommand) for each in found)
    return found  # type: ignore[return-value]


def pressed(handler: str, at: ConsoleState, **options: float | str) -> tuple[Effect, ...]:
    return widget_of(handler, "*", **options).handle(down("x"), KEY, at)


@pytest.mark.parametrize(
    ("known", "order"),
    [(None, VehicleOrder.HOLD), (OFF, VehicleOrder.HOLD), (HOLDING, VehicleOrder.RELEASE)],
)
def test_a_hold_is_switched(known: HoldState | None, order: VehicleOrder) -> None:
    vehicle = VehicleState(holds=(known,)) if known else None
    (command,) = orders(pressed("widgetHold", state(vehicle)))
    assert (command.order, command.hold) == (order, HoldKind.DEPTH)
    assert math.isnan(command.value), "where it is now"


def test_a_hold_that_the_body_lacks_is_said() -> None:
    (notice,) = pressed("widgetHold", state(), hold="position")
    assert isinstance(notice, Notify)
    assert "cannot hold its position" in notice.notice.text
    assert orders(pressed("widgetHold", state(body=CAR))) == []


def test_a_light_of_the_body_and_of_a_camera_are_switched_by_one_order() -> None:
    camera = received(dataclasses.replace(camera_state(headlight=0.5), name="front"))
    vehicle = VehicleState(lights=(LightState(name="beacon", brightness=0.0),))
    known = state(vehicle, camera=camera)
    (lit,) = orders(pressed("widgetLight", known, light="beacon", brightness=0.25))
    assert lit == VehicleCommand(order=VehicleOrder.LIGHT, name="beacon", value=0.25)
    (dark,) = orders(pressed("widgetLight", known))
    assert dark == VehicleCommand(order=VehicleOrder.LIGHT, name="headlight", value=0.0)
    assert orders(pressed("widgetLight", known, light="lamp")) == []
    assert orders(pressed("widgetLight", state(body=CAR))) == []


def test_arming_asks_first_and_disarming_does_not() -> None:
    disarmed = VehicleState(arming=Arming.DISARMED)
    widget = widget_of("widgetArm", "*")
    (asks,) = widget.handle(down("x"), KEY, state(disarmed))
    assert isinstance(asks, Notify)
    assert asks.notice.alarm
    assert orders(widget.handle(down("x"), KEY, state(disarmed, now=5.0))) == [], "too late"
    answer = widget.handle(down("x"), KEY, state(disarmed, now=6.0))
    (arm,) = orders(answer)
    assert arm.order is VehicleOrder.ARM
    (said,) = (effect for effect in answer if isinstance(effect, Notify))
    assert not said.notice.alarm, "the answer takes the question off the screen"
    assert orders(widget.handle(down("x"), KEY, state(disarmed, now=6.1))) == [], "asks anew"
    (disarm,) = orders(pressed("widgetDisarm", state(VehicleState(arming=Arming.ARMED))))
    assert disarm.order is VehicleOrder.DISARM


def test_a_quick_second_press_arms_and_a_held_key_does_not() -> None:
    disarmed = VehicleState(arming=Arming.DISARMED)
    widget = widget_of("widgetArm", "*")
    widget.handle(down("x"), KEY, state(disarmed))
    assert orders(widget.handle(again("x"), KEY, state(disarmed, now=1.2))) == []
    quick = dataclasses.replace(down("x"), second=True)
    (arm,) = orders(widget.handle(quick, KEY, state(disarmed, now=1.4)))
    assert arm.order is VehicleOrder.ARM


def test_a_quick_second_press_does_nothing_more_where_repeats_count() -> None:
    key = event_spec("x", "climb", 1.0)
    widget = widget_of("widgetTrim", "*")
    assert widget.handle(again("x"), key, state())
    assert widget.handle(dataclasses.replace(down("x"), second=True), key, state()) == ()


def test_a_question_goes_with_its_time_and_when_its_robot_is_left() -> None:
    disarmed = VehicleState(arming=Arming.DISARMED)
    widget = widget_of("widgetArm", "*")
    (asks,) = widget.handle(down("x"), KEY, state(disarmed))
    assert isinstance(asks, Notify)
    asked = changed(state(disarmed), asks)

    def shown(**changes: Any) -> Banner | None:
        return banner_of(dataclasses.replace(asked, **changes), {})

    assert shown() is not None
    assert shown(now=1.0 + AGAIN_S) is not None
    assert shown(now=1.1 + AGAIN_S) is None
    left = changed(dataclasses.replace(asked, now=1.5), ChooseRobot(robot="rover"))
    assert banner_of(left, {}) is None
    back = changed(dataclasses.replace(left, now=2.0), ChooseRobot(robot="magellan"))
    assert banner_of(back, {}) is None
    assert orders(widget.handle(down("x"), KEY, back)) == [], "it asks anew"


@pytest.mark.parametrize("handler", ["widgetArm", "widgetDisarm"])
def test_a_body_that_cannot_be_disarmed_is_sent_nothing(handler: str) -> None:
    widget = widget_of(handler, "*")
    for now in (1.0, 1.1):
        assert orders(widget.handle(down("x"), KEY, state(body=CAR, now=now))) == []


def test_only_disarming_may_be_sent_without_control() -> None:
    arm, disarm = (
        SendEffect(
            robot="magellan",
            definition=made.definition,
            value=VehicleCommand(order=order),
        )
        for made in (_command(),)
        for order in (VehicleOrder.ARM, VehicleOrder.DISARM)
    )
    assert arm.controlled == arm.takes_control * "magellan" == "magellan"
    assert disarm.controlled == ""
    assert not disarm.takes_control


def _command() -> SendEffect:
    (effect,) = (each for each in pressed("widgetLight", state()) if isinstance(each, SendEffect))
    return effect


def rates(effects: tuple[Effect, ...]) -> list[float]:
    found = orders(effects)
    assert {(each.order, each.name) for each in found} <= {(VehicleOrder.JOINT, "front")}
    return [each.value for each in found]


def test_a_held_key_turns_a_joint_and_its_release_stops_it() -> None:
    widget = widget_of("widgetJoint", "*")
    assert rates(widget.handle(down("2"), UP, state(now=0.0))) == [0.0, 0.5]
    assert rates(widget.tick(state(now=0.05))) == []
    assert rates(widget.tick(state(now=0.1))) == [0.5]
    assert rates(widget.handle(again("2"), UP, state(now=0.15))) == []
    assert rates(widget.handle(down("1"), DOWN, state(now=0.2))) == [-0.5], "the newest counts"
    assert rates(widget.handle(up("1"), DOWN, state(now=0.3))) == [0.5]
    assert rates(widget.handle(up("2"), UP, state(now=0.4))) == [0.0]
    assert rates(widget.tick(state(now=1.0))) == []


def test_after_all_was_released_a_joint_waits_for_a_new_press() -> None:
    widget = widget_of("widgetJoint", "*", share=0.5)
    assert rates(widget.handle(down("2"), UP, state(now=0.0))) == [0.0, 0.25]
    assert rates(widget.release(state(now=0.1))) == [0.0]
    assert rates(widget.handle(again("2"), UP, state(now=0.2))) == []
    assert rates(widget.tick(state(now=0.3))) == []


def test_a_joint_that_the_body_lacks_is_said_once() -> None:
    widget = widget_of("widgetJoint", "*", joint="rear")
    (notice,) = widget.handle(down("2"), UP, state())
    assert isinstance(notice, Notify)
    assert widget.tick(state(now=9.0)) == ()
    assert widget.handle(up("2"), UP, state()) == ()


def trimmed(at: ConsoleState, control: str, value: float) -> ConsoleState:
    key = event_spec("x", control, value)
    for effect in widget_of("widgetTrim", "*").handle(down("x"), key, at):
        at = changed(at, effect)  # type: ignore[arg-type]
    return at


def driven(at: ConsoleState, key: EventSpec) -> dict[str, float]:
    """The speed of each control that is not 0, while a key is held."""
    (effect,) = widget_of("widgetSetSpeed", "*").handle(down(key.name), key, at)
    assert isinstance(effect, SendEffect)
    assert isinstance(effect.value, TwistStamped)
    twist = effect.value.twist
    parts = (*dataclasses.astuple(twist.linear), *dataclasses.astuple(twist.angular))
    return {name: parts[freedom] for name, freedom in FREEDOMS.items() if parts[freedom]}


def test_a_trim_is_added_while_any_control_drives_and_never_at_rest() -> None:
    at = trimmed(trimmed(state(), "climb", 1.0), "climb", 1.0)
    assert at.trims == {"magellan": {"climb": pytest.approx(0.04)}}
    assert driven(at, event_spec("w", "translate")) == {"translate": 0.5, "climb": 0.04}
    (effect,) = widget_of("widgetSetSpeed", "*").tick(at)
    assert isinstance(effect, SendEffect)
    assert isinstance(effect.value, TwistStamped)
    assert effect.value.neutral
    at = trimmed(at, "climb", -1.0)
    assert trimmed(at, "climb", -1.0).trims == {"magellan": {"climb": 0.0}}
    assert trimmed(at, "reset", 1.0).trims == {"magellan": {}}


def test_a_trim_has_a_limit() -> None:
    at = changed(state(), TrimSpeed(robot="magellan", control="climb", change=9.0))
    assert at.trim("*") == {"climb": 0.3}


@pytest.mark.parametrize("control", FREEDOMS)
def test_the_speed_limit_holds_for_every_control(control: str) -> None:
    full = driven(state(), event_spec("w", control))
    limited = dataclasses.replace(state(), speed_limits={"magellan": 0.25})
    assert driven(limited, event_spec("w", control)) == {control: pytest.approx(full[control] / 4)}
