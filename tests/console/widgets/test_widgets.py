"""What each widget sends."""

from __future__ import annotations

import dataclasses
import itertools
import math

import pytest

from hub.gcm.autopilot import AUTOPILOT_STATE
from hub.gcm.body import ROBOT_DESCRIPTION, HoldBody, HoldKind, JointBody, LightBody
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import STOP, VELOCITY_COMMAND
from hub.gcm.vision import CAMERA_COMMAND, CameraCommand, CameraMotion
from rune_tui.controls.events import ControlEvent
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, QuitEffect, SendEffect, ShowGhost
from rune_tui.model.state_changes import changed
from rune_tui.widgets.registry import WIDGETS
from rune_tui.widgets.speed import SetSpeed
from tests.console.visualizers.conftest import received
from tests.console.widgets.presses import (
    LANDMARK,
    again,
    at,
    click,
    down,
    event_spec,
    marked,
    seeing,
    spec,
    up,
)
from tests.support.autopilot import ROVER
from tests.support.cases import for_each
from tests.support.magellan import magellan_body

W = event_spec("w", "translate", 1.0)
S = event_spec("s", "translate", -1.0)
A = event_spec("a", "rotate", 1.0)
D = event_spec("d", "rotate", -1.0)


def speed(**options: float) -> SetSpeed:
    return SetSpeed.from_spec(spec("widgetSetSpeed", **options), "magellan")


def velocity(linear: float, angular: float) -> tuple[SendEffect]:
    twist = TwistStamped.planar(linear, angular)
    return (SendEffect(robot="magellan", definition=VELOCITY_COMMAND, value=twist),)


def camera(command: CameraCommand) -> tuple[SendEffect]:
    return (SendEffect(robot="magellan", definition=CAMERA_COMMAND, value=command),)


def test_a_press_drives_at_once_and_a_release_sends_zero_at_once():
    widget = speed()
    assert widget.handle(down("w"), W, at(1.0)) == velocity(0.5, 0.0)
    assert widget.handle(up("w"), W, at(1.01)) == velocity(0.0, 0.0)


def test_value_and_options_scale_the_speed():
    widget = speed(linear=2.0, angular=0.25)
    half = event_spec("e", "translate", 0.5)
    assert widget.handle(down("e"), half, at(0.0)) == velocity(1.0, 0.0)
    assert widget.handle(down("d"), D, at(0.0)) == velocity(1.0, -0.25)


def test_the_two_controls_do_not_disturb_each_other():
    widget = speed()
    widget.handle(down("w"), W, at(0.0))
    assert widget.handle(down("a"), A, at(0.0)) == velocity(0.5, 1.0)
    assert widget.handle(up("w"), W, at(0.1)) == velocity(0.0, 1.0)
    assert widget.handle(up("a"), A, at(0.2)) == velocity(0.0, 0.0)


def test_of_two_opposed_keys_the_newest_wins_and_gives_way_when_it_goes_up():
    widget = speed()
    widget.handle(down("w"), W, at(0.0))
    assert widget.handle(down("s"), S, at(0.1)) == velocity(-0.5, 0.0)
    assert widget.handle(up("s"), S, at(0.2)) == velocity(0.5, 0.0)
    widget.handle(down("s"), S, at(0.3))
    assert widget.handle(up("w"), W, at(0.4)) == velocity(-0.5, 0.0)


def test_repeats_send_nothing_because_ticks_do():
    widget = speed()
    widget.handle(down("w"), W, at(0.0))
    assert widget.handle(again("w"), W, at(0.01)) == ()


def test_the_release_of_a_key_that_does_not_drive_sends_nothing():
    assert speed().handle(up("w"), W, at(0.0)) == ()


def test_after_a_release_of_all_a_held_key_drives_only_when_pressed_anew():
    widget = speed()
    widget.handle(down("w"), W, at(0.0))
    assert not widget.velocity().neutral
    assert widget.release(at(0.1)) == velocity(0.0, 0.0)
    assert widget.velocity().neutral
    assert widget.handle(again("w"), W, at(0.2)) == ()
    assert widget.handle(up("w"), W, at(0.3)) == ()
    assert widget.handle(down("w"), W, at(0.4)) == velocity(0.5, 0.0)


