"""A body that no shipped file describes: seven ranges, a laser, three cameras, sideways motion."""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import pytest

from hub.errors import HandlerFailedError
from hub.gcm import ranges, vision
from hub.gcm.battery import BATTERY
from hub.gcm.beams import beams_of
from hub.gcm.body import ROBOT_DESCRIPTION, Freedom, RangeKind
from hub.gcm.camera_info import CAMERA_INFO
from hub.gcm.transforms import STATIC_TRANSFORMS, TRANSFORMS
from rune_tui.cli import main
from tests.support.bodies import CARRIER, hub_with
from tests.system.harness import HubProcess, Observer

_CAMERAS = "front", "rear", "mast"
HUB = hub_with(CARRIER)


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


def test_the_hub_describes_it_and_its_ranges_come_in_that_order(
    hub: HubProcess, stack: ExitStack
) -> None:
    observer = stack.enter_context(closing(Observer(hub.endpoint, ranges.RANGES)))
    body = observer.client.last_value(ROBOT_DESCRIPTION, timeout=5.0)
    assert [motion.freedom for motion in body.motions] == [
        Freedom.SURGE,
        Freedom.SWAY,
        Freedom.YAW,
    ]
    assert [camera.name for camera in body.cameras] == [*_CAMERAS]
    (_, readings), *_ = observer.seen[ranges.RANGES.name]
    assert [scan.header.frame_id for scan in readings.scans] == [
        group.name for group in body.ranges
    ]
    beams = beams_of(body)
    measured = beams.ranges(readings)
    laser = measured[beams.of_kind(RangeKind.LASER)]
    assert len(measured) == 181 + 7
    assert np.isfinite(laser).all(), "the empty hall has walls all around"


def test_tools_of_ros_get_its_frames_and_how_its_cameras_project(
    hub: HubProcess, stack: ExitStack
) -> None:
    wanted = TRANSFORMS, CAMERA_INFO, BATTERY
    observer = stack.enter_context(closing(Observer(hub.endpoint, *wanted)))
    newest = {name: history[-1][1] for name, history in observer.seen.items()}
    moving = newest[TRANSFORMS.name].transforms
    assert [(each.header.frame_id, each.child_frame_id) for each in moving] == [
        ("map", "odom"),
        ("odom", "base_link"),
    ]
    kept = observer.client.last_value(STATIC_TRANSFORMS, timeout=5.0)
    parents = {each.child_frame_id: each.header.frame_id for each in kept.transforms}
    cameras = newest[CAMERA_INFO.name].cameras
    assert [parents[each.header.frame_id] for each in cameras] == [*_CAMERAS]
    assert 0.9 < newest[BATTERY.name].percentage <= 1.0


def test_each_camera_has_its_own_picture(hub: HubProcess, stack: ExitStack) -> None:
    observer = stack.enter_context(closing(Observer(hub.endpoint)))

    def ask(camera: str) -> vision.Image:
        request = vision.ImageRequest(width_px=32, height_px=24, camera=camera)
        return observer.client.query_response(
            vision.IMAGE_REQUEST, request, vision.IMAGE, timeout=5.0
        )

    assert [ask(name).camera.name for name in _CAMERAS] == [*_CAMERAS]
    assert ask("").camera.name == "front"
    with pytest.raises(HandlerFailedError, match="no camera 'left'; the robot has front, rear"):
        ask("left")


def test_a_layout_is_made_for_it(hub: HubProcess, tmp_path: Path) -> None:
    path = tmp_path / "carrier.xml"
    assert main(["layout", "auto", "--hub", hub.endpoint, "-o", str(path)]) == 0
    assert main(["check", str(path)]) == 0
    text = path.read_text()
    assert 'value="rear"' in text
    assert "visualizeRangeData" in text
