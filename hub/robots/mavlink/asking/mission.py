"""Reads the items of a vehicle's mission, its geofence and its rally points; pure.

| state | event | next state |
| --- | --- | --- |
| COUNT | MISSION_COUNT | ITEMS; without items, the next kind |
| ITEMS | the item that was asked for | the next item; after the last, the next kind |
| COUNT, ITEMS | 0.5 s | the same question; after 5 tries, the next kind: this one is missing |
| COUNT | MISSION_ACK other than accepted | the next kind: the vehicle has none |
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterator
from typing import Final

from hub.robots.mavlink.asking.findings import AUTOPILOT
from hub.robots.mavlink.asking.session import OutgoingMessage, addressed
from hub.robots.mavlink.wire.frames import MavlinkFrame
from hub.values import dataclass

MOST_ITEMS: Final = 5000
"""Most items of one kind that are read."""
_AGAIN_S: Final = 0.5
_TRIES: Final = 5
_ACCEPTED: Final = 0
_GLOBAL: Final = frozenset({0, 3, 5, 6, 10, 11})
"""MAV_FRAME with latitude and longitude."""
COMMANDS: Final = {
    16: "waypoint",
    17: "loiter",
    18: "loiter turns",
    19: "loiter time",
    20: "return to launch",
    21: "land",
    22: "takeoff",
    82: "spline waypoint",
    92: "guided",
    93: "delay",
    112: "condition delay",
    115: "condition yaw",
    177: "jump",
    178: "change speed",
    179: "set home",
    181: "set relay",
    183: "set servo",
    203: "trigger camera",
    205: "mount",
    206: "trigger camera by distance",
    5000: "fence return point",
    5001: "fence polygon inside",
    5002: "fence polygon outside",
    5003: "fence circle inside",
    5004: "fence circle outside",
    5100: "rally point",
}
"""By MAV_CMD."""


class MissionKind(enum.IntEnum):
    """MAV_MISSION_TYPE.

    Attributes:
        MISSION: What it does by itself.
        FENCE: Where it may be.
        RALLY: Where it goes in trouble.
    """

    MISSION = 0
    FENCE = 1
    RALLY = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionItem:
    """One item.

    Attributes:
        kind: To which list it belongs.
        number: Its place in the list, from 0.
        command: Its MAV_CMD.
        frame: MAV_FRAME of its place.
        parameters: Four numbers; NaN: the vehicle's own.
        latitude: [degrees]; NaN: it has no such place.
        longitude: [degrees].
        x: In the frame [m]; NaN: it has no such place.
        y: In the frame [m].
        z: Height or depth, by the frame [m].
        current: Whether it is the one that the vehicle carries out.
    """

    kind: MissionKind
    number: int
    command: int
    frame: int
    parameters: tuple[float, float, float, float]
    latitude: float
    longitude: float
    x: float
    y: float
    z: float
    current: bool

    @property
    def name(self) -> str:
        """Its command in words."""
        return COMMANDS.get(self.command, f"command {self.command}")


class MissionReading:
    """Reads all lists; a `VehicleQuestion`.

    Attributes:
        items: What was read, list after list.
        missing: The lists that the vehicle did not send whole, and why.
    """

    def __init__(self, system: int) -> None:
        """Take the number of the vehicle."""
        self._system = system
        self._left = [*MissionKind]
        self.items: list[MissionItem] = []
        self.missing: dict[MissionKind, str] = {}
        self._count = -1
        self._place = 0
        self._tries = _TRIES
        self._next = -math.inf
        self._acknowledge: MissionKind | None = None

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return not self._left and self._acknowledge is None

    def received(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the link."""
        if not self._left or (frame.system, frame.component) != (self._system, AUTOPILOT):
            return
        if frame.fields.get("mission_type") != self._left[0]:
            return
        match frame.name:
            case "MISSION_COUNT" if self._count < 0:
                self._count = min(MOST_ITEMS, frame["count"])
                if frame["count"] > MOST_ITEMS:
                    self.missing[self._left[0]] = f"only the first {MOST_ITEMS} items are read"
                self._proceed(now)
            case "MISSION_ITEM_INT" if self._count >= 0 and frame["seq"] == self._place:
                self.items.append(_item(self._left[0], frame))
                self._place += 1
                self._proceed(now)
            case "MISSION_ACK" if self._count < 0 and frame["type"] != _ACCEPTED:
                self._end(now, f"it has no such list (result {frame['type']})")

    def due(self, now: float) -> Iterator[OutgoingMessage]:
        """The messages to send now."""
        if self._acknowledge is not None:
            kind, self._acknowledge = self._acknowledge, None
            yield addressed("MISSION_ACK", self._system, type=_ACCEPTED, mission_type=int(kind))
        if not self._left or now < self._next:
            return
        if self._tries == 0:
            self._end(now, "it does not answer")
            return
        self._tries -= 1
        self._next = now + _AGAIN_S
        kind = self._left[0]
        if self._count < 0:
            yield addressed("MISSION_REQUEST_LIST", self._system, mission_type=int(kind))
        else:
            yield addressed(
                "MISSION_REQUEST_INT", self._system, seq=self._place, mission_type=int(kind)
            )

    def _proceed(self, now: float) -> None:
        self._tries, self._next = _TRIES, now
        if self._place >= self._count:
            self._acknowledge = self._left[0]
            self._end(now, "")

    def _end(self, now: float, why: str) -> None:
        kind = self._left.pop(0)
        if why:
            self.missing[kind] = why
        self._count, self._place = -1, 0
        self._tries, self._next = _TRIES, now


def _item(kind: MissionKind, frame: MavlinkFrame) -> MissionItem:
    is_global = frame["frame"] in _GLOBAL
    x, y = frame["x"], frame["y"]
    parameters = tuple(frame[f"param{place}"] for place in range(1, 5))
    return MissionItem(
        kind=kind,
        number=frame["seq"],
        command=frame["command"],
        frame=frame["frame"],
        parameters=(parameters[0], parameters[1], parameters[2], parameters[3]),
        latitude=x * 1e-7 if is_global else math.nan,
        longitude=y * 1e-7 if is_global else math.nan,
        x=math.nan if is_global else x * 1e-4,
        y=math.nan if is_global else y * 1e-4,
        z=frame["z"],
        current=bool(frame["current"]),
    )
