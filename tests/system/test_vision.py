"""Pictures from real hubs: codings, pose, night, and cameras of other kinds."""

from __future__ import annotations

import contextlib
import io
import math
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as PillowImage

from hub.errors import HandlerFailedError
from hub.gcm import navigation, rle, vision
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.geometry import TwistStamped
from hub.gcm.supervision import MODULE_INFO
from hub.gcm.vehicle import VEHICLE_COMMAND, VehicleCommand, VehicleOrder
from hub.sim.arena import SHIPPED
from tests.hub.robots.videos import CameraServer, make_video
from tests.support.waiting import until
from tests.system.harness import HubProcess, Observer

StartHub = Callable[..., HubProcess]


def ask(observer: Observer, **fields: Any) -> vision.Image:
    request = vision.ImageRequest(**{"width_px": 64, "height_px": 48, "quality": 100} | fields)
    return observer.client.query_response(vision.IMAGE_REQUEST, request, vision.IMAGE, timeout=5.0)


def pixels_of(image: vision.Image) -> np.ndarray:
    pixels = rle.decode(image.data, image.height_px, image.width_px, image.channels)
    return pixels.astype(float)


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture
def dark_hub(start_hub: StartHub, tmp_path: Path) -> HubProcess:
    """A robot in the yellow arena at night."""
    arena = (SHIPPED / "yellow.toml").read_text().replace("[hall]", "[hall]\nlight = 0.04")
    (tmp_path / "night.toml").write_text(arena)
    return start_hub(arena="night.toml")


def test_at_night_gain_and_headlight_bring_back_the_picture(
    dark_hub: HubProcess, stack: ExitStack
) -> None:
    observer = stack.enter_context(closing(Observer(dark_hub.endpoint, vision.CAMERA_STATE)))

    def switch(**fields: Any) -> None:
        observer.client.publish(vision.NIGHT_COMMAND, vision.NightCommand(**fields))

    black = ask(observer)
    assert pixels_of(black).mean() < 12
    assert (black.camera.gain, black.camera.headlight) == (1.0, 0.0)

    def brightness(**fields: Any) -> float:
        switch(**fields)
        return float(pixels_of(ask(observer)).mean())

    observer.wait(lambda: brightness(on=1, headlight=0.0) > 50, 10.0, "the gain did not rise")
    image = ask(observer)
    assert image.camera.gain > 4.0
    assert image.camera.headlight == 0.0
    observer.wait(lambda: brightness(on=1, headlight=1.0) > 50, 10.0)
    observer.wait(lambda: ask(observer).camera.headlight == 1.0, 10.0)
    observer.wait(lambda: ask(observer).camera.gain < image.camera.gain / 1.5, 10.0)
    observer.wait(lambda: brightness(on=0) < 12, 10.0)
    state = observer.seen[vision.CAMERA_STATE.name]
    observer.wait(lambda: state[-1][1].headlight == 0.0 and state[-1][1].gain == 1.0, 10.0)


def test_the_light_of_a_camera_is_switched_like_any_light(
    hub: HubProcess, stack: ExitStack
) -> None:
    observer = stack.enter_context(closing(Observer(hub.endpoint, vision.CAMERA_STATE)))
    states = observer.seen[vision.CAMERA_STATE.name]

    def lit(brightness: float) -> bool:
        command = VehicleCommand(order=VehicleOrder.LIGHT, name="headlight", value=brightness)
        observer.client.publish(VEHICLE_COMMAND, command)
        return bool(states) and states[-1][1].headlight == pytest.approx(brightness)

    observer.wait(lambda: lit(0.7), 10.0)
    assert states[-1][1].gain == 1.0, "night mode stays off"
    observer.wait(lambda: lit(0.0), 10.0)


def test_pictures_come_from_the_video_file_that_a_robot_names(
    start_hub: StartHub, stack: ExitStack, tmp_path: Path
) -> None:
    pytest.importorskip("av", reason="PyAV is not installed")
    path = tmp_path / "drive.mp4"
    hub = start_hub(tables='[camera]\nsource = "drive.mp4"\nfov_deg = 90.0\nheight = 0.5')
    observer = stack.enter_context(closing(Observer(hub.endpoint, MODULE_INFO)))
    with pytest.raises(HandlerFailedError, match=r"drive.mp4|ask again in a moment"):
        ask(observer)
    make_video(path)

    def red_on_the_left() -> bool:
        try:
            pixels = pixels_of(ask(observer))
        except HandlerFailedError:
            return False
        return bool((np.abs(pixels[40, 4] - (220, 30, 30)) < 30).all())

    observer.wait(red_on_the_left, 20.0, hub.log.read_text())
    camera = ask(observer).camera
    assert camera.horizontal_fov == pytest.approx(math.pi / 2)
    assert (camera.mount_height, camera.pan_limit) == (0.5, 0.0)
    infos = observer.seen[MODULE_INFO.name]

    def said() -> str:
        return " ".join(info.capabilities for _, info in infos if info.name == "vision")

    until(said, 10.0, meanwhile=lambda: observer.client.listen(0.05))
    assert "VIS_VID VIS_NIGHT" in said()
    assert "VIS_PTZ" not in said()


