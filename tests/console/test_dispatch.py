"""From keys to effects: whatever the hands do, robots end at rest."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.geometry import Twist
from hub.gcm.navigation import STOP, VELOCITY_COMMAND
from hub.gcm.vision import CAMERA_COMMAND
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.keyboard import KeyboardHold
from rune_tui.controls.release_guard import SLOW_PROOF_S
from rune_tui.controls.repeat_rate import FIRST_HOLD_S
from rune_tui.dispatch import Dispatch
from rune_tui.layout.actions import actions_of
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import (
    Effect,
    SendEffect,
)
from rune_tui.model.robot_state import LinkPhase, LinkState
from tests.console.dispatching import DEMO, at, down, stops, up, velocities
from tests.console.states import robot_of


def test_a_key_that_no_widget_names_does_nothing():
    assert Dispatch(DEMO).handle(down("f9"), at(0.0)) == ()


def test_letters_and_arrows_of_the_demo_drive_alike():
    for letter, arrow in zip("wsad", ("up", "down", "left", "right"), strict=True):
        first, second = Dispatch(DEMO), Dispatch(DEMO)
        assert first.handle(down(letter), at(0.0)) == second.handle(down(arrow), at(0.0)) != ()


def test_every_key_of_the_demo_has_an_effect():
    dispatch = Dispatch(DEMO)
    specs = [*DEMO.view.widgets]
    for viewport in DEMO.view.viewports:
        specs += viewport.widgets
    link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
    state = dataclasses.replace(at(0.0), robots={"robot": robot_of(name="robot", link=link)})
    events = [event for spec in specs for event in spec.events]
    for event in [event for event in events if not event.name.startswith("mouse")]:
        assert dispatch.handle(down(event.name), state)
        dispatch.handle(up(event.name), state)


def test_the_demo_looks_left_with_j_and_right_with_l():
    (left,) = Dispatch(DEMO).handle(down("j"), at(0.0))
    (right,) = Dispatch(DEMO).handle(down("l"), at(0.0))
    assert isinstance(left, SendEffect)
    assert isinstance(right, SendEffect)
    assert left.definition is right.definition is CAMERA_COMMAND
    assert left.value.pan > 0 > right.value.pan


def test_one_key_may_drive_two_robots_and_two_controls(two_robots: LayoutSpec):
    dispatch = Dispatch(two_robots)
    effects = dispatch.handle(down("w"), at(0.0))
    assert velocities(effects, "robot") == [(0.5, 0.0)]
    assert velocities(effects, "blimp") == [(0.5, 0.0)]
    dispatch.handle(up("w"), at(0.1))
    assert velocities(dispatch.handle(down("e"), at(0.2)), "robot")[-1] == (0.5, -1.0)
    assert velocities(dispatch.handle(up("e"), at(0.3)), "robot")[-1] == (0.0, 0.0)


def test_of_two_speed_widgets_of_a_robot_only_the_last_pressed_speaks(two_robots: LayoutSpec):
    dispatch = Dispatch(two_robots)
    assert velocities(dispatch.tick(at(0.0)), "robot") == [(0.0, 0.0)]
    dispatch.handle(down("w"), at(1.0))
    assert velocities(dispatch.handle(down("r"), at(1.1)), "robot") == [(1.5, 0.0)]
    sent = [dispatch.tick(at(1.1 + number / 20)) for number in range(1, 21)]
    assert velocities(sum(sent, ()), "robot") == [(1.5, 0.0)] * 20
    assert velocities(dispatch.handle(up("w"), at(2.2)), "robot") == []
    assert velocities(dispatch.handle(up("r"), at(2.3)), "robot") == [(0.0, 0.0)]


def test_a_stop_comes_first_and_zero_after_it_and_held_keys_no_longer_drive(
    two_robots: LayoutSpec,
):
    dispatch = Dispatch(two_robots)
    dispatch.handle(down("w"), at(0.0))
    effects = dispatch.handle(down("space"), at(0.1))
    assert stops(effects[:1]) == ["robot"]
    assert velocities(effects[1:], "robot") == [(0.0, 0.0)]
    assert velocities(effects, "blimp") == []
    later = sum((dispatch.tick(at(0.1 + number / 20)) for number in range(1, 41)), ())
    assert set(velocities(later, "robot")) == {(0.0, 0.0)}
    assert set(velocities(later, "blimp")) == {(0.5, 0.0)}
    held = ControlEvent(name="w", pressed=True, repeat=True)
    assert velocities(dispatch.handle(held, at(2.2)), "robot") == []
    dispatch.handle(up("w"), at(2.3))
    assert velocities(dispatch.handle(down("w"), at(2.4)), "robot") == [(0.5, 0.0)]


def test_letting_go_of_everything_sends_one_zero_to_every_driven_robot(two_robots: LayoutSpec):
    dispatch = Dispatch(two_robots)
    dispatch.handle(down("w"), at(0.0))
    effects = dispatch.released(at(0.1))
    assert velocities(effects, "robot") == [(0.0, 0.0)]
    assert velocities(effects, "blimp") == [(0.0, 0.0)]
    assert len(effects) == 2


def test_letting_go_sends_zero_even_if_nothing_was_held(two_robots: LayoutSpec):
    effects = Dispatch(two_robots).released(at(0.0))
    assert velocities(effects, "robot") == velocities(effects, "blimp") == [(0.0, 0.0)]


def test_an_action_of_the_list_does_what_its_key_does(two_robots: LayoutSpec):
    actions = {action.event.name: action for action in actions_of(two_robots)}
    for key in ("q", "space", "h"):
        assert actions[key].at_once
        chosen = Dispatch(two_robots).act(actions[key], at(0.0))
        assert chosen == Dispatch(two_robots).handle(down(key), at(0.0)) != ()
    assert not actions["w"].at_once


class Hands:
    """A keyboard, a clock that ticks 20 times a second, and a log of what was sent when."""

    def __init__(self, layout: LayoutSpec) -> None:
        self.dispatch = Dispatch(layout)
        self.keyboard = KeyboardHold()
        self.steps = 0
        self.sent: list[tuple[float, Effect]] = []

    @property
    def now(self) -> float:
        return 500.0 + self.steps / 100

    def put(self, effects: Iterable[Effect]) -> None:
        self.sent += [(self.now, effect) for effect in effects]

    def feed(self, events: Iterable[ControlEvent]) -> None:
        for event in events:
            self.put(self.dispatch.handle(event, at(self.now)))

    def expire(self, until: float) -> None:
        self.put(self.dispatch.handle_all(self.keyboard.expire(until), at(self.now)))

    def wait(self, hundredths: int) -> None:
        for _ in range(hundredths):
            self.steps += 1
            self.expire(self.now)
            if self.steps % 5 == 0:
                self.put(self.dispatch.tick(at(self.now)))

    def velocities(self, since: float, until: float, robot: str = "robot") -> list[Twist]:
        return [
            effect.value.twist
            for moment, effect in self.sent
            if since <= moment < until
            and isinstance(effect, SendEffect)
            and effect.definition is VELOCITY_COMMAND
            and effect.robot == robot
        ]


KEYS = ("w", "s", "a", "d", "up", "left", "space", "j")


ACTIONS = st.lists(
    st.tuples(
        st.sampled_from([*KEYS, *KEYS, "let go", "focus lost"]),
        st.integers(min_value=0, max_value=70),
    ),
    min_size=1,
    max_size=40,
)


def play(actions: list[tuple[str, int]]) -> Hands:
    hands = Hands(DEMO)
    for action, pause in actions:
        if action == "let go":
            hands.expire(math.inf)
        elif action == "focus lost":
            hands.keyboard.release_all(hands.now)
            hands.put(hands.dispatch.released(at(hands.now)))
        else:
            hands.feed(hands.keyboard.press(action, hands.now))
        hands.wait(pause)
    return hands


@given(actions=ACTIONS)
def test_speeds_never_exceed_the_options_whatever_the_hands_do(actions: list[tuple[str, int]]):
    hands = play(actions)
    for twist in hands.velocities(0.0, 1e9):
        assert abs(twist.linear.x) <= 0.5
        assert abs(twist.angular.z) <= 1.0
        assert twist == Twist.planar(twist.linear.x, twist.angular.z)


@given(actions=ACTIONS)
def test_when_hands_leave_the_robot_is_at_rest_within_a_proof_and_a_hold(
    actions: list[tuple[str, int]],
):
    hands = play(actions)
    hands.wait(round(100 * (SLOW_PROOF_S + FIRST_HOLD_S)) + 4)
    start = hands.now
    hands.wait(300)
    sent = hands.velocities(start, hands.now)
    assert all(twist.neutral for twist in sent)
    assert 14 <= len(sent) <= 16


@given(actions=ACTIONS)
@example(actions=[("w", 0), ("w", 0), ("s", 34)])
@example(actions=[("w", 0), ("s", 0), ("s", 34)])
def test_letting_go_sends_zero_once_and_then_five_times_a_second(actions: list[tuple[str, int]]):
    hands = play(actions)
    hands.wait(1)
    moving = any(not twist.neutral for twist in hands.velocities(0.0, 1e9)[-1:])
    before = len(hands.sent)
    hands.expire(math.inf)
    let_go = [
        effect.value.neutral
        for _, effect in hands.sent[before:]
        if isinstance(effect, SendEffect) and effect.definition is VELOCITY_COMMAND
    ]
    if moving:
        assert let_go.count(True) == 1
        assert let_go[-1]
        start = hands.now + 0.001
        hands.wait(16)
        assert hands.velocities(start, hands.now) == []
        hands.wait(200 - 16)
        assert 9 <= len(hands.velocities(start, hands.now)) <= 11
    assert all(twist.neutral for twist in hands.velocities(hands.now, 1e9))


@given(actions=ACTIONS)
def test_losing_the_focus_sends_exactly_one_zero_at_once(actions: list[tuple[str, int]]):
    hands = play(actions)
    hands.keyboard.release_all(hands.now)
    effects = hands.dispatch.released(at(hands.now))
    assert velocities(effects, "robot") == [(0.0, 0.0)]
    assert len(effects) == 1
    hands.wait(200)
    assert all(twist.neutral for twist in hands.velocities(hands.now - 1.995, hands.now))


@given(actions=ACTIONS)
def test_while_a_robot_moves_no_command_is_older_than_a_tenth_of_a_second(
    actions: list[tuple[str, int]],
):
    hands = play(actions)
    hands.wait(100)
    commands = [
        (moment, effect.value.neutral)
        for moment, effect in hands.sent
        if isinstance(effect, SendEffect) and effect.definition is VELOCITY_COMMAND
    ]
    for (before, neutral), (after, _) in itertools.pairwise(commands):
        assert after - before <= (0.251 if neutral else 0.101)


@given(actions=ACTIONS)
def test_the_newest_of_the_held_keys_of_a_control_wins(actions: list[tuple[str, int]]):
    linear = {"w": 0.5, "up": 0.5, "s": -0.5}
    hands = Hands(DEMO)
    order: list[str] = []
    for action, pause in actions:
        if action not in linear:
            continue
        for event in hands.keyboard.press(action, hands.now):
            hands.feed([event])
            if event.repeat:
                continue
            if event.pressed:
                order.append(event.name)
            else:
                order.remove(event.name)
            newest = linear[order[-1]] if order else 0.0
            commanded = hands.velocities(0.0, 1e9)[-1].linear.x
            assert (commanded > 0.0, commanded < 0.0) == (newest > 0.0, newest < 0.0)
        hands.wait(pause)
        order = [key for key in order if key in hands.keyboard.held]


@pytest.mark.parametrize(("seconds", "repeat_hz"), [(5, 30), (5, 10), (3, 5)])
def test_a_key_held_for_seconds_gives_twenty_commands_a_second(seconds: int, repeat_hz: int):
    hands = Hands(DEMO)
    hands.feed(hands.keyboard.press("w", hands.now))
    hands.wait(50)
    start = hands.now
    for _ in range(seconds * repeat_hz):
        hands.feed(hands.keyboard.press("w", hands.now))
        hands.wait(100 // repeat_hz)
    sent = hands.velocities(start, hands.now)
    assert all(twist == Twist.planar(0.5, 0.0) for twist in sent)
    assert abs(len(sent) - 20 * (hands.now - start)) <= 2


def test_a_stop_says_who_pressed_which_key_and_nothing_of_the_layout():
    effects = Dispatch(DEMO).handle(down("space"), ConsoleState(now=0.0, operator="ada"))
    (reason,) = (
        effect.value.reason
        for effect in effects
        if isinstance(effect, SendEffect) and effect.definition is STOP
    )
    assert reason == "ada pressed space"
