"""Orders to a robot, what its camera sends, and what only the console shows."""

from __future__ import annotations

import cmath
import dataclasses
import math

import pytest

from hub.gcm.autonomy import AutonomyCommand, Behaviour
from hub.gcm.navigation import Assistance, AssistanceCommand, GoalCommand
from hub.gcm.vision import ImageCoding, ImageKind, NightCommand
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.spec import ControlKind, EventSpec
from rune_tui.model.console_state import ConsoleState, PictureWish
from rune_tui.model.effects import (
    CalibrateEffect,
    ChooseRobot,
    Effect,
    FillView,
    NextLayoutEffect,
    Notify,
    ScreenshotEffect,
    SendEffect,
    SetTheme,
    ShowViewport,
    ToggleHelp,
    ToggleLog,
    WishPictures,
    Zoom,
)
from rune_tui.model.state_changes import changed
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
    up,
    widget_of,
)
from tests.support.cases import for_each
from tests.support.messages import robot_state

KEY = event_spec("x")


def values(effects: tuple[Effect, ...]) -> list[object]:
    return [effect.value for effect in effects if isinstance(effect, SendEffect)]


def pressed(handler: str, state: ConsoleState, **options: float | str) -> tuple[Effect, ...]:
    return widget_of(handler, **options).handle(down("x"), KEY, state)


def after(state: ConsoleState, effects: tuple[Effect, ...]) -> ConsoleState:
    for effect in effects:
        if not isinstance(effect, SendEffect):
            state = changed(state, effect)  # type: ignore[arg-type]
    return state


@pytest.mark.parametrize(("linear", "limit"), [(0.0, math.nan), (0.3, 0.3)])
def test_a_click_sends_the_robot_to_the_place(linear: float, limit: float):
    widget = widget_of("widgetGoTo", linear=linear)
    (goal,) = values(widget.handle(click(), event_spec("mouse left"), seeing()))
    assert isinstance(goal, GoalCommand)
    assert [(point.x, point.y) for point in goal.points] == [(3.0, -1.0)]
    assert len(goal.points) == 1
    assert math.isnan(goal.theta)
    assert goal.linear_limit == pytest.approx(limit, nan_ok=True)


def test_a_click_on_a_mark_sends_the_robot_before_it_and_turned_to_it():
    marks = (marked(1, x=3.2), marked(2, LANDMARK, x=5.0))
    effects = widget_of("widgetGoTo").handle(click(), event_spec("mouse left"), seeing(*marks))
    (goal,) = values(effects)
    assert isinstance(goal, GoalCommand)
    (point,) = goal.points
    robot, mark = complex(1.0, 1.0), complex(3.2, -1.0)
    assert abs(mark - complex(point.x, point.y)) == pytest.approx(1.0)
    assert abs(complex(point.x, point.y) - robot) == pytest.approx(abs(mark - robot) - 1.0)
    assert goal.theta == pytest.approx(cmath.phase(mark - robot))
    (text,) = [each.notice.text for each in effects if isinstance(each, Notify)]
    assert text == "sent to victim 1, 1.0 m before it"
    (beside,) = values(
        widget_of("widgetGoTo", mark=0.1).handle(click(), event_spec("mouse left"), seeing(*marks))
    )
    assert isinstance(beside, GoalCommand)
    assert [(point.x, point.y) for point in beside.points] == [(3.0, -1.0)]


def test_no_way_to_a_mark_that_is_near_or_from_a_place_that_is_not_known():
    old = received(robot_state(x=1.0, y=1.0), age=1.5)
    for state, options, words in (
        (seeing(marked(1)), {"before": 3.0}, "the robot is 2.8 m from it already"),
        (seeing(marked(1), navigation=old), {}, "where the robot is now is not known"),
        (seeing(marked(1), navigation=None), {}, "where the robot is now is not known"),
    ):
        widget = widget_of("widgetGoTo", **options)
        (effect,) = widget.handle(click(), event_spec("mouse left"), state)
        assert isinstance(effect, Notify)
        assert words in effect.notice.text


@for_each("order", ["explore", "return", "hold", "wander"])
def test_autonomy_is_told_the_order_by_name(order: str):
    command = AutonomyCommand(behaviour=Behaviour[order.upper()])
    assert values(pressed("widgetAutonomy", seeing(), order=order)) == [command]


@for_each(
    ("wanted", "known", "sent"),
    [
        ("toggle", Assistance.ON, Assistance.OFF),
        ("toggle", Assistance.OFF, Assistance.ON),
        ("on", Assistance.ON, Assistance.ON),
        ("off", Assistance.OFF, Assistance.OFF),
    ],
)
def test_safety_switches_and_tells_loudly_when_it_is_off(
    wanted: str, known: Assistance, sent: Assistance
):
    state = seeing(navigation=received(robot_state(assistance=known)))
    effects = pressed("widgetSafety", state, assistance=wanted)
    assert values(effects) == [AssistanceCommand(assistance=sent)]
    (notice,) = [effect.notice for effect in effects if isinstance(effect, Notify)]
    assert notice.alarm == (sent is Assistance.OFF)


