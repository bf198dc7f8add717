"""Marking, taking back, removing, and correcting the pose: what clicks on places send."""

from __future__ import annotations

import dataclasses
import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hub.gcm.mapping import (
    POINT_COMMAND,
    InterestPoint,
    PointAction,
    PointCommand,
    PointKind,
)
from hub.gcm.navigation import LANDMARK_CORRECTION
from hub.pose import Pose
from rune_tui.controls.events import ControlEvent, Hit
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import (
    AskEffect,
    Effect,
    ExportEffect,
    MarksWaiting,
    Notify,
    SendEffect,
    StateEffect,
)
from rune_tui.model.robot_state import Picture
from rune_tui.model.state_changes import changed
from rune_tui.model.world import WorldPoint
from rune_tui.widgets.marks import GHOST_S
from tests.console.visualizers.conftest import NOW, received
from tests.console.widgets.presses import (
    LANDMARK,
    PLACE,
    VICTIM,
    click,
    down,
    event_spec,
    marked,
    seeing,
    widget_of,
)
from tests.support.messages import camera_state, robot_state

LEFT = event_spec("mouse left")
KEY = event_spec("u")


def sent(effects: tuple[Effect, ...]) -> PointCommand:
    (effect,) = [effect for effect in effects if isinstance(effect, SendEffect)]
    assert effect.definition is POINT_COMMAND
    command: PointCommand = effect.value
    return command


def told(effects: tuple[Effect, ...]) -> str:
    """What the operator is told, where nothing is sent."""
    (effect,) = [effect for effect in effects if not isinstance(effect, MarksWaiting)]
    assert isinstance(effect, Notify)
    assert effect.notice.robot == "magellan"
    return effect.notice.text


@pytest.mark.parametrize(
    ("handler", "kind"), [("widgetSetVictim", VICTIM), ("widgetSetLandmark", LANDMARK)]
)
def test_a_click_on_the_ground_marks_it_with_who_and_how_sure(handler: str, kind: PointKind):
    point = sent(widget_of(handler, confirm="off").handle(click(), LEFT, seeing())).point
    assert (point.kind, point.x, point.y, point.number) == (kind, 3.0, -1.0, 0)
    assert point.by == "jane"
    assert (point.uncertainty, point.distance, point.note) == (0.125, 2.5, "")
    assert point.stamp == 0.0  # the robot's map notes the time by its own clock


def test_the_layout_may_say_who_marks_and_what_to_note():
    widget = widget_of("widgetSetVictim", operator="team 1", note="warm", confirm="off")
    place = WorldPoint(x=1.0, y=2.0, uncertainty=math.nan, height=0.7)
    point = sent(widget.handle(click(place), LEFT, seeing())).point
    assert (point.by, point.note, point.height) == ("team 1", "warm", 0.7)
    assert math.isnan(point.uncertainty)
    assert math.isnan(point.distance)


@pytest.mark.parametrize("handler", ["widgetSetVictim", "widgetRemoveMark", "widgetGoTo"])
def test_a_click_beside_the_ground_sends_nothing_and_says_so(handler: str):
    effects = widget_of(handler).handle(click(None), LEFT, seeing(marked(1)))
    assert "nothing tells how far away" in told(effects)


def test_a_place_on_another_robots_viewport_does_not_count():
    effects = widget_of("widgetSetVictim").handle(click(robot="blimp"), LEFT, seeing())
    assert "nothing tells how far away" in told(effects)


def test_the_own_viewport_says_where_before_those_in_front_of_it():
    near = Hit(viewport="label", x=0.5, y=0.5, place=PLACE, robot="magellan")
    other = WorldPoint(x=9.0, y=9.0, uncertainty=0.1)
    own = Hit(viewport="camera", x=0.5, y=0.5, place=other, robot="magellan")
    event = ControlEvent(name="mouse left", pressed=True, hits=(near, own))
    assert (
        sent(widget_of("widgetSetVictim", confirm="off").handle(event, LEFT, seeing())).point.x
        == 9.0
    )


def after(state: ConsoleState, effects: tuple[Effect, ...]) -> ConsoleState:
    """The console's state with what these effects change of it."""
    for effect in effects:
        if isinstance(effect, StateEffect):
            state = changed(state, effect)
    return state


