"""What vision can do, by the camera that a robot file names."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub.gcm.capability import Capability
from hub.modules.vision.__main__ import abilities
from hub.robots.description import RobotDescription
from hub.robots.robot_file import SHIPPED, read_description


def robot_with(folder: Path, source: str) -> RobotDescription:
    path = folder / "robot.toml"
    text = (SHIPPED / "magellan.toml").read_text()
    path.write_text(f"{text}[camera]\nsource = {source!r}\n")
    robot, problems = read_description(path)
    assert not problems
    return robot


def test_the_simulated_camera_turns_and_needs_to_know_where_it_is(tmp_path: Path) -> None:
    can = abilities(robot_with(tmp_path, "robot"))
    assert can.provides == (
        Capability.VIS_VID,
        Capability.VIS_PTZ,
        Capability.VIS_NIGHT,
        Capability.DRV_LIGHT,
    )
    assert can.needs == (Capability.SIM_TRUTH,)


@pytest.mark.parametrize("source", ["/dev/video0", "drive.mp4", "rtsp://10.0.0.7/x"])
def test_another_camera_stands_still_and_needs_nobody(tmp_path: Path, source: str) -> None:
    can = abilities(robot_with(tmp_path, source))
    assert can.provides == (Capability.VIS_VID, Capability.VIS_NIGHT)
    assert can.needs == ()
