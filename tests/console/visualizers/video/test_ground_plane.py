"""visualizeGroundPlane."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.pose import Pose
from rune_tui.model.robot_state import Picture
from rune_tui.model.theme import DARK
from tests.console.visualizers.conftest import made_by, words
from tests.support.cases import for_each

NAME = "visualizeGroundPlane"
SIZE = (160, 120)
LOW = {"tilt": -0.3, "mount_height": 0.37, "mount_forward": 0.05}
STATE = ConsoleState(now=100.0)


def robot_at(made, *, age: float = 0.1, number: int = 1, state_age: float = 0.1, **motion):
    """A robot at the map's origin with a picture of 160x120, and another camera state by now."""
    picture = Picture(pixels=np.zeros((120, 160, 3), np.uint8), camera=made.camera(**LOW))
    return made.robot(
        picture=made.received(picture, age, number),
        camera=made.received(made.camera(pan=1.0, tilt=0.4)),
        navigation=made.received(made.navigation(**motion), state_age),
    )


def geometry(made, **changes) -> PictureGeometry:
    found = PictureGeometry.of(made.camera(**LOW | changes), *SIZE)
    assert found is not None
    return found


def has(canvas, colour: tuple[int, ...], pixel: tuple[float, float], within: int = 1) -> bool:
    """Whether something of this colour is drawn at a pixel or next to it."""
    x, y = (int(value) for value in pixel)
    near = canvas.pixels[max(0, y - within) : y + within + 1, max(0, x - within) : x + within + 1]
    return bool((near[..., :3] == colour[:3]).all(axis=2)[near[..., 3] > 0].any())


def painted(canvas, colour: tuple[int, ...]) -> bool:
    pixels = canvas.pixels
    return bool(((pixels[..., :3] == colour[:3]).all(axis=2) & (pixels[..., 3] > 0)).any())


def text(canvas) -> str:
    return " ".join(" ".join(words(canvas)).split())


def test_lines_lie_where_the_camera_of_the_picture_saw_those_distances(made, draw, golden) -> None:
    canvas = draw(NAME, robot_at(made), SIZE)
    view = geometry(made)
    for ahead in (1.0, 2.0, 3.0):
        for left in (-0.3, 0.15, 0.3):
            assert has(canvas, DARK.ink, view.pixels((ahead, left)).pixels)
    assert has(canvas, DARK.ink, view.pixels((1.6, 0.0)).pixels)
    for ahead, left in ((1.4, 0.2), (1.6, -0.3)):
        x, y = (int(value) for value in view.pixels((ahead, left)).pixels)
        assert not canvas.pixels[y, x].any()
    small = draw(NAME, robot_at(made), (40, 30))
    golden("ground_plane", small)


def test_each_line_has_its_distance_written_where_it_begins(made, draw) -> None:
    canvas = draw(NAME, robot_at(made), SIZE)
    view = geometry(made)
    for distance in (1.0, 2.0, 3.0):
        row = int(view.pixels((distance, 0.0)).pixels[1]) // 2
        near = words(canvas)[row - 1 : row + 2]
        assert any(line.strip() == f"{distance:g} m" for line in near)


def test_the_horizon_is_a_dashed_line(made, draw) -> None:
    level = dataclasses.replace(
        robot_at(made).picture.value, camera=made.camera(**LOW | {"tilt": 0})
    )
    canvas = draw(NAME, made.robot(picture=made.received(level)), SIZE)
    row = canvas.pixels[60, 20:, 3] > 0
    assert 0.4 < row.mean() < 0.8
    assert not canvas.pixels[:56].any()


def test_the_option_is_the_spacing_and_farthest_is_where_lines_end(made, draw) -> None:
    half = draw(NAME, robot_at(made), SIZE, option=0.5, farthest=2.0)
    assert [w for w in words(half) if w] == [" 2 m", " 1.5 m", " 1 m"]
    assert [w for w in words(draw(NAME, robot_at(made), SIZE, farthest=2.0)) if w] == [
        " 2 m",
        " 1 m",
    ]


def test_rings_are_equally_far_from_the_robot(made, draw) -> None:
    canvas = draw(NAME, robot_at(made), SIZE, lines="rings")
    view = geometry(made)
    for angle in (-0.3, 0.0, 0.3):
        place = 2.0 * math.cos(angle), 2.0 * math.sin(angle)
        assert has(canvas, DARK.ink, view.pixels(place).pixels)
    assert "2 m" in text(canvas)


@pytest.mark.parametrize(
    ("pan", "word"), [(1.6, "2 m left"), (-1.6, "2 m right"), (3.1, "2 m behind")]
)
def test_aside_the_distance_says_to_which_side_it_is(made, draw, pan, word) -> None:
    picture = Picture(pixels=np.zeros((120, 160, 3), np.uint8), camera=made.camera(**LOW, pan=pan))
    canvas = draw(NAME, made.robot(picture=made.received(picture)), SIZE)
    assert word in text(canvas)


