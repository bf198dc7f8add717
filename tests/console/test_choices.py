"""Choosing robots, the help and the list of actions: whatever is done, every robot ends at rest."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.navigation import VELOCITY_COMMAND
from rune_tui.controls.keyboard import KeyboardHold
from rune_tui.dispatch import Dispatch
from rune_tui.layout.actions import actions_of
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ChooseRobot, Effect, SendEffect, StateEffect, ToggleHelp
from rune_tui.model.state_changes import changed
from rune_tui.startup.opening import open_layout
from tests.console.visualizers.conftest import Made

CHOOSING = """\
<rune>
  <robot name="magellan">
    <capability name="VIS_VID"/><capability name="VIS_PTZ"/><capability name="VIS_NIGHT"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/><capability name="NAV_GOAL"/>
    <capability name="PRO_MAP"/><capability name="PRO_POINTS"/><capability name="AUT_PILOT"/>
  </robot>
  <robot name="blimp" hub="tcp://127.0.0.1:1391">
    <capability name="VIS_VID"/><capability name="VIS_PTZ"/><capability name="VIS_NIGHT"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/><capability name="NAV_GOAL"/>
    <capability name="PRO_MAP"/><capability name="PRO_POINTS"/><capability name="AUT_PILOT"/>
  </robot>
  <view xsize="160" ysize="96">
    <widget handler="widgetChooseRobot"><event key="r"/></widget>
    <widget handler="widgetHelp"><event key="f1"/></widget>
    <viewport name="chosen" robot="*" xpos="0" ypos="0" xsize="80" ysize="96">
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate"/>
        <event key="a" control="rotate"/>
      </widget>
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetSafety"><event key="x"/></widget>
      <widget handler="widgetToggleNightMode"><event key="n"/></widget>
      <widget handler="widgetAutonomy"><event key="o"/></widget>
    </viewport>
    <viewport name="blimp" robot="blimp" xpos="80" ypos="0" xsize="80" ysize="96">
      <widget handler="widgetSetSpeed"><event key="i" control="translate"/></widget>
    </viewport>
  </view>
</rune>
"""


@pytest.fixture(scope="module")
def choosing(tmp_path_factory: pytest.TempPathFactory) -> LayoutSpec:
    path = tmp_path_factory.mktemp("layouts") / "choosing.xml"
    path.write_text(CHOOSING)
    return open_layout(path)


class Operator:
    """A keyboard, a clock that ticks 20 times a second, and effects executed as the app does."""

    def __init__(self, layout: LayoutSpec) -> None:
        self.dispatch = Dispatch(layout)
        self.keyboard = KeyboardHold()
        self.listed = [action for action in actions_of(layout) if action.at_once]
        robots = {robot.name: Made().robot().with_(name=robot.name) for robot in layout.robots}
        self.state = ConsoleState(now=0.0, robots=robots, chosen="magellan")
        self.at_rest = dict.fromkeys(robots, True)

    def execute(self, effects: Iterable[Effect]) -> None:
        for effect in effects:
            if isinstance(effect, SendEffect):
                if effect.definition is VELOCITY_COMMAND:
                    self.at_rest[effect.robot] = effect.value.neutral
            elif isinstance(effect, StateEffect):
                if isinstance(effect, ChooseRobot | ToggleHelp):
                    self.let_go()
                self.state = changed(self.state, effect)

    def let_go(self) -> None:
        self.keyboard.release_all(self.state.now)
        self.execute(self.dispatch.released(self.state))

    def wait(self, ticks: int) -> None:
        for _ in range(ticks):
            self.state = dataclasses.replace(self.state, now=self.state.now + 0.05)
            for event in self.keyboard.expire(self.state.now):
                self.execute(self.dispatch.handle(event, self.state))
            self.execute(self.dispatch.tick(self.state))

    def press(self, key: str) -> None:
        for event in self.keyboard.press(key, self.state.now):
            self.execute(self.dispatch.handle(event, self.state))

    def lift(self) -> None:
        for event in self.keyboard.expire(math.inf):
            self.execute(self.dispatch.handle(event, self.state))

    def choose(self, number: int) -> None:
        """Open the list, and choose from it."""
        self.let_go()
        assert all(self.at_rest.values())
        action = self.listed[number % len(self.listed)]
        self.execute(self.dispatch.act(action, self.state))


KEYS = ("w", "w", "a", "i", "space", "r", "r", "f1", "escape", "x", "n")


@given(
    actions=st.lists(
        st.tuples(st.sampled_from([*KEYS, "list", "up"]), st.integers(0, 14)),
        min_size=1,
        max_size=30,
    )
)
def test_whatever_is_chosen_helped_or_listed_every_robot_ends_at_rest(
    choosing: LayoutSpec, actions: list[tuple[str, int]]
):
    operator = Operator(choosing)
    for action, pause in actions:
        chosen = operator.state.chosen
        if action == "list":
            operator.choose(pause)
        elif action == "up":
            operator.lift()
        else:
            operator.press(action)
        if operator.state.chosen != chosen:
            assert operator.at_rest[chosen]
        operator.wait(pause)
    operator.wait(40)  # a press may be proven late, and then holds as long as a first one
    assert all(operator.at_rest.values())


def test_a_held_key_drives_the_next_robot_only_when_pressed_anew(choosing: LayoutSpec):
    operator = Operator(choosing)
    operator.press("w")
    assert operator.at_rest == {"magellan": False, "blimp": True}
    operator.press("r")
    assert operator.state.chosen == "blimp"
    operator.wait(2)
    assert all(operator.at_rest.values())
    operator.press("w")  # which repeats, as it is still down
    assert all(operator.at_rest.values())
    operator.wait(24)
    operator.press("w")
    operator.wait(10)
    assert operator.at_rest == {"magellan": True, "blimp": False}


def test_opening_the_help_stops_what_is_held(choosing: LayoutSpec):
    operator = Operator(choosing)
    operator.press("w")
    operator.press("f1")
    assert all(operator.at_rest.values())
    operator.press("i")
    operator.wait(2)
    assert all(operator.at_rest.values())
