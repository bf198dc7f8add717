"""The claim of one process on a vehicle with an autopilot."""

from __future__ import annotations

import os

from hub.robots.machine_claim import MachineClaim, local_place
from hub.robots.mavlink.link.address import VehicleAddress, VehicleLinkKind


class VehicleClaim(MachineClaim):
    """The claim on one vehicle."""

    def __init__(self, address: VehicleAddress, system: int) -> None:
        """Take the vehicle's address and its number; nothing is claimed yet."""
        serial = address.kind is VehicleLinkKind.SERIAL
        place = os.path.realpath(address.host) if serial else f"{address.host}:{address.port}"
        super().__init__("vehicle", f"{system} {address.kind.value} {local_place(place)}")
