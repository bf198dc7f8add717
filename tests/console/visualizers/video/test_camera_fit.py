"""visualizeCameraImage: how the picture is fitted, and what its pixels stand for."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.model.cameras import PictureNeed
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.pose import Pose
from rune_tui.model.robot_state import Picture
from rune_tui.view import View
from rune_tui.visualizers.video.camera_image import CameraImage
from rune_tui.visualizers.video.picture_frame import PictureFrame
from tests.console.model.simulated_views import FEET_HIGH, FEET_LOW, VICTIM, aimed, take
from tests.console.states import Standing, layout_of, rendered, standing, view_of, visualizer_spec
from tests.console.visualizers.conftest import words
from tests.support.cases import for_each

NAME = "visualizeCameraImage"
STATE = ConsoleState(now=100.0)
sides = st.integers(1, 60)


def seen_at(made, **changes):
    """A robot with a picture of 160x120 taken at the map's origin, looking 20 degrees down."""
    values = {"tilt": -0.35, "robot_x": 0.0, "robot_y": 0.0, "robot_theta": 0.0}
    pixels = np.zeros((120, 160, 3), np.uint8)
    picture = Picture(pixels=pixels, camera=made.camera(**values | changes))
    return made.robot(picture=made.received(picture))


def test_filling_covers_the_viewport_and_keeps_the_middle(made, draw) -> None:
    canvas = draw(NAME, made.robot(), (8, 2), fit="fill")
    assert (canvas.pixels[..., :3] == made.picture().pixels[2:4]).all()
    canvas = draw(NAME, made.robot(), (4, 6), fit="fill")
    assert (canvas.pixels[..., :3] == made.picture().pixels[:, 2:6]).all()


def test_stretching_shows_all_of_the_picture_in_all_of_the_viewport(made, draw) -> None:
    canvas = draw(NAME, made.robot(), (4, 12), fit="stretch")
    whole = made.picture().pixels
    assert (canvas.pixels[0, :, :3] == whole[0, ::2]).all()
    assert (canvas.pixels[-1, :, :3] == whole[-1, ::2]).all()


@pytest.mark.parametrize("tall", [0.8, 1.25])
def test_a_picture_keeps_its_shape_on_terminals_with_cells_of_another(tall: float) -> None:
    frame = PictureFrame.of("fit", 400, 300, (800, 800), tall=tall)
    assert frame.width == 800
    assert frame.height * tall == pytest.approx(600, abs=tall)


@given(st.sampled_from(["fit", "fill", "stretch"]), sides, sides, sides, sides)
def test_a_frame_shows_the_middle_and_keeps_the_aspect_unless_it_stretches(
    fit: str, width: int, height: int, room_width: int, room_height: int
) -> None:
    frame = PictureFrame.of(fit, width, height, (room_width, room_height))
    assert abs(2 * frame.left + frame.width - room_width) <= 1
    assert abs(2 * frame.top + frame.height - room_height) <= 1
    covers = frame.width >= room_width and frame.height >= room_height
    assert covers or fit == "fit"
    if fit != "stretch":
        off = frame.width * height - frame.height * width
        assert abs(off) <= max(width, height) or 1 in {frame.width, frame.height}


@for_each("size", [(40, 30), (60, 10), (10, 60)])
@for_each("fit", ["fit", "fill", "stretch"])
def test_a_pixel_is_where_in_the_picture_it_was_drawn_from(made, draw, size, fit) -> None:
    """Each pixel of the picture has a colour of its own: its column and its row."""
    rows, columns = np.indices((30, 40), np.uint8)
    pixels = np.stack((4 * columns, 4 * rows, np.full_like(rows, 255)), axis=-1)
    picture = Picture(pixels=pixels, camera=made.camera())
    robot = made.robot(picture=made.received(picture))
    shown = CameraImage(fit=fit)
    canvas = draw(NAME, robot, size, fit=fit)
    for x in range(0, size[0], 3):
        for y in range(0, size[1], 3):
            found = shown.in_picture((x + 0.5, y + 0.5), size, robot, STATE)
            red, green, blue, _ = canvas.pixels[y, x].tolist()
            assert (found is not None) == (blue == 255)
            if found is not None:
                # As far off as one pixel of the picture or of the viewport.
                width = PictureFrame.of(fit, 40, 30, size).width
                height = PictureFrame.of(fit, 40, 30, size).height
                assert abs(found[0] * 40 - 0.5 - red / 4) <= max(1.0, 40 / width)
                assert abs(found[1] * 30 - 0.5 - green / 4) <= max(1.0, 30 / height)