def test_the_first_click_shows_a_ghost_and_a_second_one_there_marks_what_it_showed():
    widget = widget_of("widgetSetVictim")
    effects = widget.handle(click(), LEFT, seeing())
    assert not [effect for effect in effects if isinstance(effect, SendEffect)]
    state = after(seeing(), effects)
    assert state.ghosts["magellan"].place == PLACE
    beside = dataclasses.replace(PLACE, x=PLACE.x + 0.2)
    effects = widget.handle(click(beside), LEFT, state)
    assert (sent(effects).point.x, sent(effects).point.y) == (PLACE.x, PLACE.y)
    assert not after(state, effects).ghosts


def test_a_click_elsewhere_moves_the_ghost_and_marks_nothing():
    widget = widget_of("widgetSetVictim")
    state = after(seeing(), widget.handle(click(), LEFT, seeing()))
    there = dataclasses.replace(PLACE, x=PLACE.x + 1.0)
    effects = widget.handle(click(there), LEFT, state)
    assert not [effect for effect in effects if isinstance(effect, SendEffect)]
    assert after(state, effects).ghosts["magellan"].place == there


def test_a_click_of_another_kind_does_not_confirm_a_ghost():
    state = after(seeing(), widget_of("widgetSetVictim").handle(click(), LEFT, seeing()))
    effects = widget_of("widgetSetLandmark").handle(click(), LEFT, state)
    assert not [effect for effect in effects if isinstance(effect, SendEffect)]
    assert after(state, effects).ghosts["magellan"].kind is LANDMARK


def test_a_ghost_that_nobody_confirms_ends():
    widget = widget_of("widgetSetVictim")
    state = after(seeing(), widget.handle(click(), LEFT, seeing()))
    assert widget.tick(dataclasses.replace(state, now=NOW + 0.9 * GHOST_S)) == ()
    late = dataclasses.replace(state, now=NOW + GHOST_S)
    assert not after(late, widget.tick(late)).ghosts


def decoded(point: InterestPoint) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(point.thumbnail.tobytes())).convert("RGB"))


def test_the_small_picture_shows_what_was_clicked():
    pixels = np.zeros((120, 160, 3), np.uint8)
    pixels[60:, 80:] = (255, 0, 0)
    state = seeing(picture=received(Picture(pixels=pixels, camera=camera_state())))
    corner = sent(
        widget_of("widgetSetVictim", confirm="off").handle(
            click(in_picture=(0.9, 0.9)), LEFT, state
        )
    ).point
    assert corner.thumbnail.size > 0
    red, green, blue = decoded(corner).mean(axis=(0, 1))
    assert red > 240 > 15 > max(green, blue)
    bare = sent(widget_of("widgetSetVictim", confirm="off").handle(click(), LEFT, state)).point
    assert bare.thumbnail.size == 0


@given(
    height=st.integers(1, 300),
    width=st.integers(1, 300),
    centre=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
    seed=st.integers(0, 9),
)
def test_small_pictures_fit_into_a_point_whatever_they_show(
    height: int, width: int, centre: tuple[float, float], seed: int
):
    noise = np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)
    state = seeing(picture=received(Picture(pixels=noise, camera=camera_state())))
    point = sent(
        widget_of("widgetSetVictim", confirm="off").handle(click(in_picture=centre), LEFT, state)
    ).point
    assert 0 < point.thumbnail.size <= 4096
    assert decoded(point).size


def test_a_mark_that_the_robot_takes_is_told_with_its_number():
    widget = widget_of("widgetSetVictim", confirm="off")
    widget.handle(click(), LEFT, seeing(marked(4, x=0.0)))
    (waiting,) = widget.tick(seeing(marked(4, x=0.0), now=NOW + 0.1))
    assert isinstance(waiting, MarksWaiting)
    sure = dataclasses.replace(marked(5), uncertainty=0.125, distance=2.5)
    assert told(widget.tick(seeing(sure, now=NOW + 0.2))) == (
        "victim 5 is marked at 3.0, -1.0 m, give or take 0.12 m, seen from 2.5 m away"
    )
    assert widget.tick(seeing(marked(5), now=NOW + 60.0)) == ()


def test_a_mark_of_which_is_not_known_how_sure_it_is_is_told_without_that():
    widget = widget_of("widgetSetVictim", confirm="off")
    widget.handle(click(), LEFT, seeing())
    text = told(widget.tick(seeing(marked(5), now=NOW + 0.2)))
    assert text == "victim 5 is marked at 3.0, -1.0 m"


