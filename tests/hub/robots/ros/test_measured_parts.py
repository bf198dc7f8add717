"""What a robot with ROS says of its parts, on a line in memory."""

import dataclasses
import math

import numpy as np
import pytest

from hub.gcm.battery import BATTERY, BatteryState, PowerSupplyStatus
from hub.gcm.geometry import Quaternion, Vector3
from hub.gcm.imu import IMU, Acceleration, Imu
from hub.modules.driver import reports
from hub.robots.ros.line import RosService
from tests.support.memory_ros_body import RobotInMemory
from tests.support.memory_ros_line import cdr


@pytest.fixture
def robot(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return RobotInMemory(tmp_path)


def test_what_the_bridge_does_not_serve_is_a_problem_in_its_words(robot):
    refusals = {"/cmd_vel": "no type Twist", "/scan": "no library", "/e_stop": "it hangs"}
    robot.line.state = dataclasses.replace(robot.line.state, refusals=refusals)
    driving = (
        "the robot cannot be driven: the robot's bridge does not serve /cmd_vel: no type Twist"
    )
    assert robot.problem("/cmd_vel") == [driving]
    assert "no library" in robot.problem("/scan")[0]
    robot.line.services["/e_stop"] = RosService(name="/e_stop", type="std_srvs/srv/Trigger")
    robot.body.stop()
    robot.line.called[-1][2](None, "no answer in 1 s")
    assert robot.problem("/e_stop") == ["the service /e_stop failed: it hangs"]


def test_all_that_its_battery_and_imu_say_reaches_the_bus(robot):
    """And so the doors, which send these messages on as they are."""
    cells = np.array([4.0, 4.25], np.float32)
    battery = BatteryState(
        voltage=12.25,
        temperature=31.0,
        current=-1.5,
        charge=2.5,
        capacity=5.0,
        design_capacity=6.0,
        percentage=0.5,
        power_supply_status=PowerSupplyStatus.DISCHARGING,
        power_supply_health=1,
        power_supply_technology=2,
        cell_voltage=cells,
        cell_temperature=7.0 * cells,
        location="rear",
        serial_number="B-7",
    )
    imu = Imu(
        orientation=Quaternion.of(0.1, -0.2, 1.3),
        orientation_covariance=0.01 * np.arange(9.0),
        angular_velocity=Vector3(x=0.1, y=0.2, z=0.3),
        angular_velocity_covariance=0.02 * np.arange(9.0),
        linear_acceleration=Acceleration(z=9.81),
        linear_acceleration_covariance=0.03 * np.arange(9.0),
    )
    robot.line.topic("/battery", "sensor_msgs/msg/BatteryState")
    robot.line.topic("/imu", "sensor_msgs/msg/Imu")
    robot.line.give("/battery", cdr(battery), robot.now)
    robot.line.give("/imu", cdr(imu), robot.now)
    for definition, report, sent in (
        (BATTERY, reports.battery, battery),
        (IMU, reports.imu, imu),
    ):
        made = report(robot.sensors, 1e9)
        assert made.header.stamp.seconds == 1e9
        came = definition.decode(b"".join(definition.encode(made)))
        for part in dataclasses.fields(came):
            if part.name != "header":
                assert plain(came, part) == pytest.approx(plain(sent, part)), part.name

    robot.now += 70.0
    robot.body.advance(0.0)
    assert reports.battery(robot.sensors, 1e9) is None
    assert reports.imu(robot.sensors, 1e9) is None


def plain(message, part):
    value = getattr(message, part.name)
    return dataclasses.astuple(value) if dataclasses.is_dataclass(value) else value


def test_what_is_no_battery_says_nothing_of_its_cells(robot):
    robot.line.topic("/battery", "sensor_msgs/msg/BatteryState")
    wild = np.array([math.inf, -1e9, math.nan, 3.5], np.float32)
    sent = BatteryState(voltage=12.0, cell_voltage=np.tile(wild, 200), location="a\x1b[2Jb" * 50)
    robot.line.give("/battery", cdr(sent), robot.now)
    made = reports.battery(robot.sensors, 1e9)
    assert len(made.cell_voltage) == 256
    assert np.isnan(made.cell_voltage[:3]).all()
    assert made.cell_voltage[3] == 3.5
    assert "\x1b" not in made.location
    BATTERY.encode(made)