def test_the_crosshair_marks_the_middle_and_words_say_how_far_aside_it_looks(made, draw) -> None:
    robot = seen_at(made, pan=math.radians(37.0))
    plain = draw(NAME, robot, (60, 40))
    marked = draw(NAME, robot, (60, 40), crosshair="on")
    changed = np.argwhere((plain.pixels != marked.pixels)[10:].any(axis=2)) + np.array((10, 0))
    assert np.abs(changed.mean(axis=0) - (20.0, 30.0)).max() <= 1.0
    assert "".join(words(plain)).strip() == ""
    assert words(marked)[1].strip() == "camera is 37° left"
    right = draw(NAME, seen_at(made, pan=math.radians(-12.0)), (10, 40), crosshair="on")
    assert words(right)[1].strip() == "12° right"


def test_the_option_is_the_angle_from_which_words_say_it(made, draw) -> None:
    robot = seen_at(made, pan=math.radians(10.0))
    for option, told in ((0.0, True), (9.0, True), (11.0, False)):
        canvas = draw(NAME, robot, (60, 40), crosshair="on", option=option)
        assert bool("".join(words(canvas)).strip()) == told


@pytest.mark.parametrize("pan", [math.nan, 0.0])
def test_no_words_when_it_looks_ahead_or_nobody_knows(made, draw, pan) -> None:
    canvas = draw(NAME, seen_at(made, pan=pan), (60, 40), crosshair="on")
    assert "".join(words(canvas)).strip() == ""


def test_a_click_gives_the_place_its_distance_and_how_sure_that_is(made) -> None:
    robot = seen_at(made, robot_x=3.0, robot_y=-1.0, robot_theta=math.pi / 2)
    place = CameraImage().locate((80.0, 60.0), (160, 120), robot, STATE)
    assert place is not None
    # In the middle: the camera 0.5 m up and 0.1 m ahead of the centre looks 0.35 rad down.
    away = 0.1 + 0.5 / math.tan(0.35)
    assert (place.x, place.y) == pytest.approx((3.0, -1.0 + away))
    assert place.distance == pytest.approx(away)
    farther = CameraImage().locate((80.0, 30.0), (160, 120), robot, STATE)
    assert farther is not None
    assert farther.distance > place.distance
    assert farther.uncertainty > place.uncertainty > 0.0


def test_an_enlarged_picture_is_no_surer_than_its_own_pixels(made) -> None:
    robot = seen_at(made)
    own = CameraImage().locate((80.5, 60.5), (160, 120), robot, STATE)
    large = CameraImage().locate((322.0, 242.0), (640, 480), robot, STATE)
    small = CameraImage().locate((20.125, 15.125), (40, 30), robot, STATE)
    assert own is not None
    assert large is not None
    assert small is not None
    assert (large.x, large.y) == pytest.approx((own.x, own.y))
    assert large.uncertainty == pytest.approx(own.uncertainty)
    assert small.uncertainty == pytest.approx(4 * own.uncertainty)