def test_safety_is_switched_on_where_nothing_is_known():
    effects = pressed("widgetSafety", seeing(navigation=None))
    assert values(effects) == [AssistanceCommand(assistance=Assistance.ON)]


def test_other_pictures_are_asked_for_and_then_the_usual_ones_again():
    options: dict[str, float | str] = {
        "kind": "grey",
        "width": 80.0,
        "height": 60.0,
        "quality": 90.0,
        "coding": "jpeg",
    }
    wish = PictureWish(
        kind=ImageKind.GREY, width=80, height=60, quality=90, coding=ImageCoding.JPEG
    )
    first = pressed("widgetSetImageRequest", seeing(), **options)
    assert first == (WishPictures(robot="magellan", wish=wish),)
    second = pressed("widgetSetImageRequest", after(seeing(), first), **options)
    assert second == (WishPictures(robot="magellan", wish=PictureWish()),)


def test_a_throttle_sets_the_quality_of_pictures_and_small_moves_ask_for_nothing():
    widget, state, seen = widget_of("widgetSetImageQuality"), seeing(), []
    throttle = EventSpec(
        name="joystick pad throttle", kind=ControlKind.AXIS, control="", value=1.0, line=1
    )
    for value in (0.5, 0.51, 0.53, 1.0, 0.0):
        moved = ControlEvent(
            name="joystick pad throttle", pressed=bool(value), repeat=True, value=value
        )
        effects = widget.handle(moved, throttle, state)
        seen.append([effect.wish.quality for effect in effects])  # type: ignore[attr-defined]
        state = after(state, effects)
    assert seen == [[50], [], [], [90], [10]]
    assert state.wishes["magellan"].coding is ImageCoding.JPEG


def test_night_mode_goes_on_and_off_here_and_on_the_robot():
    first = pressed("widgetToggleNightMode", seeing())
    (command,) = values(first)
    assert isinstance(command, NightCommand)
    assert command.on == 1
    assert math.isnan(command.headlight)
    state = after(seeing(), first)
    assert state.night == {"magellan"}
    second = pressed("widgetToggleNightMode", state)
    assert [command.on for command in values(second)] == [0]  # type: ignore[attr-defined]
    assert after(state, second).night == frozenset()


@for_each(
    ("handler", "options", "effect"),
    [
        ("widgetShowViewport", {"viewport": "map"}, ShowViewport(viewport="map")),
        ("widgetShowViewport", {"shown": "show"}, ShowViewport(viewport="camera", shown=True)),
        ("widgetShowViewport", {"shown": "hide"}, ShowViewport(viewport="camera", shown=False)),
        ("widgetFullScreen", {"viewport": "map"}, FillView(viewport="map")),
        ("widgetChooseRobot", {}, ChooseRobot()),
        ("widgetChooseRobot", {"robot": "blimp"}, ChooseRobot(robot="blimp")),
        ("widgetNextLayout", {}, NextLayoutEffect()),
        ("widgetTheme", {}, SetTheme()),
        ("widgetTheme", {"theme": "light"}, SetTheme(name="light")),
        ("widgetHelp", {}, ToggleHelp()),
        ("widgetMessages", {}, ToggleLog()),
        ("widgetScreenshot", {}, ScreenshotEffect()),
        ("widgetCalibrate", {}, CalibrateEffect()),
        (
            "widgetCalibrate",
            {"joystick": "pad", "control": "twist"},
            CalibrateEffect(joystick="pad", control="twist"),
        ),
    ],
)
def test_what_only_the_console_shows_changes_once_a_press(
    handler: str, options: dict[str, str], effect: Effect
):
    widget = widget_of(handler, "", **options)
    assert widget.handle(down("x"), KEY, at(0.0)) == (effect,)
    assert widget.handle(again("x"), KEY, at(0.1)) == ()
    assert widget.handle(up("x"), KEY, at(0.2)) == ()


def test_the_wheel_zooms_the_map_and_the_value_zero_takes_it_back():
    widget = widget_of("widgetZoomMap", factor=2.0)
    wheel = event_spec("mouse wheel")
    for value, factor in ((1.0, 2.0), (-1.0, 0.5)):
        event = dataclasses.replace(down("mouse wheel"), value=value)
        assert widget.handle(event, wheel, at(0.0)) == (Zoom(viewport="camera", factor=factor),)
    back = widget.handle(down("x"), event_spec("x", value=0.0), at(0.0))
    zoomed = changed(at(0.0), Zoom(viewport="camera", factor=3.0))
    assert zoomed.zooms == {"camera": 3.0}
    assert after(zoomed, back).zooms == {"camera": 1.0}


def test_a_viewport_fills_the_view_until_the_next_press():
    state = after(at(0.0), pressed("widgetFullScreen", at(0.0)))
    assert state.full == "camera"
    assert after(state, pressed("widgetFullScreen", state)).full == ""


def test_hiding_is_the_other_of_what_the_layout_says():
    state = ConsoleState(now=0.0, shown={"camera": False})
    assert after(state, pressed("widgetShowViewport", state)).shown == {"camera": True}
