"""Choosing, peeking and the next alarm: no robot moves by hands that meant another one."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.navigation import STOP, VELOCITY_COMMAND
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.keyboard import KeyboardHold
from rune_tui.dispatch import Dispatch
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.attention import AttentionEntry
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, ReleaseFirst, SendEffect, StateEffect
from rune_tui.model.state_changes import changed
from rune_tui.startup.opening import open_layout
from rune_tui.widgets.team import PEEK_S
from tests.console.visualizers.conftest import Made
from tests.support.cases import for_each

CAPABILITIES = '<capability name="NAV_STATE"/><capability name="NAV_MOVE"/>'
TEAM = f"""\
<rune>
  <robot name="rover">{CAPABILITIES}<capability name="VIS_NIGHT"/></robot>
  <robot name="blimp" hub="tcp://127.0.0.1:1391">{CAPABILITIES}</robot>
  <robot name="rov" hub="tcp://127.0.0.1:1401">{CAPABILITIES}</robot>
  <joystick name="pad"/>
  <view xsize="160" ysize="96">
    <widget handler="widgetChooseRobot">
      <option name="robot" value="blimp"/><event key="2"/>
    </widget>
    <widget handler="widgetPeek"><event key="'"/></widget>
    <widget handler="widgetNextAlarm"><event key="n"/></widget>
    <widget handler="widgetHelp"><event key="f1"/></widget>
    <viewport name="chosen" robot="*" xpos="0" ypos="0" xsize="160" ysize="96">
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate"/>
        <event joystick="pad" axis="lefty" control="translate" value="1"/>
      </widget>
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetToggleNightMode"><event key="z"/></widget>
    </viewport>
  </view>