@pytest.mark.parametrize(
    ("fit", "size"), [("fit", (160, 60)), ("fill", (160, 60)), ("stretch", (80, 120))]
)
def test_it_is_fitted_as_the_picture_under_it(made, draw, fit, size) -> None:
    """The line two metres ahead is where the picture's own pixel there is."""
    canvas = draw(NAME, robot_at(made), size, fit=fit)
    x, y = geometry(made).pixels((2.0, 0.3)).pixels
    scales = {"fit": (0.5, 0.5, 40, 0), "fill": (1.0, 1.0, 0, -30), "stretch": (0.5, 1.0, 0, 0)}
    across, down, left, top = scales[fit]
    assert has(canvas, DARK.ink, (x * across + left, y * down + top))
    if fit == "fit":
        assert not canvas.pixels[:, :40].any()
        assert not canvas.pixels[:, 120:].any()


def test_the_way_ahead_is_as_wide_as_the_robot_and_bends_with_it(made, draw) -> None:
    view = geometry(made)
    straight = draw(NAME, robot_at(made, commanded_linear=0.5), SIZE)
    for left in (0.203, -0.203):
        assert has(straight, DARK.accent, view.pixels((1.5, left)).pixels)
    bent = draw(NAME, robot_at(made, commanded_linear=0.5, commanded_angular=0.25), SIZE)
    # A circle of two metres around (0, 2): the right edge is 0.203 m beyond.
    turn = 0.7
    outer = 2.203 * math.sin(turn), 2.0 - 2.203 * math.cos(turn)
    assert has(bent, DARK.accent, view.pixels(outer).pixels)
    assert not has(bent, DARK.accent, view.pixels((2.0, -0.203)).pixels)


def test_arrows_stand_where_the_robot_will_be_each_second(made, draw) -> None:
    view = geometry(made)
    canvas = draw(NAME, robot_at(made, commanded_linear=0.7), SIZE)
    assert has(canvas, DARK.accent, view.pixels((1.4 + 0.11, 0.0)).pixels)
    assert not has(canvas, DARK.accent, view.pixels((1.8, 0.0)).pixels)


def test_a_mark_and_words_say_where_it_stops_when_it_is_stopped_now(made, draw) -> None:
    """From 1 m/s: 0.3 s as before, then braking at 0.5 m/s^2: 1.3 m from the body's front."""
    canvas = draw(NAME, robot_at(made, commanded_linear=1.0), SIZE, braking=0.5)
    assert has(canvas, DARK.warning, geometry(made).pixels((1.503, 0.15)).pixels)
    assert "stop 1.3 m" in text(canvas)
    # So near that it is below the picture.
    assert "stops in 0.1 m" in text(draw(NAME, robot_at(made, commanded_linear=0.2), SIZE))


@pytest.mark.parametrize(
    ("motion", "told"),
    [
        ({"commanded_linear": -0.3}, "drives back, out of the picture"),
        ({"commanded_angular": 0.5}, "turns left"),
        ({"commanded_angular": -0.5}, "turns right"),
    ],
)
def test_what_cannot_be_seen_is_said(made, draw, motion, told) -> None:
    assert told in text(draw(NAME, robot_at(made, **motion), SIZE))


def test_a_way_beside_the_picture_is_said(made, draw) -> None:
    picture = Picture(pixels=np.zeros((120, 160, 3), np.uint8), camera=made.camera(**LOW, pan=1.5))
    state = made.received(made.navigation(commanded_linear=0.3))
    canvas = draw(NAME, made.robot(picture=made.received(picture), navigation=state), SIZE)
    assert "drives ahead, out of the picture" in text(canvas)


@for_each("speeds", [(0.0, 0.0), (math.nan, 0.0), (math.nan, 0.5), (math.inf, 0.0)])
def test_a_robot_that_stands_or_whose_command_is_unknown_has_no_way(made, draw, speeds) -> None:
    linear, angular = speeds
    robot = robot_at(made, commanded_linear=linear, commanded_angular=angular)
    canvas = draw(NAME, robot, SIZE)
    assert "turns" not in text(canvas)
    assert not painted(canvas, DARK.accent)
    assert "stop" not in text(canvas)


def test_the_way_begins_where_the_robot_is_by_now(made, draw) -> None:
    """The picture was taken half a metre behind, looking a little to the right."""
    camera = made.camera(**LOW, robot_x=3.0, robot_y=1.0, robot_theta=0.5)
    picture = Picture(pixels=np.zeros((120, 160, 3), np.uint8), camera=camera)
    then = Pose(x=3.0, y=1.0, theta=0.5)
    x, y = then.to_map((0.5, 0.1)).tolist()
    moving = made.navigation(x=x, y=y, theta=0.6, commanded_linear=0.5)
    canvas = draw(
        NAME, made.robot(picture=made.received(picture), navigation=made.received(moving)), SIZE
    )
    now = Pose(x=x, y=y, theta=0.6)
    for left in (0.203, -0.203):
        place = then.from_map(now.to_map((1.2, left))).tolist()
        assert has(canvas, DARK.accent, geometry(made).pixels(place).pixels)


