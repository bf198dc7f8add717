"""Passes the frames of a vehicle on to another ground station, as datagrams; pure.

| direction | frames | action |
| --- | --- | --- |
| from the vehicle | all that Rune knows | send them on, whole, in datagrams of at most 1400 bytes |
| from the station | any | count them, and drop them |
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hub.robots.mavlink.wire.frames import FrameParser

_DATAGRAM: Final = 1400
"""Longest datagram, which no usual network has to divide [bytes]."""


class FrameForwarder:
    """Counts and packs the frames of one vehicle's link.

    Attributes:
        passed: Frames for the station.
        returned: Frames of the station, which are dropped.
    """

    def __init__(self) -> None:
        self.passed = self.returned = 0
        self._vehicle, self._station = FrameParser(), FrameParser()

    def datagrams(self, data: bytes) -> Iterator[bytes]:
        """The datagrams for the station, from bytes of the vehicle's link."""
        held = b""
        for frame in self._vehicle.feed(data):
            self.passed += 1
            if len(held) + len(frame.raw) > _DATAGRAM:
                yield held
                held = b""
            held += frame.raw
        if held:
            yield held

    def came_back(self, datagram: bytes) -> None:
        """Count the frames in a datagram of the station."""
        self.returned += len(self._station.datagram(datagram))
