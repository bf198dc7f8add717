"""Widgets of somebody else that fail, and speed widgets that share a robot: it ends at rest."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, Self

import pytest

from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import VELOCITY_COMMAND
from rune_tui.controls.events import ControlEvent, Hit
from rune_tui.dispatch import Dispatch
from rune_tui.layout.loader import load_layout
from rune_tui.layout.rules import HandlerRule, Vocabulary
from rune_tui.layout.spec import EventSpec, LayoutSpec, WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, SendEffect
from rune_tui.startup.opening import BUILT_IN

LAYOUT = """<rune>
  <robot name="magellan"><capability name="NAV_MOVE"/></robot>
  <robot name="blimp" hub="tcp://127.0.0.1:1391"><capability name="NAV_MOVE"/></robot>
  <view xsize="40" ysize="20">
    <viewport name="own" robot="magellan" xpos="0" ypos="0" xsize="20" ysize="20">
      <visualizer function="visualizeLink"/>{own}
    </viewport>
    <viewport name="chosen" robot="*" xpos="20" ypos="0" xsize="20" ysize="20">
      <visualizer function="visualizeLink"/>
      <widget handler="widgetSetSpeed">
        <event key="i" control="translate"/><event mouse="left" control="translate"/>
      </widget>
    </viewport>
  </view>
