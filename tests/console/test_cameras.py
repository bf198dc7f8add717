"""Several cameras of one robot: which one a viewport shows, asks for and moves."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.vision import CameraCommand, CameraMotion
from rune_tui.compositor.cells import Cells
from rune_tui.layout.spec import CHOSEN
from rune_tui.model.cameras import PictureNeed, camera_of, seen_by, unknown_camera
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ChooseCamera, Notify, SendEffect
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.robot_state import Picture, RobotState
from rune_tui.model.state_changes import changed
from rune_tui.raster.urgency import Urgency
from rune_tui.view import View
from rune_tui.visualizers.words.status_words import status_parts
from tests.console.states import Standing, layout_of, rendered, standing, view_of, visualizer_spec
from tests.console.visualizers.conftest import NOW, Made, received
from tests.console.widgets.presses import down, event_spec, widget_of
from tests.support.car import CAR
from tests.support.messages import camera_state

GREEN, BLUE = 1, 2
STATE = ConsoleState(now=NOW, chosen="magellan")
KEY = event_spec("x")


def picture(channel: int, **camera: Any) -> Picture:
    pixels = np.zeros((48, 64, 3), np.uint8)
    pixels[..., channel] = 200
    return Picture(pixels=pixels, camera=camera_state(**camera))


def car(*, rear: bool = True, age: float = 0.1) -> RobotState:
    """The main camera sees green, the rear one blue."""
    seen = {"rear": received(picture(BLUE, name="rear", mount_yaw=math.pi), age, 9)}
    robot = Made().robot(
        picture=received(picture(GREEN, name="front")),
        messages={ROBOT_DESCRIPTION.name: received(CAR)},
    )
    return robot.with_(pictures=seen if rear else {})


def pane(
    name: str, camera: str, place: tuple[int, int, int, int] = (0, 0, 160, 96), **how: Any
) -> Standing:
    return standing(name, visualizer_spec("visualizeCameraImage", camera=camera), place, **how)


def screen(*panes: Standing) -> View:
    view = View(layout_of(view_of(*panes)))
    view.resize(160, 48)
    return view


def shown(robot: RobotState, *panes: Standing, state: ConsoleState = STATE) -> Cells:
    cells = rendered(screen(*panes), {"magellan": robot}, state)
    assert cells is not None
    return cells


def text(cells: Cells) -> str:
    rows = ("".join(chr(p or 32) for p in row) for row in cells.glyphs.tolist())
    return " ".join(" ".join(rows).split())


def colour(cells: Cells, x: int, y: int) -> int:
    """The strongest channel of a pixel."""
    return int(np.argmax(cells.pixels[y, x]))


def chosen(camera: str) -> ConsoleState:
    return changed(STATE, ChooseCamera(robot="magellan", camera=camera))


@pytest.mark.parametrize(
    ("camera", "state", "channel"),
    [
        ("", STATE, GREEN),
        ("front", STATE, GREEN),
        ("rear", STATE, BLUE),
        (CHOSEN, STATE, GREEN),
        (CHOSEN, chosen("rear"), BLUE),
        (CHOSEN, chosen("front"), GREEN),
        ("", chosen("rear"), GREEN),
    ],
)
def test_a_viewport_shows_the_camera_that_its_layout_or_the_operator_names(
    camera: str, state: ConsoleState, channel: int
) -> None:
    cells = shown(car(), pane("video", camera), state=state)
    assert colour(cells, 80, 60) == channel
    assert text(cells).startswith("rear" if channel == BLUE else "front")


def test_the_only_camera_of_a_robot_has_no_name_on_its_picture() -> None:
    robot = Made().robot(picture=received(picture(GREEN)))
    assert text(shown(robot, pane("video", CHOSEN))) == ""


def test_a_small_viewport_above_a_large_one_is_a_picture_in_the_picture() -> None:
    cells = shown(
        car(), pane("video", ""), pane("small", "rear", (110, 10, 40, 30), zpos=1), state=STATE
    )
    assert colour(cells, 130, 25) == BLUE
    assert colour(cells, 40, 60) == GREEN
    assert colour(cells, 130, 60) == GREEN


def test_a_picture_in_the_picture_is_the_one_that_is_shown_finely_and_clicked_there() -> None:
    view = View(
        layout_of(view_of(pane("video", ""), pane("small", "rear", (110, 10, 40, 30), zpos=1))),
        pixels_per_cell=(2, 4),
    )
    view.resize(160, 48)
    state = dataclasses.replace(STATE, robots={"magellan": car()})
    assert view.render(state) is not None
    small, large = sorted((each.seen for each in view.pictures), key=lambda seen: seen.sum())
    assert small.any()
    assert not (small & large).any()
    assert [hit.camera for hit in view.hits(130, 25, state)] == ["rear", ""]
    assert (view.urgencies[10:12, 115:140] == Urgency.VIDEO).all()


def test_each_camera_on_the_screen_is_asked_for_and_no_other() -> None:
    state = dataclasses.replace(STATE, robots={"magellan": car()})
    both = screen(pane("video", ""), pane("small", "rear", (110, 10, 40, 30), zpos=1))
    assert both.picture_needs(state) == {
        "magellan": {"": PictureNeed(size=(128, 96)), "rear": PictureNeed(size=(40, 30))}
    }
    assert screen(pane("video", "front")).picture_needs(state) == {
        "magellan": {"": PictureNeed(size=(128, 96))}
    }
    one = screen(pane("video", CHOSEN))
    later = dataclasses.replace(state, cameras={"magellan": "rear"})
    assert one.picture_needs(later) == {"magellan": {"rear": PictureNeed(size=(128, 96))}}


def test_an_unknown_camera_is_said_with_those_that_there_are_and_not_asked_for() -> None:
    cells = shown(car(), pane("video", "left"))
    assert "no camera left; it has front, rear" in text(cells)
    state = dataclasses.replace(STATE, robots={"magellan": car()})
    assert screen(pane("video", "left")).picture_needs(state) == {}
    assert unknown_camera("rear", RobotState(name="r", link=car().link)) == ""  # not known yet


def test_a_camera_without_a_picture_yet_is_waited_for() -> None:
    words = text(shown(car(rear=False), pane("video", "rear")))
    assert "waiting for the first picture from camera rear of car" in words


def test_an_old_picture_of_another_camera_is_an_alarm_with_its_name() -> None:
    words = [part.text for part in status_parts(car(age=2.0), STATE)]
    assert "REAR PICTURE 2.0 s OLD" in words


def test_what_is_drawn_over_a_picture_is_seen_by_its_camera() -> None:
    robot = seen_by(car(), "rear")
    assert robot.camera is not None
    assert robot.camera.value.name == "rear"
    assert seen_by(car(rear=False), "rear").camera is None
    geometry = PictureGeometry.of(robot.camera.value, 64, 48)
    assert geometry is not None
    behind, left = geometry.ground_point(32.0, 47.0) or (0.0, 0.0)
    assert behind < -0.5
    assert left == pytest.approx(0.0, abs=1e-6)


def test_a_camera_beside_the_middle_sees_ground_from_its_own_place() -> None:
    def point(**mount: float) -> tuple[float, float]:
        geometry = PictureGeometry.of(camera_state(tilt=-0.3, **mount), 64, 48)
        assert geometry is not None
        found = geometry.ground_point(32.0, 30.0)
        assert found is not None
        x, y = geometry.pixels(found).pixels.tolist()
        assert (x, y) == pytest.approx((32.0, 30.0))
        return found

    middle, beside = point(), point(mount_left=0.3)
    assert beside == pytest.approx((middle[0], middle[1] + 0.3))
    away = middle[0] - camera_state().mount_forward
    left = point(mount_yaw=math.pi / 2)
    assert left == pytest.approx((camera_state().mount_forward, away), abs=1e-9)


def pressed(handler: str, state: ConsoleState, robot: RobotState, **options: Any) -> list[Any]:
    state = dataclasses.replace(state, robots={"magellan": robot})
    return list(widget_of(handler, **options).handle(down("x"), KEY, state))


def test_the_widget_goes_from_camera_to_camera_and_back() -> None:
    first = pressed("widgetChooseCamera", STATE, car())
    assert first == [ChooseCamera(robot="magellan", camera="rear")]
    second = pressed("widgetChooseCamera", chosen("rear"), car())
    assert second == [ChooseCamera(robot="magellan", camera="front")]
    named = pressed("widgetChooseCamera", STATE, car(), camera="rear")
    assert named == first


@pytest.mark.parametrize(
    ("robot", "options", "words"),
    [
        (car(), {"camera": "left"}, "no camera left; it has front, rear"),
        (Made().robot(), {}, "it has no other camera"),
    ],
)
def test_a_camera_that_is_not_there_is_not_chosen(
    robot: RobotState, options: dict[str, str], words: str
) -> None:
    (notice,) = pressed("widgetChooseCamera", STATE, robot, **options)
    assert isinstance(notice, Notify)
    assert notice.notice.text == words


@pytest.mark.parametrize(
    ("camera", "state", "moved"),
    [
        ("", STATE, ""),
        ("rear", STATE, "rear"),
        (CHOSEN, STATE, ""),
        (CHOSEN, chosen("rear"), "rear"),
    ],
)
def test_widgets_move_the_camera_that_is_named(
    camera: str, state: ConsoleState, moved: str
) -> None:
    (pan,) = pressed("widgetAdjustPan", state, car(), camera=camera)
    assert isinstance(pan, SendEffect)
    assert pan.value == CameraCommand(pan=math.radians(5), camera=moved)
    (home,) = pressed("widgetHomePTZ", state, car(), camera=camera)
    assert home.value == CameraCommand(motion=CameraMotion.HOME, camera=moved)


def test_the_name_of_the_main_camera_means_the_main_one() -> None:
    assert camera_of("front", car(), STATE) == camera_of("", car(), STATE) == ""
