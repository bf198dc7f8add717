"""Pictures of a robot that cannot send all codings, and of a console that is slow to show them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hub.errors import HandlerFailedError
from hub.gcm.vision import IMAGE, IMAGE_REQUEST, Image, ImageCoding, ImageRequest
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.modules.vision.coding import code
from rune_tui.layout.spec import CapabilitySpec, RobotSpec
from rune_tui.link.camera_streams import CameraStreams
from rune_tui.link.robot_link import RobotLink
from rune_tui.model.cameras import PictureNeed
from rune_tui.model.console_state import PictureWish
from tests.support.messages import camera_state
from tests.support.waiting import until


class Robot:
    """Answers for pictures in the codings it has, and remembers what it was asked for."""

    def __init__(self, endpoint: str) -> None:
        self.client = Client("robot", endpoint)
        self.codings = frozenset(ImageCoding)
        self.asked: list[ImageRequest] = []
        self.before_answer: Callable[[], None] = lambda: None
        self.client.respond(IMAGE_REQUEST, IMAGE, self._answer)

    def _answer(self, request: ImageRequest) -> Image:
        self.asked.append(request)
        self.before_answer()
        if request.coding not in self.codings:
            text = "not this one"
            raise HandlerFailedError(text)
        pixels = np.zeros((request.height_px, request.width_px, 3), np.uint8)
        data = code(pixels, request.coding, request.quality)
        return Image(
            camera=camera_state(name=request.camera),
            coding=request.coding,
            width_px=request.width_px,
            height_px=request.height_px,
            channels=3,
            data=data,
        )

    def serve(self) -> None:
        self.client.listen(0.01)

    def close(self) -> None:
        self.client.close()


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    with ExitStack() as stack:
        central = stack.enter_context(closing(Central([f"ipc://{tmp_path}/c"])))
        yield stack.enter_context(closing(Robot(central.endpoints[0])))


@pytest.fixture
def make_link(robot: Robot) -> Iterator[Callable[..., RobotLink]]:
    with ExitStack() as stack:

        def make(*, near: bool) -> RobotLink:
            video = CapabilitySpec(name="VIS_VID", interval_s=0.01)
            spec = RobotSpec(name="m", hub=robot.client.endpoint, capabilities=(video,))
            made = RobotLink(spec, near=near)
            made.start()
            return stack.enter_context(closing(made))

        yield make


@pytest.fixture
def link(make_link: Callable[..., RobotLink]) -> RobotLink:
    return make_link(near=False)


@pytest.fixture
def wait(robot: Robot) -> Callable[[Callable[[], object]], None]:
    return lambda condition: until(condition, 15.0, meanwhile=robot.serve)


@pytest.mark.parametrize("coding", [ImageCoding.WEBP, ImageCoding.JPEG, ImageCoding.RLE])
def test_the_first_picture_comes_in_the_best_coding_that_the_robot_has(
    robot: Robot, link: RobotLink, wait: Callable[..., None], coding: ImageCoding
) -> None:
    better = {ImageCoding.WEBP: 0, ImageCoding.JPEG: 1, ImageCoding.RLE: 2}
    robot.codings = frozenset(each for each in better if better[each] >= better[coding])
    link.want_pictures({"": PictureNeed(size=(32, 24))})
    wait(lambda: link.state.picture is not None)
    assert [each.coding for each in robot.asked[: better[coding] + 1]] == [*better][
        : better[coding] + 1
    ]
    wait(lambda: link.state.link.pictures is not None)
    flow = link.state.link.pictures
    assert flow is not None
    assert flow.coding is coding
    assert link.state.link.detail == ""


def test_the_next_is_asked_for_only_when_the_last_is_shown(
    robot: Robot, link: RobotLink, wait: Callable[..., None]
) -> None:
    link.want_pictures({"": PictureNeed(size=(32, 24))})
    wait(lambda: link.state.picture is not None)
    for _ in range(50):
        robot.serve()
    asked = len(robot.asked)  # again only where an answer took longer than it may
    picture = link.state.picture
    assert picture is not None
    assert asked < 10
    link.shown(picture.number)
    wait(lambda: len(robot.asked) > asked)


def test_what_the_layout_asks_for_is_asked_for(
    robot: Robot, link: RobotLink, wait: Callable[..., None]
) -> None:
    link.want_pictures(
        {"": PictureNeed(size=(32, 24))}, PictureWish(coding=ImageCoding.RAW, quality=7)
    )
    wait(lambda: link.state.picture is not None)
    # It asks again where an answer takes long.
    asked = ImageRequest(width_px=32, height_px=24, quality=7, coding=ImageCoding.RAW)
    assert set(robot.asked) == {asked}


def test_on_the_robots_own_machine_pictures_are_run_lengths_from_the_first(
    robot: Robot, make_link: Callable[..., RobotLink], wait: Callable[..., None]
) -> None:
    link = make_link(near=True)
    link.want_pictures({"": PictureNeed(size=(32, 24))})
    wait(lambda: link.state.picture is not None)
    assert set(robot.asked) == {ImageRequest(width_px=32, height_px=24)}


def test_pictures_of_each_shown_camera_are_kept_by_its_name(
    robot: Robot, link: RobotLink, wait: Callable[..., None]
) -> None:
    link.want_pictures({"": PictureNeed(size=(32, 24)), "rear": PictureNeed(size=(16, 12))})
    wait(lambda: link.state.picture is not None and "rear" in link.state.pictures)
    rear = link.state.pictures["rear"]
    assert rear.value.camera.name == "rear"
    assert rear.value.pixels.shape == (12, 16, 3)
    wait(lambda: link.state.link.pictures is not None)
    asked = len([each for each in robot.asked if each.camera == "rear"])

    def is_asked_again() -> bool:
        link.shown(link.state.pictures["rear"].number, "rear")  # of the newest: it may be another
        return len([each for each in robot.asked if each.camera == "rear"]) > asked

    wait(is_asked_again)


def test_a_camera_that_is_not_shown_any_more_is_not_asked_and_its_picture_is_forgotten(
    robot: Robot, link: RobotLink, wait: Callable[..., None]
) -> None:
    link.want_pictures({"": PictureNeed(size=(32, 24))})
    wait(lambda: link.state.picture is not None)
    link.want_pictures({"rear": PictureNeed(size=(32, 24))})
    wait(lambda: "rear" in link.state.pictures and link.state.picture is None)
    robot.asked.clear()
    for _ in range(3):
        picture = link.state.pictures["rear"]
        link.shown(picture.number, "rear")
        wait(lambda picture=picture: link.state.pictures["rear"].number > picture.number)
    assert {each.camera for each in robot.asked} == {"rear"}
    assert link.state.picture is None


def test_a_picture_that_comes_after_the_choice_of_another_camera_is_not_kept(
    robot: Robot, link: RobotLink, wait: Callable[..., None]
) -> None:
    robot.before_answer = lambda: link.want_pictures({"rear": PictureNeed(size=(32, 24))})
    link.want_pictures({"": PictureNeed(size=(32, 24))})
    wait(lambda: "rear" in link.state.pictures)
    assert [each.camera for each in robot.asked[:2]] == ["", "rear"]
    assert link.state.picture is None


class Asking(Client):
    """A client that counts its open requests."""

    open = 0

    def query_notify(
        self, *args: Any, answered: Callable[..., None], failed: Callable[..., None], **named: Any
    ) -> None:
        def over(then: Callable[..., None], *values: Any) -> None:
            self.open -= 1
            then(*values)

        self.open += 1
        ends = {"answered": partial(over, answered), "failed": partial(over, failed)}
        super().query_notify(*args, **named, **ends)


class Cameras:
    """The pictures of a robot's cameras, by a clock that the test moves; all are shown at once."""

    def __init__(self, robot: Robot, client: Asking) -> None:
        self.robot, self.client, self.now, self.taken = robot, client, 100.0, 0
        self.streams = CameraStreams(
            client, self._take, lambda _: None, lambda _: None, lambda: self.now
        )
        self.streams.follow(0.066)

    def want(self, **needs: PictureNeed) -> None:
        done: list[bool] = []
        self.streams.want(needs, PictureWish(coding=ImageCoding.RAW))
        self.client.post(lambda: done.append(True))
        until(lambda: done, 15.0, meanwhile=self._serve)

    def asked(self, seconds: float) -> list[str]:
        """The cameras that are asked in a time; each answer arrives before the clock moves on."""
        before = len(self.robot.asked)
        for _ in range(round(seconds / 0.01)):
            self._serve()
            self.streams.step()
            until(lambda: not self.client.open, 15.0, meanwhile=self._serve)
            self.now += 0.01
        return [each.camera for each in self.robot.asked[before:]]

    def _serve(self) -> None:
        self.robot.client.listen(0.0)
        self.client.listen(0.0)

    def _take(self, camera: str, _image: Image, _reception: MessageInfo) -> int:
        self.taken += 1
        self.streams.shown(self.taken, camera)
        return self.taken


