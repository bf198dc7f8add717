"""One operator with eight robots: keys, the strip, the queue and the next alarm."""

from __future__ import annotations

import dataclasses
import shutil

import pytest

from rune_tui.compositor.picture import plain_text
from rune_tui.controls.events import ControlEvent
from rune_tui.dispatch import Dispatch
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, StateEffect
from rune_tui.model.state_changes import changed
from rune_tui.startup.opening import open_layout
from rune_tui.view import View
from tests.console.dispatching import stops
from tests.console.situations import NOW, ROOT, robot
from tests.support.cases import for_each

NAMES = [f"r{number}" for number in range(1, 9)]
ROBOT = """\
  <include file="parts/robot.xml">
    <variable name="robot" value="{name}"/><variable name="hub" value="tcp://127.0.0.1:{port}"/>
  </include>
"""
SMALL = """\
    <viewport name="{name} camera" title="{number} {{robot}}" robot="{name}"
              xpos="{x}" ypos="20" xsize="14" ysize="14">
      <visualizer function="visualizeCameraImage"/>
      <include file="parts/team-robot.xml">
        <variable name="robot" value="{name}"/><variable name="key" value="{number}"/>
      </include>
    </viewport>
"""


@pytest.fixture(scope="module")
def eight(tmp_path_factory: pytest.TempPathFactory) -> LayoutSpec:
    folder = tmp_path_factory.mktemp("layouts")
    shutil.copytree(ROOT / "layouts" / "parts", folder / "parts")
    robots = "".join(
        ROBOT.format(name=name, port=1381 + 10 * number) for number, name in enumerate(NAMES)
    )
    small = "".join(
        SMALL.format(name=name, number=number, x=15 * (number - 1))
        for number, name in enumerate(NAMES, 1)
    )
    (folder / "eight.xml").write_text(f"""\
<rune>
{robots}
  <include file="parts/joystick.xml"/>
  <view xsize="120" ysize="80">
    <widget handler="widgetNextAlarm"><event key="n"/></widget>
    <widget handler="widgetPeek"><event key="'"/></widget>
    <viewport name="team" robot="*" zpos="6" xpos="0" ypos="0" xsize="120" ysize="18">
      <visualizer function="visualizeTeam"/>
    </viewport>
    {small}
    <viewport name="attention" title="alarms" robot="*" xpos="80" ypos="36" xsize="40" ysize="20">
      <visualizer function="visualizeAttention"/>
    </viewport>
    <viewport name="camera" title="{{robot}}" robot="*" xpos="0" ypos="36" xsize="78" ysize="44">
      <visualizer function="visualizeCameraImage"/>
      <widget handler="widgetSetSpeed"><event key="w" control="translate"/></widget>
      <widget handler="widgetStop"><event key="space"/></widget>
    </viewport>
  </view>
</rune>
""")
    return open_layout(folder / "eight.xml")


def console(layout: LayoutSpec, **ill: float) -> ConsoleState:
    """The state of a console, with the charge of robots whose battery is low."""
    robots = {name: robot(name, battery_fraction=ill.get(name, 0.9)) for name in NAMES}
    return dataclasses.replace(ConsoleState.at_start(layout, NOW), robots=robots)


class Desk:
    """A view and a dispatch whose effects change the console's state."""

    def __init__(self, layout: LayoutSpec, state: ConsoleState) -> None:
        self.view, self.dispatch, self.state = View(layout), Dispatch(layout), state
        self.view.resize(120, 40)

    def lines(self) -> list[str]:
        cells = self.view.render(self.state)
        assert cells is not None
        self.state = dataclasses.replace(self.state, attention=self.view.attention)
        return plain_text(cells).splitlines()

    def press(self, key: str) -> tuple[Effect, ...]:
        effects = self.dispatch.handle(ControlEvent(name=key, pressed=True), self.state)
        for effect in effects:
            if isinstance(effect, StateEffect):
                self.state = changed(self.state, effect)
        return effects


def test_digits_choose_each_of_eight_robots(eight: LayoutSpec) -> None:
    desk = Desk(eight, console(eight))
    for number, name in enumerate(NAMES, 1):
        desk.press(str(number))
        assert desk.state.chosen == name
        row = desk.lines()[number - 1]
        assert row.startswith(str(number))
        assert f"▶ {name}" in row
        assert "seen now" in row


def test_space_stops_the_chosen_one_and_zero_all_eight(eight: LayoutSpec) -> None:
    desk = Desk(eight, console(eight))
    desk.press("5")
    assert stops(desk.press("space")) == ["r5"]
    assert stops(desk.press("0")) == NAMES


def test_the_next_alarm_goes_through_all_that_have_one(eight: LayoutSpec) -> None:
    desk = Desk(eight, console(eight, r3=0.15, r7=0.05, r8=0.15))
    visited = []
    for _ in range(4):
        desk.lines()
        desk.press("n")
        visited.append(desk.state.chosen)
    assert visited == ["r7", "r3", "r8", "r7"]


def test_the_queue_and_the_strip_show_all_eight(eight: LayoutSpec) -> None:
    desk = Desk(eight, console(eight, **dict.fromkeys(NAMES, 0.05)))
    text = "\n".join(desk.lines())
    for name in NAMES:
        assert f"{name}  0 s  BATTERY CRITICAL" in text
        assert f"{name} " in text
    assert text.count("!! BATTERY CRITICAL") >= len(NAMES)


@for_each("size", [(120, 40), (80, 24), (40, 12), (20, 6)])
def test_the_view_of_eight_fits_any_terminal(eight: LayoutSpec, size: tuple[int, int]) -> None:
    desk = Desk(eight, console(eight, r8=0.05))
    desk.view.resize(*size)
    assert "r8" in "\n".join(desk.lines())
