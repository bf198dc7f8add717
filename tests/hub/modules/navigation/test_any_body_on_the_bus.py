"""The navigation process of a base that also drives sideways: its commands, ranges and tilt."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import numpy as np
import pytest

from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.geometry import Twist, TwistStamped, Vector3
from hub.gcm.imu import IMU, Imu
from hub.gcm.navigation import DRIVE_COMMAND, DRIVE_STATE, VELOCITY_COMMAND
from hub.gcm.ranges import RANGES, RangeReadings, scan_of
from hub.modules.navigation.__main__ import Navigation
from hub.robots.description import RobotDescription
from hub.robots.robot_file import read_description
from tests.hub.modules.navigation.test_lost_place import AT_ORIGIN
from tests.hub.modules.timed_bus import TimedBus

ROBOT_FILE = """
name = "crab"
kind = "simulated-wheels"
[limits]
sway = 0.4
heave = 0.2
[[range]]
name = "laser"
kind = "laser"
beams = 360
farthest = 8.0
"""
SIDEWAYS = Twist(linear=Vector3(y=0.3, z=0.5), angular=Vector3(x=0.1))


class Scene:
    """An operator pushes the stick to the left and up."""

    def __init__(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
        path = tmp_path / "robot.toml"
        path.write_text(ROBOT_FILE)
        self.robot: RobotDescription = read_description(path)[0]
        self.bus = TimedBus(monkeypatch)
        Navigation(self.bus, self.robot)  # type: ignore[arg-type]
        self.bus.send(DRIVE_STATE, AT_ORIGIN, "driver")
        self.bus.send(VELOCITY_COMMAND, TwistStamped(), "console")

    def measure(self, left: float, sender: str = "driver") -> None:
        """The laser measures a range to the left [m], and nothing elsewhere."""
        (group,) = self.robot.body.ranges
        ranges = np.full(group.beams, np.inf, np.float32)
        ranges[round((math.pi / 2.0 - group.first) / group.step)] = left
        scans = (scan_of(group, ranges, self.bus.now),)
        self.bus.send(RANGES, RangeReadings(scans=scans), sender)

    def commanded(self) -> Twist:
        """What the driver gets for the stick."""
        self.bus.send(DRIVE_STATE, AT_ORIGIN, "driver")
        self.bus.send(VELOCITY_COMMAND, TwistStamped.of(SIDEWAYS), "console")
        given = [each for _, name, each in self.bus.published if name == DRIVE_COMMAND.name]
        twist: Twist = given[-1].twist
        return twist


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Scene:
    return Scene(tmp_path, monkeypatch)


def test_in_the_open_each_motion_that_the_body_has_is_passed_on(scene: Scene) -> None:
    scene.measure(5.0)
    given = scene.commanded()
    assert given.linear.y > 0.2
    assert given.linear.z == 0.2, "limited"
    assert given.angular == Vector3(), "it does not roll"


def test_an_obstacle_to_the_left_holds_sideways_motion_back(scene: Scene) -> None:
    scene.measure(0.25)
    given = scene.commanded()
    assert (given.linear.x, given.linear.y) == (0.0, 0.0)
    assert given.linear.z == 0.2


def test_ranges_of_another_sender_are_not_used(scene: Scene) -> None:
    scene.measure(0.25, "console")
    assert scene.commanded().linear.y > 0.2


def test_a_tilted_robot_drives_slowly_and_says_so_once(
    scene: Scene, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            scene.bus.send(IMU, Imu.of(roll=0.2, pitch=0.0), "driver")
            scene.measure(1.5)
            scene.bus.wait(0.01)
    assert scene.commanded().linear.y == 0.2
    said = (
        "tilted by 11 degrees: the map gets no ranges, assistance sees 1 m far and drives 0.2 m/s"
    )
    assert [
        record.getMessage() for record in caplog.records if "tilted" in record.getMessage()
    ] == [said]
    sent = [each for _, name, each in scene.bus.published if name == DIAGNOSTICS.name]
    assert [(each.name, each.message) for each in sent[-1].status] == [("tilt", said)]
    scene.bus.wait(0.1)
    scene.bus.send(DRIVE_STATE, AT_ORIGIN, "driver")
    scene.bus.send(IMU, Imu.of(roll=0.2, pitch=0.0), "driver")
    scene.measure(0.25)
    scene.bus.wait(0.1)
    assert scene.commanded().linear.y == 0.0, "it is as near on a slope"