@pytest.fixture
def cameras(robot: Robot) -> Iterator[Cameras]:
    with closing(Asking("console", robot.client.endpoint)) as client:
        made = Cameras(robot, client)
        made.want(front=PictureNeed(size=(16, 12)))
        until(lambda: made.taken, 15.0, meanwhile=lambda: made.asked(0.1))  # both are connected
        made.want()
        made.now += 10.0
        yield made


def test_each_camera_is_asked_as_often_as_its_viewports_need(cameras: Cameras) -> None:
    cameras.want(
        front=PictureNeed(size=(32, 24), interval_s=0.333), rear=PictureNeed(size=(32, 24))
    )
    asked = cameras.asked(2.0)
    assert 5 <= asked.count("front") <= 7
    assert 27 <= asked.count("rear") <= 31


def test_a_camera_that_is_needed_more_often_is_asked_at_once_and_a_hidden_one_never(
    cameras: Cameras,
) -> None:
    cameras.want(front=PictureNeed(size=(16, 12), interval_s=0.333))
    assert cameras.asked(0.05) == ["front"]
    cameras.want(front=PictureNeed(size=(64, 48)))
    assert cameras.asked(0.07) == ["front"]
    assert cameras.robot.asked[-1].width_px == 64
    cameras.want()
    assert cameras.asked(0.5) == []
