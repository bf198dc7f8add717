"""The battery of a robot with ROS whose driver counts to 100."""

import pytest

from hub.gcm.battery import BatteryState
from hub.robots.ros.body import RosBody
from tests.support.memory_ros_line import MemoryLine, cdr, ros_robot

NOW = 100.0
ROBOT = """
[ros]
address = "ws://127.0.0.1:8765"
battery = "/battery"
"""


def body_of(tmp_path, monkeypatch, more=""):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    line = MemoryLine()
    line.topic("/battery", "sensor_msgs/msg/BatteryState")
    return line, RosBody(ros_robot(tmp_path, ROBOT + more), line, lambda: NOW)


def said(body):
    """What it says of its battery."""
    return [each.message for each in body.sensors(1e9).diagnostics if each.name == "battery"]


def test_it_is_never_full_by_running_empty(tmp_path, monkeypatch):
    line, body = body_of(tmp_path, monkeypatch)
    shares = []
    for percentage in (3.0, 2.0, 1.0, 0.8, 0.5):
        line.give("/battery", cdr(BatteryState(voltage=10.5, percentage=percentage)), NOW)
        shares.append(body.sensors(1e9).battery_fraction)
    assert shares == pytest.approx([0.03, 0.02, 0.01, 0.008, 0.005])
    assert "battery_percent = true" in said(body)[0]


def test_the_robot_file_may_say_how_it_counts(tmp_path, monkeypatch):
    line, body = body_of(tmp_path, monkeypatch, "battery_percent = true")
    line.give("/battery", cdr(BatteryState(voltage=10.5, percentage=0.8)), NOW)
    assert body.sensors(1e9).battery_fraction == pytest.approx(0.008)
    assert said(body) == []
