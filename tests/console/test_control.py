"""What keys do to a robot that nobody, this console or another one has control of."""

from __future__ import annotations

import random
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.autonomy import AUTONOMY_COMMAND
from hub.gcm.control import CONTROL_STATE, RESTRICTED, ControlAction, ControlState
from hub.gcm.navigation import STOP, VELOCITY_COMMAND
from hub.gcm.vision import CAMERA_COMMAND, NIGHT_COMMAND
from rune_tui.controls.events import ControlEvent
from rune_tui.dispatch import Dispatch
from rune_tui.layout.actions import inputs_of
from rune_tui.model.change_notifier import ChangeNotifier
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.control import owner_words
from rune_tui.model.effects import ControlEffect, Effect, Notify, SendEffect, ToggleNight
from rune_tui.model.robot_state import LinkPhase, LinkState, RobotState
from rune_tui.startup.opening import open_layout
from tests.console.states import robot_of
from tests.console.visualizers.conftest import received

LAYOUT = """\
<rune>
  <robot name="magellan">
    <capability name="NAV_MOVE"/><capability name="VIS_PTZ"/><capability name="VIS_NIGHT"/>
    <capability name="AUT_PILOT"/>
  </robot>
  <view xsize="160" ysize="96">
    <viewport name="camera" xpos="0" ypos="0" xsize="80" ysize="96">
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate"/><event key="a" control="rotate"/>
      </widget>
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetAutonomy"><event key="e"/></widget>
      <widget handler="widgetAdjustPan"><event key="j"/></widget>
      <widget handler="widgetToggleNightMode"><event key="n"/></widget>
      <widget handler="widgetTakeControl">{option}<event key="t"/></widget>
      <widget handler="widgetReleaseControl"><event key="c"/></widget>
      <widget handler="widgetGrantControl"><event key="y"/></widget>
      <widget handler="widgetDenyControl"><event key="o"/></widget>
      <widget handler="widgetTakeOver"><event key="f12"/></widget>
    </viewport>
  </view>
</rune>
"""
ME, BOB, CAROL = 7, 8, 9
NOBODY = ControlState()
MINE = ControlState(owner=ME, operator="alice", why="alice took control")
BOBS = ControlState(owner=BOB, operator="bob", why="bob took control")
ASKED = ControlState(owner=ME, operator="alice", asker=BOB, asker_operator="bob", left_s=8.0)


class Hands:
    """Somebody at a console with this layout."""

    def __init__(self, folder: Path, option: str = "") -> None:
        path = folder / "layout.xml"
        path.write_text(LAYOUT.format(option=option))
        layout = open_layout(path)
        self.inputs = inputs_of(layout)
        self.dispatch = Dispatch(layout)
        self.now = 100.0
        self.control: ControlState | None = NOBODY

    @property
    def robot(self) -> RobotState:
        known = {CONTROL_STATE.name: received(self.control)} if self.control else {}
        link = LinkState(
            phase=LinkPhase.CONNECTED, since=0.0, endpoint="", number=ME, owned_since="12:03"
        )
        return robot_of(name="magellan", link=link, messages=known)

    @property
    def state(self) -> ConsoleState:
        return ConsoleState(now=self.now, robots={"magellan": self.robot}, inputs=self.inputs)

    def press(self, key: str) -> tuple[Effect, ...]:
        return self.dispatch.handle(ControlEvent(name=key, pressed=True), self.state)

    def repeat(self, key: str) -> tuple[Effect, ...]:
        again = ControlEvent(name=key, pressed=True, repeat=True)
        return self.dispatch.handle(again, self.state)

    def let_go(self, key: str) -> tuple[Effect, ...]:
        return self.dispatch.handle(ControlEvent(name=key, pressed=False), self.state)

    def tick(self) -> tuple[Effect, ...]:
        self.now += 0.05
        return self.dispatch.tick(self.state)

    def seconds(self, seconds: float) -> tuple[Effect, ...]:
        return tuple(effect for _ in range(round(seconds / 0.05)) for effect in self.tick())


@pytest.fixture
def hands(tmp_path: Path) -> Hands:
    return Hands(tmp_path)