@pytest.mark.parametrize(("held", "rate"), [("w", 20), ("", 5)])
@pytest.mark.parametrize("tick_hz", [20, 60, 200])
def test_the_rate_is_twenty_while_held_and_five_while_not(held: str, rate: int, tick_hz: int):
    widget = speed()
    if held:
        widget.handle(down("w"), W, at(1000.013))
    seconds = 30
    times = [1000.02 + number / tick_hz for number in range(seconds * tick_hz)]
    sent = [now for now in times if widget.tick(at(now))]
    assert abs(len(sent) - rate * seconds) <= 2


def test_a_jittering_clock_leaves_no_gap_of_more_than_two_ticks():
    widget = speed()
    widget.handle(down("w"), W, at(0.0))
    times = [number / 20 + 0.012 * math.sin(number * 1.7) for number in range(1, 400)]
    sent = [0.0] + [now for now in times if widget.tick(at(now))]
    assert max(after - before for before, after in itertools.pairwise(sent)) < 0.125
    assert len(sent) > 390


def test_a_stalled_clock_makes_no_burst():
    widget = speed()
    widget.handle(down("w"), W, at(0.0))
    sent = [widget.tick(at(60.0 + number / 1000)) for number in range(20)]
    assert [bool(effects) for effects in sent] == [True] + [False] * 19


def test_a_stop_is_sent_at_every_press_and_repeat_with_its_reason():
    widget = WIDGETS["widgetStop"].from_spec(spec("widgetStop"), "magellan")
    for event in (down("space"), again("space")):
        (effect,) = widget.handle(event, event_spec("space"), at(0.0))
        assert isinstance(effect, SendEffect)
        assert (effect.robot, effect.definition) == ("magellan", STOP)
        assert "space" in effect.value.reason
    assert widget.handle(up("space"), event_spec("space"), at(0.0)) == ()


@for_each(
    ("handler", "options", "value", "command"),
    [
        ("widgetAdjustPan", {}, 1.0, CameraCommand(pan=math.radians(5))),
        ("widgetAdjustPan", {"step_deg": 10}, -0.5, CameraCommand(pan=-math.radians(5))),
        ("widgetAdjustTilt", {}, 1.0, CameraCommand(tilt=math.radians(3))),
        ("widgetAdjustTilt", {"step_deg": 1}, -1.0, CameraCommand(tilt=-math.radians(1))),
        ("widgetAdjustZoom", {}, 1.0, CameraCommand(zoom=0.05)),
        ("widgetAdjustZoom", {"step": 0.2}, -1.0, CameraCommand(zoom=-0.2)),
    ],
)
def test_the_camera_moves_a_step_at_every_press_and_repeat(
    handler: str, options: dict[str, float], value: float, command: CameraCommand
):
    assert command.motion is CameraMotion.RELATIVE
    widget = WIDGETS[handler].from_spec(spec(handler, **options), "magellan")
    key = event_spec("x", value=value)
    assert widget.handle(down("x"), key, at(0.0)) == camera(command)
    assert widget.handle(again("x"), key, at(0.1)) == camera(command)
    assert widget.handle(up("x"), key, at(0.2)) == ()


@for_each(
    ("control", "value", "command"),
    [
        ("pan", 1.0, CameraCommand(pan=math.radians(5))),
        ("pan", -2.0, CameraCommand(pan=-math.radians(10))),
        ("tilt", 1.0, CameraCommand(tilt=math.radians(4))),
        ("tilt", -0.5, CameraCommand(tilt=-math.radians(2))),
    ],
)
def test_a_hat_switch_moves_pan_and_tilt_each_by_its_own_step(
    control: str, value: float, command: CameraCommand
):
    widget = WIDGETS["widgetAdjustPanTilt"].from_spec(
        spec("widgetAdjustPanTilt", tilt_deg=4.0), "magellan"
    )
    assert widget.handle(down("x"), event_spec("x", control, value), at(0.0)) == camera(command)


