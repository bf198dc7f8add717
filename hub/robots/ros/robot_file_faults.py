"""What is wrong with the robot file of a robot with ROS; pure."""

from __future__ import annotations

from collections.abc import Iterator

from hub import toml_reader as toml
from hub.errors import RosAddressError
from hub.gcm.vehicle import Arming
from hub.robots.body_tables import ROBOTS_OWN
from hub.robots.description import RobotDescription
from hub.robots.ros.address import ADDRESS_FORMS, ros_address


def ros_faults(robot: RobotDescription) -> Iterator[tuple[str, str, str]]:
    """Table, key and a sentence of each."""
    table = robot.ros
    if not table.address:
        yield "[ros]", "address", f"it is missing; give {ADDRESS_FORMS}"
    else:
        try:
            address = ros_address(table.address)
        except RosAddressError as error:
            yield "[ros]", "address", str(error)
        else:
            if table.certificates and not address.takes_certificates:
                yield "[ros]", "certificates", "they are for an address with zenoh+tls:// only"
    if not table.cmd_vel:
        yield "[ros]", "cmd_vel", "it is empty; name the topic of velocities"
    if not table.odom and not table.tf:
        yield "[ros]", "odom", "it is empty, and so is 'tf': nothing says where the robot is"
    if robot.arming is not Arming.NONE:
        yield "[body]", "arming", "the kind 'ros' has no motors that are disarmed"
    for name, described in (("hold", robot.holds), ("bumper", robot.bumpers)):
        if described:
            yield toml.repeated(name, 1), "name", f"the kind 'ros' has no [[{name}]]"
    yield from _without_topic(robot)


def _without_topic(robot: RobotDescription) -> Iterator[tuple[str, str, str]]:
    for count, each in enumerate(robot.ranges, 1):
        if not each.topic:
            yield toml.repeated("range", count), "topic", "it is missing; name that of its ranges"
    for count, camera in enumerate(robot.cameras, 1):
        if camera.source == ROBOTS_OWN and not camera.topic:
            place = "[camera]" if len(robot.cameras) == 1 else toml.repeated("camera", count)
            yield place, "topic", "it is missing; name that of its pictures, or give 'source'"
