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
_MOST: Final = "the kind 'mavlink' has {} only"
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
    for table, described, most in (
        ("bumper", robot.bumpers, 0),
        ("hold", robot.holds, 0),
        ("light", robot.lights, 2),
        ("joint", robot.joints, 1),
    ):
        if len(described) > most:
            fault = _MOST.format(("one", "two")[most - 1]) if most else _NONE
            yield toml.repeated(table, most + 1), "name", fault