</rune>
"""
SPEED = '<widget handler="widgetSetSpeed"><event key="w" control="translate"/></widget>'
FOREIGN = '<widget handler="widgetForeign"><event key="f"/></widget>'


class Foreign:
    """Drives by itself until it is let go; fails where it is told to."""

    rule: ClassVar = HandlerRule(meaning="drives", sends=(VELOCITY_COMMAND.name,), held=True)
    faults: ClassVar[dict[str, Any]] = {}

    def __init__(self, robot: str) -> None:
        self.robot = robot
        self.driving = False

    @classmethod
    def from_spec(cls, spec: WidgetSpec, robot: str) -> Self:
        del spec
        return cls(robot)

    def handle(self, event: ControlEvent, spec: EventSpec, state: ConsoleState) -> Any:
        del spec, state
        self.driving = event.pressed
        return self._answer("press" if event.pressed else "let go")

    def tick(self, state: ConsoleState) -> Any:
        del state
        return self._answer("tick")

    def release(self, state: ConsoleState) -> Any:
        del state
        self.driving = False
        return self._answer("release")

    def _answer(self, when: str) -> Any:
        if when in self.faults:
            fault = self.faults[when]
            if isinstance(fault, Exception):
                raise fault
            return fault
        speed = TwistStamped.planar(0.4 if self.driving else 0.0, 0.0)
        return (SendEffect(robot=self.robot, definition=VELOCITY_COMMAND, value=speed),)


@pytest.fixture
def layout(tmp_path: Path) -> Callable[[str], LayoutSpec]:
    def made(own: str) -> LayoutSpec:
        path = tmp_path / "layout.xml"
        path.write_text(LAYOUT.format(own=own))
        widgets = {**BUILT_IN.widgets, "widgetForeign": Foreign}
        return load_layout(path, Vocabulary(visualizers=BUILT_IN.visualizers, widgets=widgets))

    return made


def at(now: float, chosen: str = "blimp") -> ConsoleState:
    return ConsoleState(now=now, chosen=chosen)


def key(name: str, *, pressed: bool = True) -> ControlEvent:
    return ControlEvent(name=name, pressed=pressed)


def click(viewport: str, *, pressed: bool = True) -> ControlEvent:
    hits = (Hit(viewport=viewport, x=0.5, y=0.5),) if viewport else ()
    return ControlEvent(name="mouse left", pressed=pressed, hits=hits)


def speeds(effects: tuple[Effect, ...], robot: str = "magellan") -> list[float]:
    sent = [each for each in effects if isinstance(each, SendEffect) and each.robot == robot]
    return [each.value.twist.linear.x for each in sent]


def told(effects: tuple[Effect, ...]) -> list[str]:
    return [each.notice.text for each in effects if isinstance(each, Notify)]


@pytest.mark.parametrize("when", ["press", "let go", "tick", "release"])
@pytest.mark.parametrize("fault", [ValueError("oh"), None, 5, ("wrong",)])
def test_a_widget_that_fails_is_told_of_and_its_robot_stands(
    layout: Callable[[str], LayoutSpec],
    monkeypatch: pytest.MonkeyPatch,
    when: str,
    fault: Any,
) -> None:
    dispatch = Dispatch(layout(FOREIGN))
    steps: list[Callable[[ConsoleState], tuple[Effect, ...]]] = [
        lambda state: dispatch.handle(key("f"), state),
        dispatch.tick,
        lambda state: dispatch.handle(key("f", pressed=False), state),
        dispatch.released,
    ]
    monkeypatch.setattr(Foreign, "faults", {when: fault})
    effects: tuple[Effect, ...] = ()
    for number, step in enumerate(steps):
        effects += step(at(number / 20))
    assert told(effects) == ["Foreign failed; the log says why"]
    assert speeds(effects)[-1] == 0.0
    later = sum((dispatch.tick(at(1.0 + number / 20)) for number in range(5)), ())
    assert not told(later)
    assert not any(speeds(later))
    monkeypatch.setattr(Foreign, "faults", {})
    assert speeds(dispatch.handle(key("f"), at(2.0))) == [0.4]


def test_a_widget_of_a_robot_and_one_of_the_chosen_robot_do_not_contradict_each_other(
    layout: Callable[[str], LayoutSpec],
) -> None:
    dispatch, state = Dispatch(layout(SPEED)), at(0.0, "magellan")
    dispatch.handle(key("w"), state)
    ticks = sum((dispatch.tick(at(1.0 + n / 20, "magellan")) for n in range(20)), ())
    assert set(speeds(ticks)) == {0.5}
    assert speeds(dispatch.handle(key("i"), at(2.0, "magellan"))) == [0.5]
    ticks = sum((dispatch.tick(at(2.0 + n / 20, "magellan")) for n in range(1, 21)), ())
    assert speeds(ticks) == [0.5] * 20
    assert speeds(dispatch.released(at(4.0, "magellan"))) == [0.0]


def test_both_robots_are_spoken_to_when_another_one_is_chosen(
    layout: Callable[[str], LayoutSpec],
) -> None:
    dispatch = Dispatch(layout(SPEED))
    dispatch.handle(key("i"), at(0.0, "magellan"))
    dispatch.released(at(0.1, "magellan"))
    assert speeds(dispatch.handle(key("i"), at(1.0, "blimp")), "blimp") == [0.5]
    ticks = dispatch.tick(at(2.0, "blimp"))
    assert (speeds(ticks, "magellan"), speeds(ticks, "blimp")) == ([0.0], [0.5])


def test_a_button_counts_as_held_until_it_goes_up_anywhere_or_all_is_let_go(
    layout: Callable[[str], LayoutSpec],
) -> None:
    dispatch, state = Dispatch(layout(SPEED)), at(0.0)
    dispatch.handle(click("own"), state)
    assert not dispatch.button_held
    dispatch.handle(click("chosen"), state)
    assert dispatch.button_held
    dispatch.handle(click("", pressed=False), state)
    assert not dispatch.button_held
    dispatch.handle(click("chosen"), state)
    dispatch.released(state)
    assert not dispatch.button_held
    assert dispatch.waits_for("mouse left")
    assert not dispatch.waits_for("mouse motion")


def test_a_key_and_a_button_on_one_widget_drive_until_both_are_up(
    layout: Callable[[str], LayoutSpec],
) -> None:
    dispatch = Dispatch(layout(SPEED))
    sent = [
        speeds(dispatch.handle(event, dataclasses.replace(at(0.0), now=number / 10)), "blimp")
        for number, event in enumerate(
            (key("i"), click("chosen"), key("i", pressed=False), click("own", pressed=False))
        )
    ]
    assert sent == [[0.5], [0.5], [0.5], [0.0]]
