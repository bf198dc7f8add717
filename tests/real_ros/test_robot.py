"""Real nodes of ROS 2 Jazzy: found, read and driven by a hub, over a bridge that is a node too."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hub.command_line import ExitCode
from hub.gcm.battery import BatteryState, PowerSupplyStatus
from hub.gcm.geometry import Twist
from hub.gcm.navigation import DRIVE_STATE, ROBOT_STATE
from hub.modules.driver import reports
from hub.robots.interfaces import Sensors
from hub.robots.robot_file import read_description
from hub.robots.ros.address import ros_address
from hub.robots.ros.body import RosBody
from hub.robots.ros.opening import line_to
from tests.real_ros.conftest import Start
from tests.real_ros.jazzy import JazzyProcess
from tests.support.command_line import rune_hub
from tests.support.running_command import RunningCommand
from tests.support.waiting import until
from tests.system.autopilot_site import Operator
from tests.system.harness import Observer

STOP_S = 0.5
"""Longest time of the last velocity after silence; 0.3 s, and what a busy machine needs [s]."""


def bridge_of(start: Start, *lacks: str) -> tuple[JazzyProcess, str]:
    """A robot, and the address of a bridge to it."""
    robot, bridge = start("jazzy_robot"), start("jazzy_bridge", *lacks)
    until(lambda: bridge.lines and robot.lines, 40.0, lambda: robot.words + bridge.words)
    return robot, f"ws://127.0.0.1:{bridge.lines[0]['port']}"


def adopted(address: str, path: Path) -> dict[str, Any]:
    """What adopting the robot says; its robot file is in `path`."""
    done = rune_hub("adopt", address, "--json", "-o", str(path), "--seconds", "20")
    assert done.returncode == ExitCode.OK, done.stderr
    facts: dict[str, Any] = json.loads(done.stdout)
    path.write_text(_wheels_only(path.read_text()))
    return facts


def test_a_robot_of_real_nodes_is_adopted_read_and_driven(
    start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    robot, address = bridge_of(start)
    facts = adopted(address, tmp_path / "robot.toml")
    assert (facts["cmd_vel"], facts["stops_after_s"]) == ("/cmd_vel", 0.5)
    assert {"/odom", "/scan", "/sonar", "/imu/data", "/battery_state"} < {*facts["topics"]}
    assert "/camera/image_raw" in facts["topics"]
    assert not facts["unsafe"]
    file, problems = read_description(tmp_path / "robot.toml")
    assert not problems
    with closing(RosBody(file, line_to(ros_address(address)))) as body:
        wanted = Twist()

        def advance() -> None:
            body.command(wanted)
            body.advance(0.01)

        def sensors() -> Sensors:
            return body.sensors(time.time())

        def wait(condition: Callable[[], object]) -> None:
            until(condition, 20.0, lambda: f"{sensors().diagnostics}", meanwhile=advance)

        wait(lambda: sensors().known and sensors().battery and sensors().imu)
        wait(lambda: all(np.isfinite(each.ranges).all() for each in sensors().scans))
        _check_parts(sensors())
        wanted = Twist.planar(0.3, -0.2)
        wait(lambda: _takes(robot, 0.3, -0.2))
        assert robot.lines[-1]["stamp"] == [0, 0]
        wait(lambda: sensors().velocity.linear.x == pytest.approx(0.3))
        assert not sensors().diagnostics
        wanted = Twist()
        wait(lambda: _takes(robot, 0.0, 0.0))
        wait(lambda: sensors().velocity.neutral)
        assert math.hypot(sensors().x, sensors().y) > 0.0


def _takes(robot: JazzyProcess, ahead: float, turn: float) -> bool:
    """Whether this is the newest velocity that the base took."""
    newest = robot.lines[-1]
    return (newest.get("x"), newest.get("z")) == (pytest.approx(ahead), pytest.approx(turn))


def _check_parts(sensors: Sensors) -> None:
    """All that its sensors say came through."""
    battery, imu = reports.battery(sensors, 1e9), reports.imu(sensors, 1e9)
    assert battery is not None
    assert imu is not None
    _check_battery(battery)
    assert imu.roll_pitch_yaw == pytest.approx((0.0, 0.0, 0.3), abs=1e-6)
    assert imu.linear_acceleration_covariance[0] == 0.02
    scan, sonar = sensors.scans
    assert scan.ranges.tolist() == pytest.approx([2.0 + n / 10 for n in range(36)])
    assert sonar.ranges.tolist() == pytest.approx([1.25])


@pytest.mark.soak
def test_a_hub_stops_real_nodes_when_its_operator_is_silent(start: Start, tmp_path: Path) -> None:
    robot, address = bridge_of(start)
    path = tmp_path / "robot.toml"
    adopted(address, path)
    with ExitStack() as stack:
        command = RunningCommand("run", str(path), "--as", f"jazzy-{os.getpid()}")
        hub = stack.enter_context(closing(command))
        observer = Observer(hub.ready["hub"], ROBOT_STATE, DRIVE_STATE)
        stack.enter_context(closing(observer))
        operator = Operator(hub.ready["hub"], "operator")
        stack.callback(operator.client.close)
        operator.takes_control()
        _drives(robot, observer, operator)


def _wheels_only(text: str) -> str:
    """A robot file with the modules that drive only."""
    head, *modules = text.split("[modules.")
    kept = [each for each in modules if each.startswith(("driver", "navigation"))]
    return "[modules.".join([head.split("[[camera]]")[0], *kept])


def _check_battery(battery: BatteryState) -> None:
    """All that the driver of the battery said came through."""
    assert (battery.voltage, battery.current, battery.charge) == (12.25, -1.5, 2.5)
    assert (battery.temperature, battery.capacity, battery.design_capacity) == (31.0, 5.0, 6.0)
    assert battery.percentage == 0.5
    assert battery.power_supply_status is PowerSupplyStatus.DISCHARGING
    assert (battery.power_supply_health, battery.power_supply_technology) == (1, 2)
    assert battery.cell_voltage.tolist() == [4.0, 4.25, 4.0]
    assert battery.cell_temperature.tolist() == [30.0, 31.0, 32.0]
    assert (battery.location, battery.serial_number) == ("rear", "B-7")


def _drives(robot: JazzyProcess, observer: Observer, operator: Operator) -> None:
    """The base follows a stick, and its silence; what it measures comes back."""

    def wait(condition: Any, why: str) -> None:
        def meanwhile() -> None:
            operator.client.listen(0.01)
            observer.client.listen(0.0)

        until(condition, 20.0, lambda: f"{why}: {list(robot.lines)[-3:]}", meanwhile=meanwhile)

    def newest() -> dict[str, Any]:
        return robot.lines[-1]

    operator.twist = Twist()
    wait(lambda: operator.sent > 5, "nothing is sent")
    operator.twist = Twist.planar(0.3, -0.2)
    wait(
        lambda: (
            newest().get("x") == pytest.approx(0.3) and newest().get("z") == pytest.approx(-0.2)
        ),
        "the base gets no velocity",
    )
    assert newest()["stamp"] == [0, 0]
    states = observer.seen[DRIVE_STATE.name]
    wait(
        lambda: states[-1][1].odometry.twist.twist.linear.x == pytest.approx(0.3),
        "its odometry does not come back",
    )
    operator.twist = None
    silent = time.monotonic()
    wait(lambda: newest()["x"] == 0.0 and newest()["z"] == 0.0, "the base drives on")
    moved = [line["t"] for line in robot.lines if line.get("x") or line.get("z")]
    assert moved[-1] - silent < STOP_S
    wait(lambda: states[-1][1].odometry.twist.twist.neutral, "its odometry says no stop")
    place = states[-1][1].odometry.pose.pose.position
    assert math.hypot(place.x, place.y) > 0.02


def test_a_bridge_without_the_package_of_velocities_is_refused_with_the_remedy(
    start: Start,
) -> None:
    robot, address = bridge_of(start, "geometry_msgs")
    done = rune_hub("adopt", address, "--seconds", "20")
    assert done.returncode == ExitCode.FAULT
    assert "cannot publish /cmd_vel: install geometry_msgs where the bridge runs" in done.stderr
    assert all("t" not in line for line in robot.lines), "nothing is sent that moves it"