def test_every_coding_gives_the_same_picture(hub: HubProcess, stack: ExitStack) -> None:
    observer = stack.enter_context(closing(Observer(hub.endpoint, navigation.ROBOT_STATE)))
    exact = ask(observer)
    raw = ask(observer, coding=vision.ImageCoding.RAW)
    assert (exact.coding, raw.coding) == (vision.ImageCoding.RLE, vision.ImageCoding.RAW)
    assert np.array_equal(raw.data.reshape(48, 64, 3), pixels_of(exact))
    jpeg = ask(observer, coding=vision.ImageCoding.JPEG, kind=vision.ImageKind.GREY, quality=90)
    assert jpeg.channels == 1
    with PillowImage.open(io.BytesIO(jpeg.data.tobytes())) as file:
        assert (file.size, file.mode) == ((64, 48), "L")
    with pytest.raises(HandlerFailedError, match="quality is 0, not 1 to 100"):
        ask(observer, quality=0)


def test_pictures_say_when_and_where_they_were_taken(hub: HubProcess, stack: ExitStack) -> None:
    observer = stack.enter_context(closing(Observer(hub.endpoint, navigation.ROBOT_STATE)))
    seen: list[vision.Image] = []

    def known() -> bool:
        seen.append(ask(observer))
        return math.isfinite(seen[-1].camera.robot_x)

    observer.wait(known, 10.0, "no picture has a pose")
    camera = seen[-1].camera
    _, state = observer.seen[navigation.ROBOT_STATE.name][-1]
    place = (camera.robot_x, camera.robot_y, camera.robot_theta)
    assert place == pytest.approx((state.x, state.y, state.theta), abs=0.01)
    assert abs(time.time() - camera.stamp) < 5.0
    assert camera.mount_height > 0.1
    narrow = ask(observer, width_px=20, height_px=100).camera
    assert narrow.horizontal_fov < camera.horizontal_fov / 3


class NoisyScene:
    """What a camera sees of a room as the robot turns, behind a coder that adds noise.

    Attributes:
        turn: Where the robot looked when the picture was taken [rad].
    """

    def __init__(self) -> None:
        self.turn = 0.0
        self._random = np.random.default_rng(3)
        blocks = self._random.integers(0, 255, (12, 80, 3))
        self._room = np.kron(blocks, np.ones((8, 8, 1)))

    def draw(self) -> np.ndarray:
        begin = round(100.0 * self.turn) % 640
        seen = np.roll(self._room, -begin, axis=1)[:, :128]
        return np.clip(seen + self._random.normal(0.0, 2.0, seen.shape), 0, 255).astype(np.uint8)


def test_a_frozen_camera_behind_a_noisy_coder_is_an_alarm_once_the_robot_has_moved(
    start_hub: StartHub, stack: ExitStack
) -> None:
    pytest.importorskip("av", reason="PyAV is not installed")
    scene = NoisyScene()
    server = stack.enter_context(closing(CameraServer(scene.draw)))
    hub = start_hub(tables=f'[camera]\nsource = "{server.address}"\nfov_deg = 60.0\nheight = 0.5')
    seen = (navigation.GROUND_TRUTH, navigation.ROBOT_STATE)
    observer = stack.enter_context(closing(Observer(hub.endpoint, *seen)))
    problems: list[str] = []
    observer.client.subscribe(
        DIAGNOSTICS, lambda value, _: problems.extend(each.message for each in value.status)
    )
    turned, before = 0.0, observer.truth.theta

    def turns(radians: float) -> bool:
        """Turn further; returns whether the robot has turned so far since the start."""
        nonlocal turned, before
        for speed in (0.0, 0.6):  # on a busy machine the robot may wait for neutral again
            observer.client.publish(navigation.VELOCITY_COMMAND, TwistStamped.planar(0.0, speed))
        with contextlib.suppress(HandlerFailedError):  # no picture has come yet
            ask(observer)
        now = observer.truth.theta
        turned += math.remainder(now - before, math.tau)
        before = now
        return turned >= radians

    def looks(radians: float) -> bool:
        there = turns(radians)
        scene.turn = turned
        return there

    observer.wait(lambda: looks(4.0), 60.0, hub.log.read_text())
    assert not [each for each in problems if "camera" in each]
    frozen = turned
    observer.wait(lambda: turns(frozen + 10.0) or any("camera" in each for each in problems), 60.0)
    assert "it is frozen" in next(each for each in problems if "camera" in each)
    assert turned - frozen > 0.9, "before, the robot did not move far enough to know it"
    observer.client.publish(navigation.VELOCITY_COMMAND, TwistStamped())