def test_undo_removes_the_newest_mark_of_this_operator_and_then_the_one_before():
    widget = widget_of("widgetUndoMark")
    state = seeing(marked(1), marked(2, by="joe"), marked(3), marked(4, by="joe"))
    command = sent(widget.handle(down("u"), KEY, state))
    assert (command.action, command.point.number) == (PointAction.REMOVE, 3)
    # The points have not come anew yet.
    assert sent(widget.handle(down("u"), KEY, state)).point.number == 1
    assert "nothing" in told(widget.handle(down("u"), KEY, state))


def test_remove_takes_the_nearest_mark_within_the_radius():
    marks = (marked(1, x=3.3), marked(2, x=2.9), marked(3, x=8.0))
    command = sent(widget_of("widgetRemoveMark").handle(click(), LEFT, seeing(*marks)))
    assert (command.action, command.point.number) == (PointAction.REMOVE, 2)
    narrow = widget_of("widgetRemoveMark", radius=0.05)
    assert "no mark" in told(narrow.handle(click(), LEFT, seeing(*marks)))


def test_edit_asks_for_the_words_of_the_nearest_mark_and_keeps_the_rest():
    sure = dataclasses.replace(marked(2, x=2.9), uncertainty=0.125, distance=2.5, note="wet")
    marks = (marked(1, x=3.3), sure, marked(3, x=8.0))
    (effect,) = widget_of("widgetEditMark").handle(click(), LEFT, seeing(*marks))
    assert isinstance(effect, AskEffect)
    assert "victim 2" in effect.asked
    assert effect.text == "wet"
    command = sent(effect.answer("behind the door", seeing(*marks)))
    assert command.action is PointAction.MARK
    assert command.point == dataclasses.replace(sure, note="behind the door")
    narrow = widget_of("widgetEditMark", radius=0.05)
    assert "no mark" in told(narrow.handle(click(), LEFT, seeing(*marks)))


def test_a_correction_says_where_the_nearest_landmark_is_seen_from_the_robot():
    marks = (marked(1, x=3.1), marked(2, LANDMARK, x=3.5), marked(3, LANDMARK, x=1.0))
    effects = widget_of("widgetCorrectLandmark").handle(click(), LEFT, seeing(*marks))
    (effect,) = [effect for effect in effects if isinstance(effect, SendEffect)]
    assert effect.definition is LANDMARK_CORRECTION
    assert (effect.value.x, effect.value.y) == (3.5, -1.0)
    believed = Pose(x=1.0, y=1.0, theta=0.5)
    seen = believed.outward(effect.value.seen_x, effect.value.seen_y)
    assert seen == pytest.approx((PLACE.x, PLACE.y))


def test_a_victim_corrects_the_pose_where_its_place_is_known():
    fixed = dataclasses.replace(marked(3), uncertainty=0.25)
    effects = widget_of("widgetCorrectLandmark").handle(click(), LEFT, seeing(fixed))
    (effect,) = [effect for effect in effects if isinstance(effect, SendEffect)]
    assert (effect.value.x, effect.value.y) == (3.0, -1.0)
    assert "victim 3 is seen 0.00 m beside its place" in told(effects[1:])
    for unsure in (math.nan, 0.0, 0.4):
        state = seeing(dataclasses.replace(fixed, uncertainty=unsure))
        text = told(widget_of("widgetCorrectLandmark").handle(click(), LEFT, state))
        assert "no landmark" in text
        assert "the place of victim 3 is not known to 0.3 m" in text


def test_no_landmark_or_no_fresh_pose_no_correction():
    widget = widget_of("widgetCorrectLandmark")
    assert "no landmark" in told(widget.handle(click(), LEFT, seeing(marked(1))))
    far = seeing(marked(1, LANDMARK, x=7.0))
    assert "no landmark" in told(widget.handle(click(), LEFT, far))
    old = received(robot_state(), age=1.5)
    stale = seeing(marked(1, LANDMARK), navigation=old)
    assert "not known" in told(widget.handle(click(), LEFT, stale))


def test_export_is_of_the_widgets_robot():
    effects = widget_of("widgetExportMarks", "*").handle(down("e"), KEY, seeing())
    assert effects == (ExportEffect(robot="*"),)


def test_a_chosen_robots_marks_go_to_it_by_name():
    state = dataclasses.replace(seeing(), chosen="magellan")
    effects = widget_of("widgetSetVictim", "*", confirm="off").handle(click(), LEFT, state)
    assert [effect.robot for effect in effects if isinstance(effect, SendEffect)] == ["magellan"]
