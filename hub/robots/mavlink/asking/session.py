"""A link to a vehicle for as long as questions to it take.

A session sends no heartbeat: a vehicle that receives one counts on more, and acts when they end.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from typing import Any, Final, Protocol, TypeAlias

from hub.robots.mavlink.asking.silence import silence
from hub.robots.mavlink.link.address import VehicleAddress, vehicle_address
from hub.robots.mavlink.link.byte_link import ByteLink
from hub.robots.mavlink.link.opening import link_to
from hub.robots.mavlink.profiles.profile import STATION
from hub.robots.mavlink.vehicle.other_stations import STATION_COMPONENT
from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from hub.robots.mavlink.wire.signing import Signer
from hub.robots.refusals import REFUSED_S

_BETWEEN_S: Final = 0.002
"""Time between two looks at a link where nothing came [s]."""

OutgoingMessage: TypeAlias = tuple[str, Mapping[str, Any]]
"""Name and fields of a message to send."""


class VehicleQuestion(Protocol):
    """A question to a vehicle; pure. Times are monotonic [s]."""

    @property
    def done(self) -> bool:
        """Whether it has ended."""

    def received(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the link."""

    def due(self, now: float) -> Iterable[OutgoingMessage]:
        """The messages to send now."""


class VehicleSession:
    """A link to a vehicle; used by one thread.

    Attributes:
        address: The vehicle's.
        frames: Frames that came.
        signs: Whether it signs what it sends.
    """

    def __init__(
        self,
        address: str,
        signer: Signer | None = None,
        station: int = STATION,
    ) -> None:
        """Take an address; the first question opens the link.

        Args:
            address: As `vehicle_address` reads it.
            signer: Signs what is sent; None: it has no signatures.
            station: Number of this ground station.

        Raises:
            VehicleAddressError: It is no address.
        """
        self.address: VehicleAddress = vehicle_address(address)
        self._link: ByteLink = link_to(self.address)
        self._parser = FrameParser(signer)
        self._packer = FramePacker(station, STATION_COMPONENT, signer)
        self.frames, self.signs = 0, signer is not None

    def ask(self, question: VehicleQuestion, seconds: float) -> bool:
        """Carry out a question; returns whether it has ended.

        A host that was never heard, and refuses connections, is asked for `REFUSED_S` only.

        Args:
            question: The question.
            seconds: Longest time for it [s].
        """
        until = time.monotonic() + seconds
        find = self._parser.datagram if self._link.datagrams else self._parser.feed
        while not question.done:
            now = time.monotonic()
            if now > until or self._refuses(now):
                return False
            pieces = self._link.read(now)
            for piece in pieces:
                for frame in find(piece):
                    self.frames += 1
                    question.received(frame, now)
            for name, fields in question.due(now):
                self._link.write(self._packer.pack(name, **fields))
            if not pieces:
                time.sleep(_BETWEEN_S)
        return True

    def _refuses(self, now: float) -> bool:
        link = self._link.state
        return not link.received and now - link.refused_since >= REFUSED_S

    def silence(self) -> str:
        """Why no vehicle was found, and what to try, in one sentence."""
        return silence(self.address, self._link.state, self.frames, self._parser.refused)

    def close(self) -> None:
        """Close the link."""
        self._link.close()


def addressed(name: str, system: int, component: int = 1, /, **fields: object) -> OutgoingMessage:
    """A message to a component of a vehicle; without one, to its autopilot."""
    names = {field.name for field in BY_NAME[name].fields}
    if "target_system" in names:
        fields |= {"target_system": system, "target_component": component}
    return name, fields
