"""What sticks, buttons, hats and balls do to widgets; whatever they do, the robot ends at rest."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.navigation import STOP, VELOCITY_COMMAND
from hub.gcm.vision import CAMERA_COMMAND, CameraCommand
from rune_tui.controls.events import ControlEvent
from rune_tui.dispatch import Dispatch
from rune_tui.layout.actions import actions_of
from rune_tui.layout.rules import Options
from rune_tui.layout.spec import ControlKind, EventSpec, LayoutSpec, WidgetSpec
from rune_tui.model.effects import Effect, QuitEffect, SendEffect, Zoom
from rune_tui.model.joystick_state import JoystickState
from rune_tui.startup.opening import open_layout
from rune_tui.widgets.registry import WIDGETS
from rune_tui.widgets.speed import SetSpeed
from rune_tui.widgets.widget import Widget
from tests.console.widgets.presses import at, down, event_spec, spec, up

AXIS, BUTTON, HAT, BALL = ControlKind.AXIS, ControlKind.BUTTON, ControlKind.HAT, ControlKind.BALL


def stick_spec(
    control: str = "", name: str = "y", value: float = 1.0, kind: ControlKind = AXIS
) -> EventSpec:
    return EventSpec(name=f"joystick pad {name}", control=control, value=value, line=1, kind=kind)


FORWARD = stick_spec("translate", "y")
TURN = stick_spec("rotate", "x", -1.0)
ENABLE = stick_spec("enable", "leftshoulder", kind=BUTTON)
TURBO = stick_spec("turbo", "a", kind=BUTTON)
W = event_spec("w", "translate")
S = event_spec("s", "translate", -1.0)


def moved(spec: EventSpec, value: float, *, on: bool = False) -> ControlEvent:
    """An axis leaves neutral, or is `on` its way already, or is back in neutral."""
    return ControlEvent(
        name=spec.name, pressed=value != 0.0, repeat=on and value != 0.0, value=value
    )


def pushed(spec: EventSpec) -> ControlEvent:
    return ControlEvent(name=spec.name, pressed=True)


def let_go(spec: EventSpec) -> ControlEvent:
    return ControlEvent(name=spec.name, pressed=False, value=0.0)


def speed(*events: EventSpec, **options: float) -> SetSpeed:
    rule = SetSpeed.rule
    said = WidgetSpec(
        handler="widgetSetSpeed", options=Options.of(rule.options, options), events=events
    )
    return SetSpeed.from_spec(said, "magellan")


def driven(effects: Iterable[Effect]) -> list[tuple[float, float]]:
    """The speeds that were sent."""
    return [
        (effect.value.twist.linear.x, effect.value.twist.angular.z)
        for effect in effects
        if isinstance(effect, SendEffect) and effect.definition is VELOCITY_COMMAND
    ]


def test_a_stick_drives_as_far_as_it_is_moved_and_sends_zero_at_once_in_neutral():
    widget = speed()
    assert driven(widget.handle(moved(FORWARD, 0.1), FORWARD, at(0.0))) == [(0.05, 0.0)]
    assert driven(widget.handle(moved(TURN, 0.5), TURN, at(0.001))) == [(0.05, -0.5)]
    assert driven(widget.handle(moved(FORWARD, 0.0), FORWARD, at(0.002))) == [(0.0, -0.5)]
    assert driven(widget.handle(moved(TURN, 0.0), TURN, at(0.003))) == [(0.0, 0.0)]


def test_a_stick_that_moves_on_is_followed_at_once_or_by_the_next_tick():
    widget = speed()
    widget.handle(moved(FORWARD, 0.1), FORWARD, at(0.0))
    assert widget.handle(moved(FORWARD, 0.4, on=True), FORWARD, at(0.019)) == ()
    assert driven(widget.tick(at(0.02))) == [(0.2, 0.0)]
    assert widget.tick(at(0.021)) == ()
    assert driven(widget.handle(moved(FORWARD, 1.0, on=True), FORWARD, at(0.041))) == [(0.5, 0.0)]


def test_a_moving_stick_sends_fifty_times_a_second_at_most():
    widget = speed()
    sent = list(driven(widget.handle(moved(FORWARD, 0.1), FORWARD, at(0.0))))
    for millisecond in range(1, 1000):
        now = at(millisecond / 1000)
        value = 0.1 + millisecond / 2000
        sent += driven(widget.handle(moved(FORWARD, value, on=True), FORWARD, now))
        if millisecond % 50 == 0:
            sent += driven(widget.tick(now))
    assert 40 <= len(sent) <= 71


def test_of_keys_and_sticks_the_newest_that_is_not_neutral_counts():
    widget = speed()
    widget.handle(down("w"), W, at(0.0))
    assert driven(widget.handle(moved(FORWARD, -0.2), FORWARD, at(0.1))) == [(-0.1, 0.0)]
    assert driven(widget.handle(moved(FORWARD, -0.4, on=True), FORWARD, at(0.2))) == [(-0.2, 0.0)]
    assert driven(widget.handle(down("s"), S, at(0.3))) == [(-0.5, 0.0)]
    assert driven(widget.handle(moved(FORWARD, 1.0, on=True), FORWARD, at(0.4))) == [(-0.5, 0.0)]
    assert driven(widget.handle(up("s"), S, at(0.5))) == [(0.5, 0.0)]
    assert driven(widget.handle(moved(FORWARD, 0.0), FORWARD, at(0.6))) == [(0.5, 0.0)]
    assert driven(widget.handle(up("w"), W, at(0.7))) == [(0.0, 0.0)]


def test_a_stick_still_held_forward_turns_nothing_when_the_hand_wobbles_aside():
    widget = speed(FORWARD, TURN)
    pad = JoystickState(name="pad", waiting=frozenset({"y"}))
    held = dataclasses.replace(at(0.0), joysticks={"pad": pad})
    assert widget.handle(moved(TURN, 0.2), TURN, held) == ()
    assert widget.handle(moved(TURN, 1.0, on=True), TURN, at(0.1)) == ()
    widget.handle(moved(TURN, 0.0), TURN, at(0.2))
    assert driven(widget.handle(moved(TURN, 0.5), TURN, at(0.3))) == [(0.0, -0.5)]


def test_after_all_was_let_go_nothing_drives_before_every_stick_was_neutral():
    widget = speed()
    widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.0))
    widget.handle(moved(TURN, 0.5), TURN, at(0.0))
    assert driven(widget.release(at(0.1))) == [(0.0, 0.0)]
    assert widget.handle(moved(FORWARD, 1.0, on=True), FORWARD, at(0.2)) == ()
    assert widget.handle(moved(FORWARD, 0.0), FORWARD, at(0.3)) == ()
    assert widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.4)) == ()
    assert widget.handle(moved(TURN, 0.0), TURN, at(0.5)) == ()
    assert widget.velocity().neutral
    assert widget.handle(moved(FORWARD, 0.6, on=True), FORWARD, at(0.6)) == ()
    assert widget.handle(moved(FORWARD, 0.0), FORWARD, at(0.7)) == ()
    assert driven(widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.8))) == [(0.25, 0.0)]


def test_a_stick_that_was_moved_before_anybody_looked_has_to_be_neutral_first():
    widget = speed()
    assert widget.handle(moved(FORWARD, 0.5, on=True), FORWARD, at(0.0)) == ()
    assert widget.handle(moved(FORWARD, 0.0), FORWARD, at(0.1)) == ()
    assert driven(widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.2))) == [(0.25, 0.0)]


def test_a_stick_that_was_neutral_unseen_counts_when_it_leaves_neutral():
    widget = speed()
    widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.0))
    widget.release(at(0.1))
    assert driven(widget.handle(moved(FORWARD, 0.4), FORWARD, at(0.2))) == [(0.2, 0.0)]
    assert driven(widget.handle(moved(TURN, 1.0), TURN, at(0.3))) == [(0.2, -1.0)]


def test_keys_drive_while_a_stick_has_to_be_neutral_first():
    widget = speed()
    widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.0))
    widget.release(at(0.1))
    assert driven(widget.handle(down("w"), W, at(0.2))) == [(0.5, 0.0)]


def test_sticks_count_only_while_the_dead_man_button_is_held_and_from_neutral():
    widget = speed(ENABLE, FORWARD)
    assert widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.0)) == ()
    assert driven(widget.handle(pushed(ENABLE), ENABLE, at(0.1))) == [(0.0, 0.0)]
    assert widget.handle(moved(FORWARD, 0.6, on=True), FORWARD, at(0.2)) == ()
    widget.handle(moved(FORWARD, 0.0), FORWARD, at(0.3))
    assert driven(widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.4))) == [(0.25, 0.0)]
    assert driven(widget.handle(let_go(ENABLE), ENABLE, at(0.5))) == [(0.0, 0.0)]
    assert driven(widget.handle(pushed(ENABLE), ENABLE, at(0.6))) == [(0.0, 0.0)]
    assert widget.handle(moved(FORWARD, 0.7, on=True), FORWARD, at(0.7)) == ()


def test_of_two_dead_man_buttons_one_is_enough():
    other = stick_spec("enable", "rightshoulder", kind=BUTTON)
    widget = speed(ENABLE, other, FORWARD)
    widget.handle(pushed(ENABLE), ENABLE, at(0.0))
    widget.handle(pushed(other), other, at(0.0))
    widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.0))
    assert driven(widget.handle(let_go(ENABLE), ENABLE, at(0.1))) == [(0.25, 0.0)]
    assert driven(widget.handle(let_go(other), other, at(0.2))) == [(0.0, 0.0)]


def test_keys_need_no_dead_man_button():
    widget = speed(ENABLE, W)
    assert driven(widget.handle(down("w"), W, at(0.0))) == [(0.5, 0.0)]


def test_the_dead_man_button_has_to_be_pressed_anew_after_all_was_let_go():
    widget = speed(ENABLE, FORWARD)
    widget.handle(pushed(ENABLE), ENABLE, at(0.0))
    widget.release(at(0.1))
    assert widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.2)) == ()


def test_turbo_makes_all_faster_while_it_is_held():
    widget = speed(turbo_factor=1.5)
    widget.handle(moved(FORWARD, 0.5), FORWARD, at(0.0))
    widget.handle(moved(TURN, 1.0), TURN, at(0.0))
    assert driven(widget.handle(pushed(TURBO), TURBO, at(0.1))) == [(0.375, -1.5)]
    assert driven(widget.handle(let_go(TURBO), TURBO, at(0.2))) == [(0.25, -1.0)]


def test_a_release_that_calls_itself_a_repeat_is_a_release():
    widget = speed()
    button = stick_spec("translate", "a", kind=BUTTON)
    widget.handle(pushed(button), button, at(0.0))
    again = ControlEvent(name=button.name, pressed=False, repeat=True, value=0.0)
    assert driven(widget.handle(again, button, at(0.1))) == [(0.0, 0.0)]


class Hands:
    """Two sticks, two keys and a dead-man button in the hands of somebody, as devices tell."""

    def __init__(self, widget: SetSpeed) -> None:
        self.widget = widget
        self.now = 0.0
        self.out: dict[EventSpec, float] = {}
        self.not_neutral_at_forget: set[EventSpec] = set()

    def do(self, spec: EventSpec, value: float) -> None:
        """An input is at a value now."""
        self.now += 0.013
        before = self.out.get(spec, 0.0)
        self.out[spec] = value
        if value or before:
            event = ControlEvent(
                name=spec.name,
                pressed=value != 0.0,
                repeat=bool(value and before),
                value=value if spec.kind is AXIS else 1.0,
            )
            self.widget.handle(event, spec, at(self.now))
        if not value:
            self.not_neutral_at_forget.discard(spec)

    def forget(self) -> None:
        self.widget.forget()
        self.not_neutral_at_forget |= {
            spec for spec, value in self.out.items() if value and spec.kind is AXIS
        }


INPUTS = [FORWARD, TURN, W, S, ENABLE, TURBO]
VALUES = st.sampled_from([0.0, 0.0, 0.2, 1.0, -0.7])
STEPS = st.lists(
    st.one_of(st.tuples(st.sampled_from(INPUTS), VALUES), st.just("forget"), st.just("release")),
    max_size=40,
)


@given(steps=STEPS, guarded=st.booleans())
def test_whatever_hands_do_when_all_is_neutral_the_speed_is_zero(
    steps: list[Any],
    guarded: bool,  # noqa: FBT001 - hypothesis gives it by name
):
    widget = speed(*(INPUTS if guarded else [FORWARD, TURN, W, S]))
    hands = Hands(widget)
    for step in steps:
        if step == "forget":
            hands.forget()
        elif step == "release":
            assert driven(widget.release(at(hands.now))) == [(0.0, 0.0)]
        else:
            hands.do(*step)
    for each in INPUTS:
        hands.do(each, 0.0)
    assert widget.velocity().neutral
    hands.do(ENABLE, 1.0)
    hands.do(FORWARD, 0.5)
    assert not widget.velocity().neutral


@given(steps=STEPS, guarded=st.booleans())
def test_after_what_is_held_was_forgotten_no_stick_drives_before_all_were_neutral(
    steps: list[Any],
    guarded: bool,  # noqa: FBT001 - hypothesis gives it by name
):
    widget = speed(*([ENABLE] if guarded else []), FORWARD, TURN)
    hands = Hands(widget)
    for step in steps:
        if isinstance(step, str):
            hands.forget()
        elif step[0] not in {W, S}:
            hands.do(*step)
        if hands.not_neutral_at_forget or (guarded and not hands.out.get(ENABLE)):
            assert widget.velocity().neutral


PAD = """<rune><robot name="magellan"><capability name="NAV_MOVE"/><capability name="VIS_PTZ"/>
<capability name="VIS_NIGHT"/></robot>
<joystick name="pad"><control name="ball" type="ball" usage="wheel"/></joystick>
<view xsize="80" ysize="48">
  <widget handler="widgetQuit"><event joystick="pad" button="guide"/></widget>
  <viewport name="camera" xpos="0" ypos="0" xsize="80" ysize="48">
    <widget handler="widgetSetSpeed">
      <event joystick="pad" axis="lefty" control="translate"/>
      <event joystick="pad" axis="leftx" control="rotate" value="-1"/>
      <event joystick="pad" button="leftshoulder" control="enable"/>
    </widget>
    <widget handler="widgetSetSpeed"><event key="w" control="translate"/></widget>
    <widget handler="widgetStop"><event joystick="pad" button="b"/></widget>
    <widget handler="widgetAdjustPanTilt"><event joystick="pad" hat="dpad"/></widget>
    <widget handler="widgetAdjustZoom"><event joystick="pad" ball="ball"/></widget>
    <widget handler="widgetHomePTZ"><event joystick="pad" button="righttrigger"/></widget>
  </viewport>
