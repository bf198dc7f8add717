"""Other ground stations on the link of a vehicle, by the frames that come; pure.

| frame | sign |
| --- | --- |
| HEARTBEAT of a station that is not this one | it is connected |
| sticks or a velocity for the vehicle | it drives |
| an answer to this station's number, for a command that it did not send | it has this number |

Routers pass such frames on. An autopilot passes on heartbeats between its ports at most. A frame
that comes back as it was sent is an echo of the link. A sign counts for 10 s.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from hub.gcm.diagnostics import Severity
from hub.robots.mavlink.wire.frames import MavlinkFrame

STATION_COMPONENT: Final = 190
"""The number of a mission planner in a ground station."""
_COUNTS_S: Final = 10.0
_COMMANDED_S: Final = 30.0
"""Longest time until the answer to a command, with all tries [s]."""
_STATION_KIND: Final = 6
"""MAV_TYPE_GCS."""
_DRIVES: Final = frozenset(
    {"MANUAL_CONTROL", "RC_CHANNELS_OVERRIDE", "SET_POSITION_TARGET_LOCAL_NED"}
)
_QUESTIONS: Final = frozenset({511, 512, 520})
"""Commands of the tools that ask a vehicle: they change nothing that moves."""
_MOST: Final = 8
"""Most stations that are kept."""
_SEQUENCE: Final = 4
"""Place of the sequence number in a frame of MAVLink 2."""


class OtherStations:
    """The other stations of one vehicle; times are monotonic [s]."""

    def __init__(self, station: int) -> None:
        """Take the number of this station."""
        self._station = station
        self._own: dict[int, bytes] = {}
        self._commands: dict[int, float] = {}
        self._connected: dict[int, float] = {}
        self._driving: dict[int, float] = {}
        self._same_at = self._now = -math.inf

    def sent(self, frame: bytes) -> None:
        """Take a frame that this station sends."""
        self._own[frame[_SEQUENCE]] = frame

    def commanded(self, command: int) -> None:
        """Take a command that leaves from here: its answer is meant."""
        self._commands[command] = self._now

    def received(self, frame: MavlinkFrame, vehicle: int, now: float) -> None:
        """Take a frame of the link.

        Args:
            frame: The frame.
            vehicle: Number of the vehicle.
            now: The time.
        """
        self._now = now
        if frame.raw == self._own.get(frame.sequence):
            return
        if frame.name == "HEARTBEAT" and frame["type"] == _STATION_KIND:
            self._take(self._connected, frame, now)
        elif frame.name in _DRIVES and frame.system != vehicle:
            target = frame.fields.get("target_system", frame.fields.get("target"))
            if target == vehicle:
                self._take(self._driving, frame, now)

    def is_asker(self, answer: MavlinkFrame) -> bool:
        """Whether a COMMAND_ACK is for this station; one of MAVLink 1 has no target."""
        return answer["target_system"] in (0, self._station) and (
            answer["target_component"] in (0, STATION_COMPONENT)
        )

    def answered(self, frame: MavlinkFrame, now: float) -> None:
        """Take a COMMAND_ACK for this station's number; MAVLink 1 says no number."""
        command = frame["command"]
        asked = now - self._commands.get(command, -math.inf) < _COMMANDED_S
        if frame["target_system"] == self._station and not asked and command not in _QUESTIONS:
            self._same_at = now

    def problems(self, now: float) -> Iterator[tuple[Severity, str]]:
        """What an operator should know of them: how bad it is, and a sentence."""
        driving = [each for each, at in self._driving.items() if now - at < _COUNTS_S]
        connected = [each for each, at in self._connected.items() if now - at < _COUNTS_S]
        same = now - self._same_at < _COUNTS_S or self._station in {*driving, *connected}
        if same:
            yield (
                Severity.ERROR,
                f"another ground station has the number {self._station} too: while one of the two "
                "lives, the vehicle's failsafe does not see the loss of the other; end it, or give "
                "it another number",
            )
        for each in sorted({*driving, *connected} - {self._station}):
            if each in driving:
                yield Severity.ERROR, f"ground station {each} drives it too: end one of the two"
            else:
                yield Severity.WARN, f"ground station {each} is connected to it, and may drive it"

    def _take(self, signs: dict[int, float], frame: MavlinkFrame, now: float) -> None:
        if frame.system in signs or len(signs) < _MOST:
            signs[frame.system] = now
        else:
            oldest = min(signs, key=lambda each: signs[each])
            if now - signs[oldest] >= _COUNTS_S:
                del signs[oldest]
                signs[frame.system] = now
