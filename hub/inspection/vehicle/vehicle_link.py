"""The link of a command to a vehicle, by an address or by a robot file."""

from __future__ import annotations

from pathlib import Path

from hub.robots.mavlink.asking.session import VehicleSession
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from hub.robots.mavlink.wire.signing_key import read_signing_key


def open_session(address: str, key_file: str) -> VehicleSession:
    """A link to a vehicle.

    Args:
        address: As `vehicle_address` reads it.
        key_file: File of the signing key; empty: unsigned.

    Raises:
        VehicleAddressError: The address is none.
        KeyFileError: The key cannot be used.
    """
    return VehicleSession(address, signer_of(key_file))


def signer_of(key_file: str) -> Signer | None:
    """Signs with the key in a file; None: no file is named.

    Raises:
        KeyFileError: The key cannot be used.
    """
    if not key_file:
        return None
    return Signer(read_signing_key(Path(key_file)), SigningClock(Path(f"{key_file}.stamp")))