@for_each(
    ("pixel", "size", "changes"),
    [
        ((80.0, 1.0), (160, 120), {"tilt": 0.0}),  # above the horizon
        ((5.0, 100.0), (200, 120), {}),  # beside the picture
        ((80.0, 100.0), (160, 120), {"robot_theta": math.nan}),
        ((80.0, 100.0), (160, 120), {"horizontal_fov": math.nan}),
    ],
)
def test_where_no_ground_is_shown_there_is_no_place(made, pixel, size, changes) -> None:
    robot = seen_at(made, **changes).with_(messages={})
    assert CameraImage().locate(pixel, size, robot, STATE) is None


def test_without_a_picture_there_is_no_place(made) -> None:
    robot = made.robot(picture=None)
    assert CameraImage().locate((8.0, 9.0), (10, 10), robot, STATE) is None


def viewport(name: str, function: str, place: tuple[int, int, int, int], **changes) -> Standing:
    return standing(name, **{"visualizer": visualizer_spec(function)} | changes, place=place)


def screen_of(*viewports: Standing) -> View:
    spec = view_of(*viewports)
    screen = View(layout_of(spec))
    screen.resize(160, 48)
    return screen


@for_each(
    ("x", "y", "zoom", "aside", "up"),
    [
        (-2.0, -1.5, 0.0, 0.0, 0.0),
        (-1.2, -2.0, 0.0, 0.2, 0.05),
        (-3.5, -1.0, 0.3, -0.1, -0.05),
        (-2.3, 0.5, 0.8, 0.02, 0.02),
    ],
)
def test_a_click_on_a_victims_feet_in_the_view_gives_their_place_within_3_percent(
    made, x: float, y: float, zoom: float, aside: float, up: float
) -> None:
    """Turned and zoomed, in the middle of a view, and through an overlay without widgets."""
    robot = Pose(x=x, y=y, theta=-2.0)
    pan, tilt = aimed(robot, tuple(np.clip((x, y), FEET_LOW, FEET_HIGH).tolist()), aside, up)
    with_victim, without = (
        take(things, robot, (pan, tilt, zoom), (112, 84)) for things in (VICTIM, "")
    )
    screen = screen_of(
        viewport("video", NAME, (40, 8, 112, 84)),
        viewport("over", "visualizeLabel", (0, 0, 160, 96), zpos=9),
    )
    known = made.robot(picture=made.received(with_victim))
    state = dataclasses.replace(STATE, robots={"magellan": known})
    rendered(screen, {"magellan": known}, STATE)
    rows, columns = np.nonzero((with_victim.pixels != without.pixels).any(axis=2))
    foot = int(np.median(columns[rows == rows.max()])), int(rows.max())
    over, video = screen.hits(40 + foot[0], 8 + foot[1], state)
    assert (over.viewport, over.place) == ("over", None)
    assert video.viewport == "video"
    place = video.place
    assert place is not None
    beyond = np.clip((place.x, place.y), FEET_LOW, FEET_HIGH) - (place.x, place.y)
    off = math.hypot(*beyond)
    assert off < 0.03 * place.distance
    assert off < place.uncertainty
    assert place.distance == pytest.approx(math.dist((place.x, place.y), (x, y)))


def test_two_viewports_of_one_camera_share_the_larger_picture(made) -> None:
    filled = visualizer_spec(NAME, fit="fill")
    screen = screen_of(
        viewport("large", NAME, (0, 0, 160, 96), visualizer=filled),
        viewport("small", NAME, (100, 4, 32, 24), zpos=1),
    )
    pixels = np.zeros((120, 160, 3), np.uint8)
    pixels[:, :80, 0] = 250
    known = made.robot(picture=made.received(Picture(pixels=pixels, camera=made.camera())))
    state = dataclasses.replace(STATE, robots={"magellan": known})
    assert screen.picture_needs(state) == {"magellan": {"": PictureNeed(size=(160, 120))}}
    cells = rendered(screen, {"magellan": known}, STATE)
    assert cells is not None
    reds = cells.pixels[..., 0]
    assert (reds[60:] == np.where(np.arange(160) < 80, 250, 0)).all()
    assert (reds[4:28, 100:132] == np.where(np.arange(32) < 16, 250, 0)).all()