def test_a_wheel_zooms_both_ways():
    widget = WIDGETS["widgetAdjustZoom"].from_spec(spec("widgetAdjustZoom"), "magellan")
    wheel = event_spec("mouse wheel")
    away, back = (
        widget.handle(ControlEvent(name="mouse wheel", pressed=True, value=value), wheel, at(0.0))
        for value in (1.0, -1.0)
    )
    assert away == camera(CameraCommand(zoom=0.05))
    assert back == camera(CameraCommand(zoom=-0.05))


def test_home_is_sent_once_a_press():
    widget = WIDGETS["widgetHomePTZ"].from_spec(spec("widgetHomePTZ"), "magellan")
    home = camera(CameraCommand(motion=CameraMotion.HOME))
    assert widget.handle(down("h"), event_spec("h"), at(0.0)) == home
    assert widget.handle(again("h"), event_spec("h"), at(0.1)) == ()
    assert widget.handle(up("h"), event_spec("h"), at(0.2)) == ()


def test_quit_ends_the_console_when_pressed():
    widget = WIDGETS["widgetQuit"].from_spec(spec("widgetQuit"), "")
    assert widget.handle(down("q"), event_spec("q"), at(0.0)) == (QuitEffect(),)
    assert widget.handle(up("q"), event_spec("q"), at(0.1)) == ()


@for_each("handler", sorted(set(WIDGETS) - {"widgetSetSpeed"}))
def test_only_speed_widgets_speak_unasked(handler: str):
    widget = WIDGETS[handler].from_spec(spec(handler), "magellan")
    assert widget.tick(at(1.0)) == ()
    assert widget.release(at(1.0)) == ()


def with_everything(state: ConsoleState) -> ConsoleState:
    """The same robot with holds, joints, lights, motors to arm, and an autopilot."""
    robot = state.robots["magellan"]
    body = dataclasses.replace(
        magellan_body(),
        holds=(HoldBody(kind=HoldKind.DEPTH),),
        lights=(LightBody(name="lamp"),),
        joints=(JointBody(name="arm", lowest=-1.0, highest=1.0, speed=1.0),),
        arms=1,
    )
    messages = {ROBOT_DESCRIPTION.name: received(body), AUTOPILOT_STATE.name: received(ROVER)}
    known = robot.with_(messages={**robot.messages, **messages})
    return dataclasses.replace(state, robots={"magellan": known})


@for_each("handler", sorted(WIDGETS))
def test_a_widget_sends_what_it_announced_and_all_of_it_can_be_encoded(handler: str):
    rule = WIDGETS[handler].rule
    widget = WIDGETS[handler].from_spec(spec(handler), "magellan")
    control = next(iter(rule.controls), "")
    state = with_everything(seeing(marked(1, LANDMARK)))
    effects = widget.handle(click(), event_spec("mouse left", control), state)
    if handler == "widgetArm":  # it asks first
        effects += widget.handle(click(), event_spec("mouse left", control), state)
    if handler == "widgetMode":  # one input shows what another one sets
        effects += widget.handle(click(), event_spec("mouse left", "set"), state)
    ghosts = [effect for effect in effects if isinstance(effect, ShowGhost)]
    for ghost in ghosts:  # a second click confirms what the first one shows
        state = changed(seeing(marked(1, LANDMARK)), ghost)
        effects += widget.handle(click(), event_spec("mouse left", control), state)
    answers = [effect.answer("yes", at(0.0)) for effect in effects if isinstance(effect, AskEffect)]
    effects = effects + tuple(itertools.chain(*answers))
    sent = [effect for effect in effects if isinstance(effect, SendEffect)]
    for effect in sent:
        payload = b"".join(map(bytes, effect.definition.encode(effect.value)))
        again = effect.definition.encode(effect.definition.decode(payload))
        assert b"".join(map(bytes, again)) == payload
        assert effect.robot == "magellan"
    assert {effect.definition.name for effect in sent} == set(rule.sends)


@for_each("handler", sorted(WIDGETS))
def test_a_widget_whose_robot_is_not_there_neither_fails_nor_acts_on_another(handler: str):
    widget = WIDGETS[handler].from_spec(spec(handler), "*")
    control = next(iter(WIDGETS[handler].rule.controls), "")
    for effect in widget.handle(click(), event_spec("mouse left", control), at(0.0)):
        assert getattr(effect, "robot", "*") in {"*", ""}
