"""Sends the messages of a ground station to one vehicle; pure."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

from hub.robots.mavlink.vehicle.identity import AUTOPILOT
from hub.robots.mavlink.vehicle.other_stations import OtherStations
from hub.robots.mavlink.vehicle.requests import VehicleRequest
from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import FramePacker

_HEARTBEAT_S: Final = 1.0
_STATION: Final = {"type": 6, "autopilot": 8, "system_status": 4, "mavlink_version": 3}
"""The heartbeat of a ground station: MAV_TYPE_GCS, no autopilot, active."""
_TO_AUTOPILOT: Final = frozenset(
    name
    for name, form in BY_NAME.items()
    if name != "TIMESYNC" and "target_system" in {field.name for field in form.fields}
)
_TO_SYSTEM: Final = frozenset(
    name for name, form in BY_NAME.items() if "target" in {field.name for field in form.fields}
)


class VehicleSender:
    """Sends to one vehicle.

    Attributes:
        system: Number of the vehicle; 0: not known yet.
    """

    def __init__(
        self, send: Callable[[bytes], None], packer: FramePacker, stations: OtherStations
    ) -> None:
        """Take the link.

        Args:
            send: Sends a frame at once, or drops it.
            packer: Packs the frames of this station.
            stations: Learns of each frame and each command that leaves.
        """
        self._send, self._packer, self._stations = send, packer, stations
        self._heartbeat_at = -math.inf
        self.system = 0

    def message(self, name: str, /, **fields: Any) -> None:  # noqa: ANN401 - as the message has them
        """Send a message; one with a target goes to the vehicle's autopilot."""
        if name in _TO_AUTOPILOT:
            fields |= {"target_system": self.system, "target_component": AUTOPILOT}
        elif name in _TO_SYSTEM:
            fields["target"] = self.system
        frame = self._packer.pack(name, **fields)
        if name == "COMMAND_LONG":
            self._stations.commanded(fields["command"])
        self._stations.sent(frame)
        self._send(frame)

    def heartbeat(self, now: float) -> None:
        """Send the heartbeat of this station, once per second [s, monotonic]."""
        if now - self._heartbeat_at >= _HEARTBEAT_S:
            self._heartbeat_at = now
            self.message("HEARTBEAT", **_STATION)

    def command(self, request: VehicleRequest) -> None:
        """Send a command."""
        values = {f"param{place}": value for place, value in enumerate(request.parameters, 1)}
        self.message("COMMAND_LONG", command=request.command, **values)