def speeds(effects: Iterable[Effect]) -> list[tuple[float, float]]:
    return [
        (effect.value.twist.linear.x, effect.value.twist.angular.z)
        for effect in effects
        if isinstance(effect, SendEffect) and effect.definition is VELOCITY_COMMAND
    ]


def sent(effects: Iterable[Effect]) -> set[Any]:
    """What is sent, but for zero speed, which anybody may send."""
    sends = [effect for effect in effects if isinstance(effect, SendEffect)]
    neutral = [s for s in sends if s.definition is VELOCITY_COMMAND and s.value.neutral]
    return {effect.definition.name for effect in sends if effect not in neutral}


def actions(effects: Iterable[Effect]) -> list[ControlAction]:
    return [effect.action for effect in effects if isinstance(effect, ControlEffect)]


def told(effects: Iterable[Effect]) -> list[str]:
    return [effect.notice.text for effect in effects if isinstance(effect, Notify)]


def test_driving_key_takes_a_free_robot_and_drives_it_in_the_same_moment(hands: Hands) -> None:
    effects = hands.press("w")
    assert actions(effects) == [ControlAction.TAKE]
    assert speeds(effects) == [(0.5, 0.0)]
    assert actions(hands.repeat("w")) == []
    hands.control = MINE
    effects = hands.seconds(1.0)
    assert set(speeds(effects)) == {(0.5, 0.0)}
    assert actions(effects) == []
    assert actions(hands.press("a")) == []


@pytest.mark.parametrize(("key", "message"), [("e", AUTONOMY_COMMAND), ("j", CAMERA_COMMAND)])
def test_other_orders_go_to_a_free_robot_and_what_drives_it_takes_it(
    hands: Hands, key: str, message: Any
) -> None:
    effects = hands.press(key)
    assert sent(effects) == {message.name}
    assert actions(effects) == ([ControlAction.TAKE] if message is AUTONOMY_COMMAND else [])


@pytest.mark.parametrize("key", ["w", "e", "j", "n"])
def test_robot_of_another_gets_nothing_and_the_operator_is_told_what_to_do(
    hands: Hands, key: str
) -> None:
    hands.control = BOBS
    effects = hands.press(key)
    assert told(effects) == ["bob has control since 12:03; press T to ask"]
    assert not any(isinstance(effect, ToggleNight) for effect in effects)
    effects += hands.repeat(key) + hands.seconds(1.0) + hands.let_go(key)
    assert sent(effects) == set()
    assert actions(effects) == []
    assert len(told(effects)) == 1


def test_stop_is_sent_whoever_has_control(hands: Hands) -> None:
    for control in (None, NOBODY, MINE, BOBS):
        hands.control = control
        assert STOP.name in sent(hands.press("space"))


@pytest.mark.parametrize("lost", [BOBS, NOBODY, None])
def test_key_that_is_held_while_control_is_lost_counts_only_when_it_is_pressed_anew(
    hands: Hands, lost: ControlState | None
) -> None:
    hands.control = MINE
    hands.tick()
    assert speeds(hands.press("w")) == [(0.5, 0.0)]
    for control in (lost, MINE):
        hands.control = control
        assert set(speeds(hands.seconds(0.5) + hands.repeat("w"))) == {(0.0, 0.0)}
    hands.let_go("w")
    assert speeds(hands.press("w")) == [(0.5, 0.0)]


def test_key_that_is_pressed_the_moment_control_comes_counts(hands: Hands) -> None:
    hands.control = BOBS
    hands.tick()
    hands.control = MINE
    assert (0.5, 0.0) in speeds(hands.press("w"))
    assert set(speeds(hands.seconds(0.5))) == {(0.5, 0.0)}


def test_hub_that_does_not_say_who_has_control_is_commanded_as_ever(hands: Hands) -> None:
    hands.control = None
    effects = hands.press("w") + hands.press("n")
    assert sent(effects) == {VELOCITY_COMMAND.name, NIGHT_COMMAND.name}
    assert actions(effects) == []


def test_where_the_layout_says_so_driving_waits_until_control_was_taken(tmp_path: Path) -> None:
    hands = Hands(tmp_path, '<option name="driving" value="waits"/>')
    effects = hands.press("w")
    assert (sent(effects), actions(effects)) == (set(), [])
    assert told(effects) == ["nobody has control; press T to take it"]
    assert sent(hands.press("j")) == {CAMERA_COMMAND.name}
    assert actions(hands.press("t")) == [ControlAction.TAKE]
    hands.control = MINE
    assert (0.5, 0.0) in speeds(hands.press("w"))


