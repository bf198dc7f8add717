"""widgetSetSpeed on bodies that climb, strafe, pitch and roll, and on those that do not."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from hub.gcm.body import ROBOT_DESCRIPTION, Freedom, Motion, RobotBody
from hub.gcm.geometry import Twist, TwistStamped, Vector3
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.spec import ControlKind, EventSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, SendEffect
from tests.console.visualizers.conftest import Made, received
from tests.console.widgets.presses import again, down, event_spec, up, widget_of
from tests.support.car import CAR

LIMIT = 0.2
BODY = dataclasses.replace(
    CAR,
    motions=tuple(Motion(freedom=each, limit=LIMIT, acceleration=1.0) for each in Freedom),
)
PARTS = {
    "strafe": Twist(linear=Vector3(y=0.1)),
    "climb": Twist(linear=Vector3(z=0.1)),
    "roll": Twist(angular=Vector3(x=0.1)),
    "pitch": Twist(angular=Vector3(y=0.1)),
}
OPTIONS = {"linear": 0.1, "climb": 0.1, "tilt": 0.1}


def state(body: RobotBody | None = BODY, now: float = 1.0, **changes: Any) -> ConsoleState:
    robot = Made().robot()
    known = {name: each for name, each in robot.messages.items() if name != ROBOT_DESCRIPTION.name}
    if body is not None:
        known[ROBOT_DESCRIPTION.name] = received(body)
    return ConsoleState(now=now, robots={"magellan": robot.with_(messages=known)}, **changes)


def sent(effects: tuple[Effect, ...]) -> Twist:
    (effect,) = effects
    assert isinstance(effect, SendEffect)
    value = effect.value
    assert isinstance(value, TwistStamped)
    return value.twist


@pytest.mark.parametrize(
    ("control", "freedom"),
    [
        ("strafe", Freedom.SWAY),
        ("climb", Freedom.HEAVE),
        ("roll", Freedom.ROLL),
        ("pitch", Freedom.PITCH),
    ],
)
def test_each_control_drives_its_own_part_while_it_is_held(control: str, freedom: Freedom) -> None:
    only = tuple(each for each in BODY.motions if each.freedom is freedom)
    body = dataclasses.replace(BODY, motions=only)
    widget, key = widget_of("widgetSetSpeed", **OPTIONS), event_spec("x", control)
    assert sent(widget.handle(down("x"), key, state(body))) == PARTS[control]
    assert sent(widget.tick(state(body, now=1.05))) == PARTS[control]
    assert sent(widget.handle(up("x"), key, state(body, now=1.1))) == Twist()


@pytest.mark.parametrize("control", PARTS)
def test_neither_the_layout_nor_turbo_drives_faster_than_the_body_can(control: str) -> None:
    widget, key = widget_of("widgetSetSpeed", linear=5.0, climb=5.0, tilt=5.0), event_spec("x")
    key = dataclasses.replace(key, control=control)
    twist = sent(widget.handle(down("x"), key, state()))
    parts = [getattr(part, axis) for part in (twist.linear, twist.angular) for axis in "xyz"]
    assert sorted(parts) == [0.0] * 5 + [LIMIT]
    widget.handle(down("t"), event_spec("t", "turbo"), state())
    assert sent(widget.tick(state(now=1.5))) == twist


def test_the_speed_limit_holds_for_a_climb() -> None:
    widget, key = widget_of("widgetSetSpeed", **OPTIONS), event_spec("x", "climb")
    slow = state(speed_limits={"magellan": 0.5})
    assert sent(widget.handle(down("x"), key, slow)).linear.z == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (CAR, "climb does nothing: its body has no such motion"),
        (None, "climb does nothing: its body is not known"),
    ],
)
def test_a_control_that_the_body_does_not_have_drives_nothing_and_says_so(
    body: RobotBody | None, words: str
) -> None:
    widget, key = widget_of("widgetSetSpeed", **OPTIONS), event_spec("x", "climb")
    (notice,) = widget.handle(down("x"), key, state(body))
    assert isinstance(notice, Notify)
    assert notice.notice.text == words
    assert widget.handle(again("x"), key, state(body, now=1.1)) == ()
    assert sent(widget.tick(state(body, now=1.5))) == Twist()
    assert widget.handle(up("x"), key, state(body, now=1.6)) == ()
    # Nor does what was pressed then drive once the body is known.
    assert sent(widget.tick(state(now=2.0))) == Twist()


@pytest.mark.parametrize("control", PARTS)
def test_after_a_stop_a_key_has_to_be_pressed_anew_and_a_stick_let_go_first(control: str) -> None:
    widget, key = widget_of("widgetSetSpeed", **OPTIONS), event_spec("x", control)
    stick = EventSpec(
        name="joystick pad righty", control=control, value=1.0, line=1, kind=ControlKind.AXIS
    )

    def moved(value: float, *, repeat: bool) -> ControlEvent:
        return ControlEvent(name=stick.name, pressed=bool(value), repeat=repeat, value=value)

    widget.handle(down("x"), key, state())
    widget.handle(moved(1.0, repeat=False), stick, state(now=1.1))
    assert sent(widget.release(state(now=1.2))) == Twist()
    widget.handle(again("x"), key, state(now=1.3))
    widget.handle(moved(0.9, repeat=True), stick, state(now=1.4))
    assert sent(widget.tick(state(now=2.0))) == Twist()
    widget.handle(moved(0.0, repeat=True), stick, state(now=2.1))
    assert sent(widget.handle(moved(1.0, repeat=False), stick, state(now=2.2))) == PARTS[control]


def test_a_body_that_loses_a_motion_stops_it() -> None:
    widget, key = widget_of("widgetSetSpeed", **OPTIONS), event_spec("x", "climb")
    widget.handle(down("x"), key, state())
    assert sent(widget.tick(state(CAR, now=1.5))) == Twist()
