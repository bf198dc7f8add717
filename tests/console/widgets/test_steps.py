"""A tap of a key is a step, and a speed limit holds for steps, keys and sticks."""

from __future__ import annotations

import math
import random
from pathlib import Path
from types import MappingProxyType

import pytest

from hub.gcm.navigation import VELOCITY_COMMAND
from hub.sim.kinematics import ANGULAR, LINEAR, approach
from rune_tui.controls.events import ControlEvent, Hit
from rune_tui.controls.keyboard import KeyboardHold, name_of_key, without_shift
from rune_tui.dispatch import Dispatch
from rune_tui.layout.spec import ControlKind, EventSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import LimitSpeed, SendEffect
from rune_tui.model.state_changes import changed
from rune_tui.startup.opening import open_layout
from rune_tui.widgets.speed import SetSpeed
from tests.support.cases import for_each

_LAYOUT = """<rune>
  <robot name="magellan"><capability name="NAV_MOVE"/></robot>
  <joystick name="pad"/>
  <view xsize="90" ysize="40">
    <viewport name="drive" robot="magellan" xpos="0" ypos="0" xsize="40" ysize="40">
      <widget handler="widgetSpeedLimit">
        <event key="]" control="step" value="1"/>
        <event joystick="pad" button="back" control="step" value="-1"/>
      </widget>
      <widget handler="widgetSpeedLimit">
        <option name="percent" value="25"/><event key="2" control="to"/>
      </widget>
    </viewport>
    <viewport name="slower" robot="magellan" xpos="50" ypos="0" xsize="30" ysize="6">
      <visualizer function="visualizeButton" text="slower"/>
      <widget handler="widgetSpeedLimit">
        <event mouse="left" control="step" value="-1"/>
      </widget>
    </viewport>
  </view>
</rune>
"""
AHEAD = EventSpec(name="w", control="translate", value=1.0, line=1)
LEFT = EventSpec(name="a", control="rotate", value=1.0, line=2)
_STEP_S = 0.01
_TICK_S = 0.05


def drive(**changes: float) -> SetSpeed:
    options = {"step": 0.05, "turn_step": math.radians(5.0), "fine": 0.2} | changes
    return SetSpeed("magellan", linear=0.5, angular=1.0, **options)


class Robot:
    """The simulator's wheels behind a link that takes its time.

    Attributes:
        way: How far it went [m].
        turn: How far it turned [rad].
    """

    def __init__(self, delay: float) -> None:
        self._delay = delay
        self._sent: list[tuple[float, float, float]] = []
        self._told = self._true = (0.0, 0.0)
        self.way = self.turn = 0.0

    def take(self, effects: tuple[object, ...], now: float) -> None:
        for effect in effects:
            assert isinstance(effect, SendEffect)
            assert effect.definition is VELOCITY_COMMAND
            twist = effect.value.twist
            self._sent.append((now + self._delay, twist.linear.x, twist.angular.z))

    def pass_time(self, now: float) -> None:
        for at, linear, angular in self._sent:
            if at <= now:
                self._told = linear, angular
        self._true = (
            approach(self._true[0], self._told[0], LINEAR, _STEP_S),
            approach(self._true[1], self._told[1], ANGULAR, _STEP_S),
        )
        self.way += self._true[0] * _STEP_S
        self.turn += self._true[1] * _STEP_S


def tapped(
    spec: EventSpec,
    *,
    seed: int,
    limit: float = 1.0,
    fine: bool = False,
    presses: tuple[float, ...] = (0.0,),
    seconds: float = 2.0,
) -> Robot:
    """What the robot does when a key comes at these times, on a terminal without releases."""
    chance = random.Random(seed)
    keyboard, widget = KeyboardHold(), drive()
    robot = Robot(chance.uniform(0.0, 0.1))
    tick = chance.uniform(0.0, _TICK_S)
    waiting = list(presses)
    for number in range(round(seconds / _STEP_S)):
        now = 10.0 + number * _STEP_S
        state = ConsoleState(now=now, speed_limits=MappingProxyType({"magellan": limit}))
        events: tuple[ControlEvent, ...] = ()
        if waiting and number * _STEP_S >= waiting[0]:
            waiting.pop(0)
            events = keyboard.press(spec.name, now, fine=fine)
        if number * _STEP_S >= tick:
            tick += _TICK_S + chance.uniform(-0.005, 0.015)
            events += keyboard.expire(now)
            robot.take(widget.tick(state), now)
        for event in events:
            robot.take(widget.handle(event, spec, state), now)
        robot.pass_time(now)
    return robot


@for_each("seed", range(20))
def test_a_tap_moves_five_centimetres_or_turns_five_degrees(seed: int) -> None:
    assert tapped(AHEAD, seed=seed).way == pytest.approx(0.05, abs=0.015)
    assert math.degrees(tapped(LEFT, seed=seed).turn) == pytest.approx(5.0, abs=1.5)


@for_each("seed", range(5))
@for_each("limit", [0.25, 0.5])
def test_a_limit_makes_a_step_slower_and_not_shorter(limit: float, seed: int) -> None:
    assert tapped(AHEAD, seed=seed, limit=limit).way == pytest.approx(0.05, abs=0.015)


def test_with_shift_a_tap_is_a_fifth() -> None:
    assert tapped(AHEAD, seed=1, fine=True).way == pytest.approx(0.01, abs=0.004)
    assert math.degrees(tapped(LEFT, seed=1, fine=True).turn) == pytest.approx(1.0, abs=0.4)


