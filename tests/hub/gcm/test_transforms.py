"""The frames of a body as ROS's tf has them, and how its cameras project."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hub.gcm.camera_info import CameraInfo
from hub.gcm.frames import poses_of
from hub.gcm.orientation import rotation
from hub.gcm.standard import Header
from hub.gcm.transforms import TransformStamped, optical_frame, static_transforms
from tests.support.bodies import CARRIER, robot_of

BODY = robot_of(CARRIER).body


def placed(chain: tuple[TransformStamped, ...]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Each frame in `base_link`, followed from parent to child as tools of tf do."""
    poses = {"base_link": (np.eye(3), np.zeros(3))}
    for each in chain:
        turn, origin = poses[each.header.frame_id]
        place = each.transform.translation
        own = turn @ rotation(*each.transform.rotation.roll_pitch_yaw)
        poses[each.child_frame_id] = own, origin + turn @ (place.x, place.y, place.z)
    return poses


def test_static_transforms_are_the_frames_of_the_description() -> None:
    found = placed(static_transforms(BODY).transforms)
    for name, (turn, origin) in poses_of(BODY.frames).items():
        assert found[name][0] == pytest.approx(turn, abs=1e-9)
        assert found[name][1] == pytest.approx(origin, abs=1e-9)


def test_optical_frames_look_along_z_with_x_to_the_right() -> None:
    found = placed(static_transforms(BODY).transforms)
    assert len(BODY.cameras) == 3
    for camera in BODY.cameras:
        seen, optical = found[camera.name][0], found[optical_frame(camera.name)][0]
        assert optical[:, 2] == pytest.approx(seen[:, 0], abs=1e-9)
        assert optical[:, 0] == pytest.approx(-seen[:, 1], abs=1e-9)


def test_a_point_at_the_edge_of_the_view_is_at_the_edge_of_the_picture() -> None:
    fov = math.radians(80.0)
    info = CameraInfo.of(Header(), width_px=640, height_px=480, horizontal_fov=fov)
    projection = info.p.reshape(3, 4)
    edge = projection @ (math.tan(fov / 2.0), 0.0, 1.0, 1.0)
    assert edge[0] / edge[2] == pytest.approx(639.5)  # the right edge of the last pixel
    assert edge[1] / edge[2] == pytest.approx(239.5)
    assert projection[:, :3] == pytest.approx(info.k.reshape(3, 3))


def test_a_camera_of_unknown_size_is_marked_as_not_calibrated() -> None:
    info = CameraInfo.of(Header(), width_px=0, height_px=0, horizontal_fov=1.0)
    assert not info.k.any()