@pytest.mark.parametrize(
    ("key", "control", "wanted"),
    [
        ("t", NOBODY, ControlAction.TAKE),
        ("t", BOBS, ControlAction.ASK),
        ("t", None, ControlAction.TAKE),
        ("t", MINE, "you have control since 12:03"),
        ("c", MINE, ControlAction.RELEASE),
        ("c", BOBS, ControlAction.RELEASE),
        ("c", NOBODY, "nobody has control"),
        ("y", ASKED, ControlAction.GRANT),
        ("o", ASKED, ControlAction.DENY),
        ("y", MINE, "nobody asks you for control"),
        ("o", BOBS, "nobody asks you for control"),
        ("f12", BOBS, ControlAction.TAKE_OVER),
        ("f12", MINE, "you have control since 12:03"),
    ],
)
def test_keys_of_control(
    hands: Hands, key: str, control: ControlState | None, wanted: ControlAction | str
) -> None:
    hands.control = control
    effects = hands.press(key)
    assert [*actions(effects), *told(effects)] == [wanted]


@given(st.integers(0, 2**32))
def test_whatever_happens_nothing_but_the_stop_goes_to_a_robot_of_another(
    tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    chance = random.Random(seed)
    hands = Hands(tmp_path_factory.getbasetemp())
    for _ in range(30):
        hands.control = chance.choice([None, NOBODY, MINE, BOBS, BOBS, ASKED])
        effects: tuple[Effect, ...] = ()
        for _ in range(chance.randint(1, 4)):
            deed = chance.choice([hands.press, hands.repeat, hands.let_go])
            effects += deed(chance.choice(["w", "a", "space", "e", "j", "n"]))
            effects += hands.tick()
        if hands.control is BOBS:
            assert sent(effects).isdisjoint(RESTRICTED)
            assert set(speeds(effects)) <= {(0.0, 0.0)}


def notices(hands: Hands, *states: ControlState | None) -> list[tuple[str, bool]]:
    """What a console is told, and whether as an alarm, as control changes so."""
    watch = ChangeNotifier()
    said = []
    for control in states:
        hands.control = control
        hands.now = 100.0
        said += [(each.text, each.alarm) for each in watch.look(hands.state) if not each.quiet]
    return said


def test_every_console_is_told_when_control_changes(hands: Hands) -> None:
    granted = ControlState(owner=BOB, operator="bob", why="alice handed control to bob")
    lost = ControlState(why="the console of bob fell silent")
    assert notices(hands, NOBODY, NOBODY, BOBS, BOBS, lost) == [
        ("bob has control since 12:03: bob took control", False),
        ("nobody has control: the console of bob fell silent", False),
    ]
    assert notices(hands, MINE, granted) == [
        ("bob has control since 12:03: alice handed control to bob", True)
    ]


def test_who_is_asked_is_told_how_to_answer_and_who_asks_what_came_of_it(hands: Hands) -> None:
    assert notices(hands, MINE, ASKED, ASKED) == [
        ("bob asks you for control: 8 s to answer; Y hands it over, O keeps it", True)
    ]
    asks = ControlState(owner=BOB, operator="bob", asker=ME, asker_operator="alice", left_s=8.0)
    denied = ControlState(owner=BOB, operator="bob", why="bob did not hand control to alice")
    assert notices(hands, BOBS, asks, denied)[1:] == [
        ("bob is asked for control: 8 s to answer", False),
        ("bob did not hand control to alice", False),
    ]
    carols = ControlState(owner=BOB, operator="bob", asker=CAROL, asker_operator="carol", left_s=3)
    assert notices(hands, BOBS, carols)[1:] == [
        ("carol asks bob for control: 3 s to answer", False)
    ]


def test_words_say_who_has_control(hands: Hands) -> None:
    words = []
    for control in (None, NOBODY, MINE, BOBS):
        hands.control = control
        words.append(owner_words(hands.robot))
    assert words == [
        "nobody has control",
        "nobody has control",
        "you have control since 12:03",
        "bob has control since 12:03",
    ]
