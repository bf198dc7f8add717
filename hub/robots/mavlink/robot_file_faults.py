"""What is wrong with the robot file of a vehicle with an autopilot; pure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hub import toml_reader as toml
from hub.errors import VehicleAddressError
from hub.gcm.vehicle import Arming
from hub.robots.description import RobotDescription
from hub.robots.mavlink.link.address import ADDRESS_FORMS, vehicle_address

_ARMING: Final = 'an autopilot is armed by an operator, never at a start: write arming = "disarmed"'
_NONE: Final = "the kind 'mavlink' has none"


def autopilot_faults(robot: RobotDescription) -> Iterator[tuple[str, str, str]]:
    """Table, key and a sentence of each."""
    if not robot.vehicle_address:
        yield "[mavlink]", "address", f"it is missing; give {ADDRESS_FORMS}"
    else:
        try:
            vehicle_address(robot.vehicle_address)
        except VehicleAddressError as error:
            yield "[mavlink]", "address", str(error)
    if robot.arming is not Arming.DISARMED:
        yield "[body]", "arming", _ARMING
    parts = {"range": robot.ranges, "bumper": robot.bumpers, "hold": robot.holds}
    parts |= {"light": robot.lights, "joint": robot.joints}
    for table, described in parts.items():
        if described:
            yield toml.repeated(table, 1), "name", _NONE
