"""The link of a command to a vehicle, by an address or by a robot file."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TypeVar

from hub.errors import HubError, RobotFileError, VehicleSilentError
from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotState
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.hub_sockets import NAMED
from hub.inspection.message_commands import connect
from hub.ipc.definition import MessageDefinition
from hub.robots.description import RobotDescription
from hub.robots.mavlink.asking.findings import VehicleFinder
from hub.robots.mavlink.asking.search import find_vehicle
from hub.robots.mavlink.asking.session import VehicleSession
from hub.robots.mavlink.link.vehicle_claim import VehicleClaim
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from hub.robots.mavlink.wire.signing_key import read_signing_key
from hub.robots.robot_file import find_robot_file, read_description
from hub.values import dataclass

_Value = TypeVar("_Value")

_ANSWER_S = 1.0
_COMMAND_LINK = 1
"""Number of a command's link in signatures: the stamps of a hub are those of link 0.

The vehicle keeps the last stamp of each link. With one number, it would ignore the hub for as long
as the stamps of the command are ahead.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class VehiclePlace:
    """Where a vehicle is, and how a command talks to it.

    Attributes:
        address: Its address.
        system: Its number; 0: the only one.
        station: Number of the hub as a ground station.
        key_file: File of the signing key; empty: unsigned.
        name: Name of the robot.
        hub: Endpoint of the robot's hub; empty: no robot file names it.
    """

    address: str
    system: int
    station: int
    key_file: str
    name: str
    hub: str = ""


def place_of(options: argparse.Namespace) -> VehiclePlace:
    """The vehicle that the options name by an address or a robot file.

    Raises:
        RobotFileError: The robot file has mistakes, or none of an autopilot.
    """
    where = str(options.vehicle)
    if not where.endswith(".toml") or "://" in where:
        return VehiclePlace(
            address=where,
            system=options.system,
            station=options.station,
            key_file=str(options.key or ""),
            name="vehicle",
        )
    robot, problems = read_description(find_robot_file(where))
    if not problems and robot.kind != "mavlink":
        problems.append(f"kind {robot.kind!r} has no autopilot; give a robot file of kind mavlink")
    if problems:
        raise RobotFileError(where, problems)
    place = place_in(robot)
    system, key_file = options.system or place.system, str(options.key or place.key_file)
    return dataclasses.replace(place, system=system, key_file=key_file)


def place_in(robot: RobotDescription) -> VehiclePlace:
    """The vehicle in a robot file."""
    return VehiclePlace(
        address=robot.vehicle_address,
        system=robot.vehicle_system,
        station=robot.vehicle_station,
        key_file=robot.signing_key,
        name=robot.name,
        hub=f"{NAMED}{robot.name}",
    )


def hub_with_autopilot(place: VehiclePlace) -> str:
    """The endpoint of the robot's hub if it runs here and has an autopilot; empty: it does not."""
    if not place.hub:
        return ""
    try:
        body = _newest(place.hub, ROBOT_DESCRIPTION)
    except HubError:
        return ""
    return "" if body is not None and body.kind != "mavlink" else place.hub


def autopilot_at(endpoint: str) -> AutopilotState | None:
    """What a hub reports of its autopilot; None: nothing soon enough."""
    try:
        return _newest(endpoint, AUTOPILOT_STATE)
    except HubError:
        return None


def _newest(endpoint: str, definition: MessageDefinition[_Value]) -> _Value | None:
    """The newest message of a hub; None: none came.

    Raises:
        HubError: No hub is there.
    """
    values: list[_Value] = []
    with contextlib.closing(connect(endpoint, "vehicle", None)) as client:
        client.subscribe(definition, lambda value, _how: values.append(value))
        until = time.monotonic() + _ANSWER_S
        while not values and time.monotonic() < until:
            client.listen(0.05)
    return values[-1] if values else None


@contextlib.contextmanager
def claimed(session: VehicleSession, system: int) -> Iterator[str]:
    """Have the vehicle alone on this machine, to change it; yields who has it else, or nothing."""
    with contextlib.closing(VehicleClaim(session.address, system)) as claim:
        yield "" if claim.take() else claim.owner()


def find_at(session: VehicleSession, place: VehiclePlace, seconds: float) -> VehicleFinder:
    """The vehicle at a place.

    Raises:
        VehicleSilentError: There is none, or there are several; where its hub has the link, it
            says so.
    """
    try:
        return find_vehicle(session, place.system, seconds, reads=False)
    except VehicleSilentError as fault:
        hub = hub_with_autopilot(place)
        if not hub:
            raise
        text = f"{fault}; its hub runs at {hub} and has the link"
        raise VehicleSilentError(text) from fault


def open_session(address: str, key_file: str, station: int) -> VehicleSession:
    """A link to a vehicle.

    Args:
        address: As `vehicle_address` reads it.
        key_file: File of the signing key; empty: unsigned.
        station: Number of this ground station.

    Raises:
        VehicleAddressError: The address is none.
        KeyFileError: The key cannot be used.
    """
    return VehicleSession(address, signer_of(key_file), station)


def signer_of(key_file: str) -> Signer | None:
    """Signs with the key in a file; None: no file is named.

    Raises:
        KeyFileError: The key cannot be used.
    """
    if not key_file:
        return None
    clock = SigningClock(Path(f"{key_file}.stamp"))
    return Signer(read_signing_key(Path(key_file)), clock, _COMMAND_LINK)
