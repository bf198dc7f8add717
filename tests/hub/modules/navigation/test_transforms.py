"""Navigation publishes the tree of frames only while somebody subscribes to it."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub.gcm.navigation import DRIVE_STATE
from hub.gcm.transforms import TRANSFORMS
from hub.modules.navigation.__main__ import Navigation
from hub.modules.navigation.reports import transforms
from hub.pose import Pose
from hub.robots.robot_file import find_robot_file, read_description
from tests.hub.modules.timed_bus import TimedBus
from tests.support.messages import drive_state


def test_transforms_are_sent_while_they_have_subscribers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    bus = TimedBus(monkeypatch)
    Navigation(bus, read_description(find_robot_file("magellan"))[0])  # type: ignore[arg-type]

    def sent() -> int:
        return sum(name == TRANSFORMS.name for _, name, _ in bus.published)

    bus.watched = True
    bus.wait(1.0)
    assert sent() == 0, "no driver has reported yet"
    bus.send(DRIVE_STATE, drive_state(reckoning=3), "driver")
    bus.wait(1.0)
    assert 9 <= sent() <= 11
    bus.watched, before = False, sent()
    bus.wait(1.0)
    assert sent() == before


def test_transforms_have_the_correction_and_the_pose_in_space() -> None:
    drive = drive_state(x=1.0, y=2.0, z=0.5, theta=0.3, roll=0.1, pitch=-0.2)
    to_odom, to_base = transforms(drive, Pose(x=4.0, y=5.0, theta=0.6)).transforms
    assert (to_odom.header.frame_id, to_odom.child_frame_id) == ("map", "odom")
    assert (to_odom.transform.translation.x, to_odom.transform.translation.y) == (4.0, 5.0)
    assert to_odom.transform.rotation.roll_pitch_yaw == pytest.approx((0.0, 0.0, 0.6))
    assert (to_base.header.frame_id, to_base.child_frame_id) == ("odom", "base_link")
    assert to_base.transform.translation.z == 0.5
    assert to_base.transform.rotation.roll_pitch_yaw == pytest.approx((0.1, -0.2, 0.3))
