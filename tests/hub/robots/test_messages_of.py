"""A robot's description names the messages that the robot brings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hub.gcm.battery import BATTERY
from hub.gcm.body import RobotBody
from hub.gcm.catalog import BY_NAME
from hub.gcm.environment import ENVIRONMENT
from hub.gcm.flight import ALTITUDE, FLUID_PRESSURE
from hub.gcm.imu import IMU
from hub.gcm.joints import JOINT_STATES
from hub.gcm.providers import PROVIDED_BY
from hub.gcm.ranges import RANGES
from hub.gcm.vision import IMAGE
from hub.ipc.definition import MessageDefinition
from hub.modules.driver import reports
from hub.robots.interfaces import Sensors
from hub.robots.messages_of import described
from hub.robots.registry import body_of, kind_of
from tests.support.bodies import BODIES, robot_of
from tests.support.cases import for_each

REPORTS: dict[MessageDefinition[Any], Callable[[Sensors, float], object]] = {
    BATTERY: reports.battery,
    IMU: reports.imu,
    ALTITUDE: reports.altitude,
    FLUID_PRESSURE: reports.fluid_pressure,
    ENVIRONMENT: reports.environment,
}


def brought(body: RobotBody) -> set[str]:
    names = [each.message for each in body.messages]
    assert len(names) == len(set(names))
    return set(names)


@for_each("name", BODIES)
def test_each_body_brings_what_its_driver_reports_and_its_parts_need(name: str) -> None:
    robot = robot_of(name)
    described = brought(body_of(robot))
    body = kind_of(robot).open_body(robot)
    body.advance(1.5)
    sensors = body.sensors(1.0)
    for definition, report in REPORTS.items():
        assert (definition.name in described) == (report(sensors, 1.0) is not None), definition.name
    assert (RANGES.name in described) == bool(sensors.scans)
    assert (JOINT_STATES.name in described) == bool(sensors.joints)
    assert (IMAGE.name in described) == bool(robot.body.cameras)
    assert described <= set(PROVIDED_BY) <= set(BY_NAME)


def test_a_robot_without_parts_brings_its_state_and_what_its_kind_measures() -> None:
    bare = RobotBody(name="a", kind="b", radius=0.2)
    assert {"GCM_RobotState", "GCM_DriveState", "GCM_Diagnostics"} <= brought(described(bare, ()))
    assert brought(described(bare, (IMU,))) - brought(described(bare, ())) == {IMU.name}
