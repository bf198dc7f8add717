"""Cameras give no more pictures per second than a link shaper at the hub allows."""

from __future__ import annotations

import numpy as np
import pytest

from hub.gcm import vision
from hub.gcm.body import BodyFrame
from hub.gcm.pose_history import PoseHistory
from hub.gcm.shaper import SHAPER_STATE, ShaperState
from hub.modules.vision.camera_service import CameraService
from hub.modules.vision.picture_rate import PictureRateLimit
from hub.modules.vision.stances import Stances
from hub.robots.interfaces import Picture
from tests.support.cases import for_each
from tests.support.messages import camera_state


class CountingCamera:
    """A camera that turns while nobody takes pictures, and counts those that are taken."""

    def __init__(self) -> None:
        self.taken = 0

    def advance(self, _: float) -> None:
        pass

    def take(self, width_px: int, height_px: int, now: float) -> Picture:
        self.taken += 1
        pixels = np.full((height_px, width_px, 3), self.taken, np.uint8)
        return Picture(pixels=pixels, measured=now, horizontal_fov=1.0)

    def camera_state(self, stamp: float) -> vision.CameraState:
        return camera_state(stamp=stamp, pan=self.taken / 100.0)


def shaped(rate: float, address: str = "127.0.0.2") -> ShaperState:
    return ShaperState(
        profile="own", digest="", seed=1, address=address, elapsed=0.0, picture_rate=rate
    )


@pytest.fixture
def clock() -> list[float]:
    return [100.0]


@pytest.fixture
def camera() -> CountingCamera:
    return CountingCamera()


@pytest.fixture
def service(camera: CountingCamera, clock: list[float]) -> CameraService:
    return CameraService(
        BodyFrame(name="front"),
        camera,  # type: ignore[arg-type]
        PoseHistory(),
        Stances(stands=True),
        clock=lambda: clock[0],
    )


def asked(size: tuple[int, int] = (16, 12)) -> vision.ImageRequest:
    return vision.ImageRequest(width_px=size[0], height_px=size[1])


@for_each("rate", [2.0, 5.0, 10.0, 15.0])
def test_new_pictures_come_at_the_rate_and_old_ones_between(rate: float) -> None:
    camera, clock = CountingCamera(), [100.0]
    made = CameraService(
        BodyFrame(name="front"),
        camera,  # type: ignore[arg-type]
        PoseHistory(),
        Stances(stands=True),
        clock=lambda: clock[0],
    )
    stamps = []
    for number in range(600):
        clock[0] = 100.0 + number / 60.0
        image, measured = made.picture(asked(), rate)
        stamps.append(measured)
        assert clock[0] - measured <= 1.0 / rate + 1e-9
        assert image.camera.pan == pytest.approx(len(set(stamps)) / 100.0)
    assert camera.taken == len(set(stamps)) == pytest.approx(10.0 * rate, abs=2)


def test_without_a_limit_each_picture_is_new(
    service: CameraService, camera: CountingCamera
) -> None:
    for _ in range(5):
        service.picture(asked())
    assert camera.taken == 5


def test_another_size_is_taken_at_once(service: CameraService, camera: CountingCamera) -> None:
    service.picture(asked(), 1.0)
    service.picture(asked((8, 6)), 1.0)
    assert camera.taken == 2


def test_the_lowest_limit_of_shapers_that_live_counts() -> None:
    limit = PictureRateLimit()
    assert limit.at(0.0) == 0.0
    limit.hear(shaped(10.0), 0.0)
    limit.hear(shaped(5.0, "127.0.0.3"), 1.0)
    assert limit.at(1.0) == 5.0
    limit.hear(shaped(0.0, "127.0.0.3"), 1.5)
    assert limit.at(1.5) == 10.0
    assert limit.at(SHAPER_STATE.lifespan_s + 0.1) == 0.0