@pytest.mark.parametrize("delay", [0.25, 0.5])
def test_the_first_repeat_makes_a_step_a_hold(delay: float) -> None:
    presses = (0.0, *(delay + number * 0.033 for number in range(60)))
    assert tapped(AHEAD, seed=2, presses=presses, seconds=2.0).way > 0.5 * 1.2


def velocity(widget: SetSpeed, *events: ControlEvent, now: float = 10.0) -> float:
    for event in events:
        widget.handle(event, AHEAD, ConsoleState(now=now))
    return widget.velocity().linear.x


def test_a_key_whose_release_is_reported_drives_at_once_and_stops_at_once() -> None:
    widget = drive()
    press, release = (ControlEvent(name="w", pressed=down) for down in (True, False))
    assert velocity(widget, press) == 0.5
    assert velocity(widget, release) == 0.0
    fine = ControlEvent(name="w", pressed=True, fine=True)
    assert velocity(widget, fine) == pytest.approx(0.1)


def test_a_stop_ends_a_step_and_its_repeats_drive_nothing() -> None:
    widget = drive()
    press = ControlEvent(name="w", pressed=True, timed=True)
    assert velocity(widget, press) == pytest.approx(0.05 / 0.35)
    widget.release(ConsoleState(now=10.1))
    assert widget.velocity().neutral
    assert velocity(widget, ControlEvent(name="w", pressed=True, repeat=True, timed=True)) == 0.0


def test_no_step_is_as_before() -> None:
    widget = drive(step=0.0)
    assert velocity(widget, ControlEvent(name="w", pressed=True, timed=True)) == 0.5


def test_a_limit_holds_for_sticks_from_the_next_command_on() -> None:
    stick = EventSpec(
        name="joystick pad lefty", control="translate", value=1.0, line=1, kind=ControlKind.AXIS
    )
    widget = SetSpeed("magellan", linear=0.5, angular=1.0, axes=[stick])
    moved = ControlEvent(name=stick.name, pressed=True, value=1.0)
    widget.handle(moved, stick, ConsoleState(now=10.0))
    assert widget.velocity().linear.x == 0.5
    widget.tick(ConsoleState(now=10.05, speed_limits=MappingProxyType({"magellan": 0.25})))
    assert widget.velocity().linear.x == 0.125


def test_limits_go_by_steps_and_belong_to_a_robot() -> None:
    state = ConsoleState(now=0.0, chosen="magellan")
    seen = []
    for up in (True, False, False, False, False, True):
        state = changed(state, LimitSpeed(robot="magellan", up=up))
        seen.append(state.speed_limit("magellan"))
    assert seen == [1.0, 0.5, 0.25, 0.1, 0.1, 0.25]
    state = changed(state, LimitSpeed(robot="magellan", share=0.3))
    assert (state.speed_limit("magellan"), state.speed_limit("blimp")) == (0.3, 1.0)
    state = changed(state, LimitSpeed(robot="magellan", up=True))
    assert state.speed_limit("magellan") == 0.5


def test_a_press_that_has_to_be_proven_after_a_stop_is_a_whole_step() -> None:
    keyboard, widget, robot = KeyboardHold(), drive(), Robot(0.02)
    keyboard.stop({"w"}, 9.0)
    for number in range(200):
        now = 10.0 + number * _STEP_S
        events = keyboard.press("w", now) if number == 0 else keyboard.expire(now)
        for event in events:
            if not event.must_release_first:
                robot.take(widget.handle(event, AHEAD, ConsoleState(now=now)), now)
        robot.take(widget.tick(ConsoleState(now=now)), now)
        robot.pass_time(now)
    assert robot.way == pytest.approx(0.05, abs=0.015)


def test_keys_sticks_and_buttons_on_the_screen_change_the_limit(tmp_path: Path) -> None:
    path = tmp_path / "layout.xml"
    path.write_text(_LAYOUT)
    dispatch = Dispatch(open_layout(path))
    state = ConsoleState(now=0.0, chosen="magellan")
    limits = []
    click = Hit(viewport="slower", x=0.5, y=0.5)
    for event in (
        ControlEvent(name="2", pressed=True),
        ControlEvent(name="]", pressed=True),
        ControlEvent(name="mouse left", pressed=True, hits=(click,)),
        ControlEvent(name="joystick pad back", pressed=True),
        ControlEvent(name="joystick pad back", pressed=True),
    ):
        for effect in dispatch.handle(event, state):
            assert isinstance(effect, LimitSpeed)
            state = changed(state, effect)
        limits.append(state.speed_limit("magellan"))
    assert limits == [0.25, 0.5, 0.25, 0.1, 0.1]


@for_each(
    ("key", "character", "plain"),
    [
        ("W", "W", "w"),
        ("w", "w", ""),
        ("shift+up", None, "up"),
        ("up", None, ""),
        ("shift+w", "W", "w"),
        ("ctrl+W", "W", ""),
        ("ctrl+shift+up", None, ""),
        ("question_mark", "?", ""),
        ("+", "+", ""),
    ],
)
def test_shift_is_seen(key: str, character: str | None, plain: str) -> None:
    assert without_shift(key, character) == plain
    if plain:
        assert name_of_key(plain, None) == plain