def test_an_old_command_is_faint_and_a_stale_one_is_not_shown(made, draw) -> None:
    old = draw(NAME, robot_at(made, commanded_linear=0.5, state_age=2.0), SIZE)
    assert not painted(old, DARK.accent)
    assert painted(old, DARK.faint)
    stale = draw(NAME, robot_at(made, commanded_linear=0.5, state_age=4.0), SIZE)
    assert not painted(stale, DARK.accent)
    assert not painted(stale, DARK.faint)
    assert not painted(stale, DARK.warning)


def test_lines_on_an_old_picture_are_dimmed_and_on_a_stale_one_hatched_and_marked(
    made, draw
) -> None:
    fresh, old, stale = (draw(NAME, robot_at(made, age=age), SIZE) for age in (0.1, 2.0, 5.0))
    assert old.pixels[..., :3].max() < fresh.pixels[..., :3].max()
    assert (stale.pixels[4:, :, :3] < old.pixels[4:, :, :3]).any()
    assert "STALE 5.0 s" in words(stale)[0]


def test_without_a_picture_it_shows_where_the_camera_looks(made, draw) -> None:
    camera = made.received(made.camera(**LOW))
    canvas = draw(NAME, made.robot(picture=None, camera=camera), SIZE)
    assert has(canvas, DARK.ink, geometry(made).pixels((2.0, 0.3)).pixels)


@pytest.mark.parametrize("camera", [None, {"horizontal_fov": math.nan}])
def test_all_is_clear_when_nobody_knows_how_the_camera_looks(made, draw, camera) -> None:
    known = camera and made.received(made.camera(**camera))
    canvas = draw(NAME, made.robot(picture=None, camera=known), SIZE)
    assert not canvas.pixels.any()
    assert not canvas.glyphs.any()


def test_the_token_changes_only_with_what_is_drawn(made) -> None:
    shown = made_by(NAME)

    def token(state: ConsoleState = STATE, **changes):
        return shown.source(robot_at(made, **changes), state)

    first = token()
    # Another picture of the same look, and a robot that moved without a command.
    assert first == token(number=2) == token(x=3.0, theta=1.0) == token(state_age=2.0)
    assert first != token(age=2.0)
    assert first != token(commanded_linear=0.3)
    assert first != token(STATE.__class__(now=100.0, theme=dataclasses.replace(DARK, name="x")))
    moving = {"commanded_linear": 0.3}
    assert token(**moving) == token(**moving)
    assert len({token(**moving), token(**moving, commanded_angular=0.1)}) == 2
    assert token(**moving) != token(**moving, state_age=2.0)
    other = robot_at(made)
    turned = dataclasses.replace(other.picture.value, camera=made.camera(**LOW, pan=0.1))
    assert shown.source(other.with_(picture=made.received(turned)), STATE) != first


@for_each("size", [(1, 1), (2, 2), (3, 9), (200, 4), (4, 200)])
@for_each("fit", ["fit", "fill", "stretch"])
def test_any_canvas_will_do(made, draw, size, fit) -> None:
    for motion in ({"commanded_linear": 0.5}, {"commanded_angular": 1.0}, {}):
        draw(NAME, robot_at(made, age=9.0, **motion), size, fit=fit, option=0.1, farthest=20.0)


def flown(made, **stance):
    """A robot that drives ahead, tilted or in the air, as its picture says."""
    camera = made.camera(**LOW | {"tilt": 0.0} | stance)
    picture = Picture(pixels=np.zeros((120, 160, 3), np.uint8), camera=camera)
    moves = made.navigation(linear=0.3, commanded_linear=0.3)
    return made.robot(picture=made.received(picture), navigation=made.received(moves))


def test_the_lines_below_a_robot_that_flies_lie_on_the_ground_without_a_path(made, draw) -> None:
    stance = {"robot_above_ground": 1.5, "robot_roll": 0.2, "robot_pitch": 0.4}
    canvas = draw(NAME, flown(made, **stance), SIZE)
    view = geometry(made, tilt=0.0, **stance)
    for ahead, left in ((3.0, 0.4), (4.0, -0.5)):
        assert has(canvas, DARK.ink, view.pixels((ahead, left)).pixels)
    assert not painted(canvas, DARK.accent)
    assert "stop" not in text(canvas)
    assert painted(draw(NAME, flown(made), SIZE), DARK.accent)


def test_without_a_height_a_robot_that_flies_has_no_lines(made, draw) -> None:
    canvas = draw(NAME, flown(made, robot_above_ground=math.nan), SIZE)
    assert not canvas.pixels.any()


def test_the_horizon_of_a_robot_on_a_ramp_is_level_and_its_lines_are_those_of_the_ramp(
    made, draw
) -> None:
    ramp = draw(NAME, flown(made, robot_pitch=-0.2, robot_roll=0.0), SIZE)
    view = geometry(made, tilt=0.0)
    assert has(ramp, DARK.ink, view.pixels((2.0, 0.15)).pixels)
    level = PictureGeometry.of(
        made.camera(**LOW | {"tilt": 0.0, "robot_pitch": -0.2, "robot_roll": 0.0}),
        *SIZE,
        level=True,
    )
    assert level is not None
    row = ramp.pixels[int(level.horizon), 20:, 3] > 0
    assert 0.4 < row.mean() < 0.8