</view></rune>"""


@pytest.fixture(scope="module")
def layout(tmp_path_factory: pytest.TempPathFactory) -> LayoutSpec:
    path = Path(tmp_path_factory.mktemp("layouts")) / "pad.xml"
    path.write_text(PAD)
    return open_layout(path)


def pad(name: str, value: float = 1.0, *, on: bool = False) -> ControlEvent:
    return ControlEvent(
        name=f"joystick pad {name}", pressed=value != 0.0, repeat=on and value != 0.0, value=value
    )


def test_a_stick_that_drives_takes_over_and_one_that_is_not_enabled_does_not(layout: LayoutSpec):
    dispatch = Dispatch(layout)
    dispatch.handle(down("w"), at(0.0))
    assert dispatch.handle(pad("lefty", 0.5), at(0.1)) == ()
    assert driven(dispatch.tick(at(0.2))) == [(0.5, 0.0)]
    dispatch.handle(pad("lefty", 0.0), at(0.3))
    assert driven(dispatch.handle(pad("leftshoulder"), at(0.4))) == [(0.0, 0.0)]
    assert driven(dispatch.handle(pad("lefty", -0.5), at(0.5))) == [(-0.25, 0.0)]
    assert driven(dispatch.tick(at(0.6))) == [(-0.25, 0.0)]
    assert driven(dispatch.handle(down("w"), at(0.7))) == [(0.5, 0.0)]
    assert driven(dispatch.handle(pad("lefty", -0.6, on=True), at(0.8))) == []
    assert driven(dispatch.handle(up("w"), at(0.9))) == [(0.0, 0.0)]


def test_after_a_stop_a_held_stick_stays_without_effect(layout: LayoutSpec):
    dispatch = Dispatch(layout)
    dispatch.handle(pad("leftshoulder"), at(0.0))
    dispatch.handle(pad("lefty", 0.5), at(0.0))
    stopped = dispatch.handle(pad("b"), at(0.1))
    assert isinstance(stopped[0], SendEffect)
    assert stopped[0].definition is STOP
    assert driven(stopped) == [(0.0, 0.0)]
    dispatch.handle(pad("b", 0.0), at(0.15))
    sent = driven(dispatch.handle(pad("lefty", 0.9, on=True), at(0.2)))
    for number in range(1, 60):
        sent += driven(dispatch.tick(at(0.2 + number / 20)))
    assert set(sent) == {(0.0, 0.0)}


def test_buttons_wake_widgets_as_keys_do(layout: LayoutSpec):
    dispatch = Dispatch(layout)
    assert dispatch.handle(pad("guide"), at(0.0)) == (QuitEffect(),)
    assert dispatch.handle(pad("guide", 0.0), at(0.1)) == ()
    assert len(dispatch.handle(pad("righttrigger pressed"), at(0.2))) == 1
    assert dispatch.handle(pad("righttrigger", 0.5), at(0.3)) == ()


def camera(effects: Iterable[Effect]) -> list[CameraCommand]:
    return [
        effect.value
        for effect in effects
        if isinstance(effect, SendEffect) and effect.definition is CAMERA_COMMAND
    ]


def test_a_held_hat_goes_on_stepping_as_a_held_key_does(layout: LayoutSpec):
    dispatch = Dispatch(layout)
    left = CameraCommand(pan=math.radians(5))
    assert camera(dispatch.handle(pad("dpad left"), at(0.0))) == [left]
    times = [number / 20 for number in range(1, 21)]
    stepped = [now for now in times if camera(dispatch.tick(at(now))) == [left]]
    assert stepped == [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]
    dispatch.handle(pad("dpad left", 0.0), at(1.01))
    assert camera(dispatch.tick(at(1.5))) == []


def test_a_stop_ends_the_steps_of_what_is_held(layout: LayoutSpec):
    dispatch = Dispatch(layout)
    dispatch.handle(pad("dpad up"), at(0.0))
    dispatch.handle(pad("b"), at(0.1))
    assert camera(dispatch.tick(at(1.0))) == []


def test_a_ball_steps_by_its_counts(layout: LayoutSpec):
    dispatch = Dispatch(layout)
    assert camera(dispatch.handle(pad("ball", -3.0), at(0.0))) == [CameraCommand(zoom=-0.05 * 3)]
    assert camera(dispatch.tick(at(1.0))) == []


def test_what_is_chosen_from_a_list_is_done_once(layout: LayoutSpec):
    dispatch = Dispatch(layout)
    (action,) = (each for each in actions_of(layout) if each.inputs == ("pad hat down",))
    assert camera(dispatch.act(action, at(0.0))) == [CameraCommand(tilt=-math.radians(3))]
    assert camera(dispatch.tick(at(5.0))) == []


def zoomed(handler: str) -> Widget:
    return WIDGETS[handler].from_spec(spec(handler), "magellan")


def test_a_stick_moves_the_camera_ten_times_a_second_the_faster_the_further():
    widget, rate = zoomed("widgetAdjustZoom"), stick_spec()
    assert camera(widget.handle(moved(rate, 0.2), rate, at(0.0))) == [
        CameraCommand(zoom=0.2 * 0.05)
    ]
    assert widget.handle(moved(rate, 0.6, on=True), rate, at(0.01)) == ()
    sent = [camera(widget.tick(at(number / 20))) for number in range(1, 201)]
    assert list(itertools.chain(*sent)) == [CameraCommand(zoom=0.6 * 0.05)] * 100
    assert widget.handle(moved(rate, 0.0), rate, at(10.1)) == ()
    assert widget.tick(at(11.0)) == ()


def test_a_stick_that_is_held_after_all_was_let_go_moves_no_camera():
    widget, rate = zoomed("widgetAdjustZoom"), stick_spec()
    widget.handle(moved(rate, 0.2), rate, at(0.0))
    assert widget.release(at(0.1)) == ()
    assert widget.handle(moved(rate, 0.5, on=True), rate, at(0.2)) == ()
    assert widget.tick(at(1.0)) == ()


def test_a_stalled_clock_makes_one_step_and_no_burst():
    widget, rate = zoomed("widgetAdjustZoom"), stick_spec()
    widget.handle(moved(rate, 0.2), rate, at(0.0))
    sent = [widget.tick(at(60.0 + number / 1000)) for number in range(20)]
    assert [bool(effects) for effects in sent] == [True] + [False] * 19


def test_a_stick_zooms_the_map():
    widget, rate = zoomed("widgetZoomMap"), stick_spec()
    assert widget.handle(moved(rate, -1.0), rate, at(0.0)) == (
        Zoom(viewport="camera", factor=1 / 1.25),
    )
    assert widget.tick(at(0.1)) == (Zoom(viewport="camera", factor=1 / 1.25),)


def test_a_button_that_counts_when_it_goes_up_does_not_go_on_stepping():
    widget = zoomed("widgetAdjustZoom")
    late = EventSpec(
        name="joystick pad a", control="", value=1.0, line=1, released=True, kind=BUTTON
    )
    assert widget.handle(pushed(late), late, at(0.0)) == ()
    assert widget.tick(at(1.0)) == ()
    assert camera(widget.handle(let_go(late), late, at(1.1))) == [CameraCommand(zoom=0.05)]
    assert widget.tick(at(2.0)) == ()


SHIPPED = Path(__file__).parents[3] / "layouts"


@pytest.mark.parametrize(
    "path",
    [path for path in sorted(SHIPPED.glob("*.xml")) if path.stem not in {"minimal", "xroboview"}],
    ids=lambda path: path.stem,
)
def test_in_shipped_layouts_the_left_stick_drives_one_robot_and_b_stops_all(path: Path):
    """In the layout of a team they are for the robot that is chosen."""
    layout = open_layout(path)
    dispatch = Dispatch(layout)
    names = [robot.name for robot in layout.robots]
    state = dataclasses.replace(at(0.0), chosen=names[0])
    assert driven(dispatch.handle(pad("lefty", 0.5), state)) == [(0.25, 0.0)]
    assert driven(dispatch.handle(pad("leftx", 0.5), state)) == [(0.25, -0.5)]
    stopped = [
        effect.robot
        for effect in dispatch.handle(pad("b"), state)
        if isinstance(effect, SendEffect) and effect.definition is STOP
    ]
    assert stopped == (names[:1] if path.stem == "land-sea-air" else names)
