"""Which sender on a link is the vehicle; pure."""

from __future__ import annotations

from typing import Final

from hub.robots.mavlink.kinds import is_vehicle
from hub.robots.mavlink.profiles.profile import VehicleProfile
from hub.robots.mavlink.profiles.table import profile_of
from hub.robots.mavlink.wire.frames import MavlinkFrame

AUTOPILOT: Final = 1
"""The component that is the autopilot."""
_MOST_OTHERS: Final = 64


class VehicleIdentity:
    """The number and the kind of the vehicle.

    Attributes:
        system: Its number; 0: not known yet.
        profile: The rules of its kind; None: it is not known.
        others: Numbers of other vehicles on the link.
        signed: Whether its frames have signatures.
    """

    def __init__(self, wanted: int = 0) -> None:
        """Wait for a vehicle with a number; 0: for the first one that is heard."""
        self._wanted = wanted
        self._kind = (-1, -1)
        self.system = 0
        self.profile: VehicleProfile | None = None
        self.others: set[int] = set()
        self.signed = False

    def heartbeat(self, frame: MavlinkFrame, *, silent: bool) -> bool:
        """Take a heartbeat; whether it is the vehicle's.

        Args:
            frame: The heartbeat.
            silent: Whether the vehicle is silent: then its number may get a new kind.
        """
        kind = (frame["autopilot"], frame["type"])
        if not is_vehicle(frame.component, *kind):
            return False
        if not frame.system:
            return False  # 0 means all vehicles
        if frame.system != (self.system or self._wanted or frame.system):
            if len(self.others) < _MOST_OTHERS:
                self.others.add(frame.system)
            return False
        if self.system and kind != self._kind and not silent:
            return False
        self.system, self._kind = frame.system, kind
        self.signed = frame.claims_signature
        self.profile = profile_of(*kind)
        return True

    def is_twin(self, frame: MavlinkFrame) -> bool:
        """Whether a heartbeat is of a vehicle of another kind with the same number."""
        kind = (frame["autopilot"], frame["type"])
        known = is_vehicle(frame.component, *kind)
        return known and frame.system == self.system != 0 and kind != self._kind

    def sent(self, frame: MavlinkFrame) -> bool:
        """Whether a frame is of the vehicle's autopilot."""
        return frame.system == self.system != 0 and frame.component == AUTOPILOT
