"""A camera that repeats a picture with new stamps gets old; one without pictures is an alarm."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
import pytest

from hub.errors import CameraError
from hub.gcm import vision
from hub.gcm.body import BodyFrame
from hub.gcm.diagnostics import Severity
from hub.gcm.pose_history import PoseHistory
from hub.gcm.vision import CameraState
from hub.modules.vision.camera_service import CameraService
from hub.modules.vision.stances import Stances
from hub.modules.vision.travel import Travel
from hub.robots.interfaces import Picture
from tests.support.messages import camera_state, robot_state

ASKED = vision.ImageRequest(width_px=16, height_px=12)
FROZEN = np.arange(576, dtype=np.int64).reshape(12, 16, 3).astype(np.uint8)


class FrozenCamera:
    """Gives the same pixels with new stamps."""

    def __init__(self) -> None:
        self.pan, self.fault = 0.0, ""

    def advance(self, seconds: float) -> None:
        """It needs no time."""

    def camera_state(self, stamp: float) -> CameraState:
        return camera_state(stamp=stamp, pan=self.pan)

    def take(self, width_px: int, height_px: int, now: float) -> Picture:
        if self.fault:
            raise CameraError(self.fault)
        assert (height_px, width_px) == FROZEN.shape[:2]
        return Picture(pixels=FROZEN.copy(), measured=now, horizontal_fov=0.8)


class Watched:
    """A camera service, its clock and the motion of its robot."""

    def __init__(self, **options: Any) -> None:
        self.now, self.travel, self.camera = 100.0, Travel(), FrozenCamera()
        self.service = CameraService(
            BodyFrame(name="front"),
            self.camera,  # type: ignore[arg-type]
            PoseHistory(),
            Stances(stands=True),
            clock=lambda: self.now,
            **({"travel": self.travel} | options),
        )

    def look(self, seconds: float, linear: float = 0.0) -> float:
        """Ask for ten pictures a second; returns the age of the last one [s]."""
        measured = self.now
        for _ in range(round(10 * seconds)):
            self.now += 0.1
            self.travel.moved(robot_state(linear=linear), self.now)
            with contextlib.suppress(CameraError):
                _, measured = self.service.picture(ASKED)
        return self.now - measured

    @property
    def said(self) -> list[tuple[Severity, str]]:
        return [(each.level, each.message) for each in self.service.problems()]


@pytest.fixture
def watched() -> Watched:
    return Watched()


def test_while_the_robot_stands_it_is_no_alarm(watched: Watched) -> None:
    assert watched.look(4.0) == 0.0
    assert watched.said == []
    assert watched.look(8.0) == 0.0
    assert watched.said == [(Severity.OK, "camera front: the same picture for 12 s")]


def test_once_the_robot_moves_the_picture_is_as_old_as_the_first(watched: Watched) -> None:
    watched.look(4.1)
    assert watched.look(2.0, linear=0.3) == pytest.approx(6.0)
    text = "camera front repeats a picture of 6 s ago: it is frozen"
    assert watched.said == [(Severity.ERROR, text)]
    assert watched.look(1.0) == pytest.approx(7.0), "it stands again, and the picture is no newer"
    watched.now += 4.0
    assert watched.said == [], "no picture is taken"


def test_a_camera_without_pictures_is_an_alarm_until_they_come(watched: Watched) -> None:
    watched.camera.fault = "no pictures come from it"
    watched.look(4.8)
    assert watched.said == [], "a stream needs some time to begin"
    watched.look(0.5)
    assert watched.said == [(Severity.ERROR, "camera front: no pictures come from it")]
    watched.camera.fault = ""
    watched.look(0.1)
    assert watched.said == []
    watched.camera.fault = "it was unplugged"
    watched.look(6.0)
    assert watched.said == [(Severity.ERROR, "camera front: it was unplugged")]
    watched.now += 4.0
    assert watched.said == [], "no client asks for pictures"


def test_a_head_that_turns_shows_it_too(watched: Watched) -> None:
    watched.look(2.0)
    watched.camera.pan = 0.3
    assert watched.look(0.1) == pytest.approx(2.0)


def test_a_simulated_camera_repeats_nothing() -> None:
    watched = Watched(travel=None)
    assert watched.look(9.0, linear=0.3) == 0.0
    assert watched.said == []