</rune>
"""
STICK = "joystick pad lefty"


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> LayoutSpec:
    path = tmp_path_factory.mktemp("layouts") / "team.xml"
    path.write_text(TEAM)
    return open_layout(path)


class Operator:
    """Hands, a clock that ticks 20 times a second, and effects executed as the app does."""

    def __init__(self, layout: LayoutSpec, *, reports_releases: bool = True) -> None:
        self.dispatch = Dispatch(layout)
        self.keyboard = KeyboardHold(self.dispatch.waits_for_hold)
        self.reports = reports_releases
        robots = {robot.name: Made().robot().with_(name=robot.name) for robot in layout.robots}
        self.state = ConsoleState(now=100.0, robots=robots, chosen="rover")
        self.speeds = dict.fromkeys(robots, 0.0)
        self.stopped: list[str] = []
        self.notices: list[str] = []

    def execute(self, effects: Iterable[Effect]) -> None:
        for effect in effects:
            if isinstance(effect, SendEffect):
                if effect.definition is VELOCITY_COMMAND:
                    self.speeds[effect.robot] = effect.value.twist.linear.x
                elif effect.definition is STOP:
                    self.stopped.append(effect.robot)
            elif isinstance(effect, ReleaseFirst):
                self.keyboard.stop(effect.keys, self.state.now)
            elif isinstance(effect, StateEffect):
                if effect.ends_holds:
                    self.lose_focus()
                if isinstance(effect, Notify):
                    self.notices.append(effect.notice.text)
                self.state = changed(self.state, effect)

    def lose_focus(self) -> None:
        self.keyboard.release_all(self.state.now)
        self.execute(self.dispatch.released(self.state))

    def _handle(self, events: Iterable[ControlEvent]) -> None:
        for event in events:
            self.state = dataclasses.replace(self.state, held=self.keyboard.held)
            self.execute(self.dispatch.handle(event, self.state))

    def press(self, key: str, *, repeat: bool = False) -> None:
        now = self.state.now
        if self.reports:
            self._handle(self.keyboard.down(key, now, repeat=repeat))
        else:
            self._handle(self.keyboard.press(key, now))

    def lift(self, key: str) -> None:
        self._handle(self.keyboard.up(key, self.state.now))

    def push(self, value: float, *, repeat: bool = False) -> None:
        event = ControlEvent(name=STICK, pressed=bool(value), repeat=repeat, value=value)
        self._handle([event])

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.state = dataclasses.replace(self.state, now=self.state.now + 0.05)
            self.keyboard.heard(self.state.now)
            self._handle(self.keyboard.expire(self.state.now))
            self.execute(self.dispatch.tick(self.state))


def test_holding_the_key_shows_the_robot_not_looked_at_for_longest(team: LayoutSpec) -> None:
    operator = Operator(team)
    shown = []
    for _ in range(3):
        operator.press("'")
        operator.wait(1.0)
        shown.append(operator.state.peeked)
        assert operator.state.shown_robot("*") is operator.state.robots[shown[-1]]
        assert operator.state.robot("*") is operator.state.robots["rover"]
        operator.lift("'")
        assert operator.state.seen == operator.state.chosen == "rover"
        operator.wait(1.0)
    assert shown == ["blimp", "rov", "blimp"]
    assert operator.state.unseen_s("blimp") == pytest.approx(1.0)
    assert operator.state.unseen_s("rov") == pytest.approx(3.0)
    assert operator.state.unseen_s("rover") == 0.0


def test_without_reported_releases_a_press_shows_it_for_three_seconds(team: LayoutSpec) -> None:
    operator = Operator(team, reports_releases=False)
    operator.press("'")
    operator.wait(PEEK_S - 0.2)
    assert operator.state.peeked == "blimp"
    operator.wait(0.4)
    assert operator.state.peeked == ""


def test_nothing_drives_while_the_operator_peeks(team: LayoutSpec) -> None:
    operator = Operator(team)
    operator.press("w")
    operator.wait(0.5)
    assert operator.speeds["rover"] > 0.0
    operator.press("'")
    assert operator.speeds == {"rover": 0.0, "blimp": 0.0, "rov": 0.0}
    operator.press("w", repeat=True)
    operator.lift("w")
    operator.press("w")
    operator.push(1.0)
    operator.wait(1.0)
    assert set(operator.speeds.values()) == {0.0}
    assert any("while you peek at" in text for text in operator.notices)
    operator.lift("'")
    operator.press("w", repeat=True)
    operator.push(0.9, repeat=True)
    operator.wait(1.0)
    assert set(operator.speeds.values()) == {0.0}, "hands that are down must be lifted first"
    operator.lift("w")
    operator.push(0.0)
    operator.press("w")
    assert operator.speeds["rover"] > 0.0
    assert operator.speeds["blimp"] == operator.speeds["rov"] == 0.0


def test_other_commands_wait_for_the_end_of_the_peek_too(team: LayoutSpec) -> None:
    operator = Operator(team)
    operator.press("'")
    operator.press("z")
    assert operator.state.night == frozenset()
    operator.lift("'")
    operator.lift("z")
    operator.press("z")
    assert operator.state.night == frozenset({"rover"})


def test_a_stop_while_peeking_stops_the_chosen_robot_and_the_one_looked_at(
    team: LayoutSpec,
) -> None:
    operator = Operator(team)
    operator.press("'")
    operator.press("space")
    assert operator.stopped == ["rover", "blimp"]
    assert operator.state.peeked == "blimp"


@for_each("end", ["choose", "focus", "help"])
def test_a_peek_ends_with_its_reason(team: LayoutSpec, end: str) -> None:
    operator = Operator(team)
    operator.press("'")
    if end == "focus":
        operator.lose_focus()
    else:
        operator.press({"choose": "2", "help": "f1"}[end])
    assert operator.state.peeked == ""
    assert operator.state.chosen == ("blimp" if end == "choose" else "rover")
    operator.wait(1.0)
    assert operator.state.peeked == ""


def test_a_stick_held_over_a_choice_drives_the_new_robot_only_from_neutral(
    team: LayoutSpec,
) -> None:
    operator = Operator(team)
    operator.push(1.0)
    operator.wait(0.2)
    assert operator.speeds["rover"] > 0.0
    operator.press("2")
    assert operator.state.chosen == "blimp"
    for value in (0.8, 0.9, 1.0):
        operator.push(value, repeat=True)
        operator.wait(0.2)
    assert operator.speeds == {"rover": 0.0, "blimp": 0.0, "rov": 0.0}
    operator.push(0.0)
    operator.push(1.0)
    assert operator.speeds["blimp"] > 0.0
    assert operator.speeds["rover"] == 0.0


def test_a_robot_that_was_never_looked_at_says_so(team: LayoutSpec) -> None:
    assert Operator(team).state.unseen_s("rov") == math.inf


def raised(robot: str, *, answered: bool = False) -> AttentionEntry:
    return AttentionEntry(
        robot=robot,
        cause="leak",
        text="leak",
        alarm=True,
        since=0.0,
        raised=0.0,
        times=1,
        answered=answered,
        over=False,
    )


def test_the_next_alarm_is_chosen_with_empty_hands(team: LayoutSpec) -> None:
    operator = Operator(team)
    operator.state = dataclasses.replace(operator.state, attention=(raised("rov"),))
    operator.press("w")
    operator.wait(0.2)
    assert operator.speeds["rover"] > 0.0
    operator.press("n")
    operator.press("w", repeat=True)
    operator.wait(0.4)
    assert operator.state.chosen == "rov"
    assert set(operator.speeds.values()) == {0.0}
    operator.lift("n")
    operator.press("n")
    assert operator.state.chosen == "rov"
    assert operator.notices == ["only this robot has alarms"]


def test_alarms_alone_never_choose_a_robot(team: LayoutSpec) -> None:
    operator = Operator(team)
    operator.state = dataclasses.replace(operator.state, attention=(raised("rov"),))
    operator.wait(30.0)
    assert operator.state.chosen == operator.state.seen == "rover"


def test_a_peek_goes_to_the_first_alarm_that_was_not_answered(team: LayoutSpec) -> None:
    operator = Operator(team)
    queue = (raised("blimp", answered=True), raised("rov"))
    operator.state = dataclasses.replace(operator.state, attention=queue)
    operator.press("'")
    assert operator.state.peeked == "rov"


HANDS = (
    *(("press", key) for key in "w'w'w2n"),
    *(("press", key) for key in ("space", "f1", "escape", "z")),
    *(("lift", key) for key in "w'2n"),
    *(("push", value) for value in ("1.0", "1.0", "-0.4", "0")),
    ("focus", ""),
)
"""What hands do, the likely more often."""


@given(
    reports=st.booleans(),
    steps=st.lists(st.tuples(st.sampled_from(HANDS), st.integers(0, 12)), min_size=3, max_size=40),
)
def test_only_the_chosen_robot_moves_and_none_while_the_operator_peeks(
    team: LayoutSpec, *, reports: bool, steps: list[tuple[tuple[str, str], int]]
) -> None:
    operator = Operator(team, reports_releases=reports)
    operator.state = dataclasses.replace(operator.state, attention=(raised("rov"),))
    down: set[str] = set()
    deflected = False

    def check() -> None:
        moving = {name for name, speed in operator.speeds.items() if speed}
        assert moving <= ({operator.state.chosen} if not operator.state.peeked else set())

    for (action, what), ticks in steps:
        if action == "press":
            operator.press(what, repeat=reports and what in down)
            down.add(what)
        elif action == "lift" and reports and what in down:
            operator.lift(what)
            down.discard(what)
        elif action == "push":
            operator.push(float(what), repeat=deflected and what != "0")
            deflected = what != "0"
        elif action == "focus":
            operator.lose_focus()
        check()
        for _ in range(ticks):
            operator.wait(0.05)
            check()
    for key in sorted(down):
        operator.lift(key)
    operator.push(0.0)
    operator.wait(PEEK_S + 1.0)
    assert set(operator.speeds.values()) == {0.0}
    assert operator.state.peeked == ""
