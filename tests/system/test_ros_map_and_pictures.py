"""A hub on a simulated robot with ROS: its pictures, its own map, and a driver that is killed."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from hub.errors import HandlerFailedError
from hub.gcm import mapping, rle, vision
from hub.gcm.navigation import DRIVE_STATE, ROBOT_STATE
from hub.gcm.occupancy_map import OccupancyMap
from tests.support.ros_robot import SimulatedRos
from tests.system.harness import HubProcess, Observer

TABLES = """
[ros]
address = "{address}"
map = "/map"
[[range]]
name = "lidar"
kind = "laser"
beams = 60
first_deg = -180.0
farthest = 12.0
topic = "/scan"
[camera]
topic = "/camera/image_raw/compressed"
info = "/camera/camera_info"
"""
MODULES = ("driver", "navigation", "vision", "mapping")


@pytest.fixture
def observer(tmp_path: Path) -> Iterator[tuple[HubProcess, Observer]]:
    with closing(SimulatedRos(tmp_path, "--arena", "yellow", "--clock", "86400")) as robot:
        tables = TABLES.format(address=robot.address)
        with (
            closing(HubProcess(tmp_path, kind="ros", modules=MODULES, tables=tables)) as hub,
            closing(Observer(hub.endpoint, ROBOT_STATE, DRIVE_STATE)) as made,
        ):
            yield hub, made


def test_its_pictures_and_its_map_come_and_its_place_outlives_the_driver(
    observer: tuple[HubProcess, Observer],
) -> None:
    hub, seen = observer
    picture = _asked(seen, vision.IMAGE_REQUEST, vision.ImageRequest(width_px=64, height_px=48))
    assert (picture.width_px, picture.height_px) == (64, 48)
    assert rle.decode(picture.data, 48, 64, picture.channels).std() > 10.0
    assert abs(time.time() - picture.camera.stamp) < 2.0

    def whole() -> OccupancyMap:
        return OccupancyMap.of(_asked(seen, mapping.MAP_REQUEST, mapping.MapRequest()))

    # No scan from the start sees all of the arena's cells.
    seen.wait(lambda: (whole().cells >= 0).sum() > 30_000, 20.0, "the robot's own map is not used")

    before = _newest(seen, DRIVE_STATE)
    os.kill(hub.pids["driver"], signal.SIGKILL)
    killed = time.monotonic()
    history = seen.seen[DRIVE_STATE.name]
    seen.wait(lambda: history[-1][0] > killed + 0.2, 20.0, "the driver does not come back")
    after = _newest(seen, DRIVE_STATE)
    assert after.reckoning == before.reckoning
    assert _newest(seen, ROBOT_STATE).frame


def _newest(seen: Observer, definition: Any) -> Any:
    return seen.seen[definition.name][-1][1]


def _asked(seen: Observer, request: Any, value: Any) -> Any:
    """The answer, as soon as there is one."""
    answers: list[Any] = []
    answer = vision.IMAGE if request is vision.IMAGE_REQUEST else mapping.MAP

    def ask() -> bool:
        try:
            answers.append(seen.client.query_response(request, value, answer, timeout=5.0))
        except HandlerFailedError:
            return False
        return True

    seen.wait(ask, 20.0, "no answer comes")
    return answers[-1]
