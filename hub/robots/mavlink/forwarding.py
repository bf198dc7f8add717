"""Passes the frames of a vehicle on to another ground station, as datagrams; pure.

| direction | frames | action |
| --- | --- | --- |
| from the vehicle | all that Rune knows | send them on, whole, in datagrams of at most 1400 bytes |
| from the station | any | count them, and drop them |
| from the station, where its commands are wanted | of `PASSED`, for this vehicle | send them |

What drives a vehicle, counts as the life of a station, changes streams or a key is not in `PASSED`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hub.robots.mavlink.wire.frames import FrameParser, MavlinkFrame

PASSED: Final = frozenset(
    {
        "COMMAND_INT",
        "COMMAND_LONG",
        "MISSION_ACK",
        "MISSION_CLEAR_ALL",
        "MISSION_COUNT",
        "MISSION_ITEM_INT",
        "MISSION_REQUEST",
        "MISSION_REQUEST_INT",
        "MISSION_REQUEST_LIST",
        "MISSION_SET_CURRENT",
        "PARAM_REQUEST_LIST",
        "PARAM_REQUEST_READ",
        "PARAM_SET",
        "SET_MODE",
    }
)
"""Messages of another ground station that may reach the vehicle."""
_INTERVAL: Final = 511
"""MAV_CMD_SET_MESSAGE_INTERVAL: the streams of this link are the hub's."""
NOT_PASSED: Final = frozenset({_INTERVAL, 181, 182, 183, 184, 187, 209, 310})
"""It, and commands that drive outputs directly: relays, servos, actuators, motor tests."""
_MOST_FRAMES: Final = 64
"""Most frames that are passed on at once."""
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

    def came_back(self, datagram: bytes) -> bytes:
        """Count the frames in a datagram of the station; returns those that may be passed on."""
        self.returned += len(self._station.datagram(datagram))
        return b"".join(frame.raw for frame in passable(datagram))


def passable(datagram: bytes, system: int = 0) -> Iterator[MavlinkFrame]:
    """The frames of another ground station that may reach a vehicle.

    Args:
        datagram: Bytes of the station.
        system: Number of the vehicle; 0: any.
    """
    for frame in FrameParser().datagram(datagram)[:_MOST_FRAMES]:
        target = frame.fields.get("target_system")
        if frame.name not in PASSED or (system and target not in (0, system)):
            continue
        if frame.fields.get("command") not in NOT_PASSED:
            yield frame
