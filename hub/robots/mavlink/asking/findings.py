"""Finds the vehicles on a link, and what one of them is; pure.

| state | event | next state |
| --- | --- | --- |
| LISTENING | 1.2 s since the first heartbeat of an autopilot | ASKING |
| ASKING | all was answered, or 4 s have passed | DONE |
| ASKING | there are several vehicles, and none was named | DONE |

ASKING reads its version, the parameters that count, and the streams of its cameras.
"""

from __future__ import annotations

import enum
import math
import re
from collections.abc import Iterator
from typing import Final

from hub.plain_text import plain
from hub.robots.mavlink.asking.session import OutgoingMessage, addressed
from hub.robots.mavlink.kinds import is_vehicle
from hub.robots.mavlink.profiles.profile import OLDER_NAMES, VehicleProfile
from hub.robots.mavlink.profiles.table import profile_of
from hub.robots.mavlink.vehicle.parameter_reads import ParameterReads, parameter_value
from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import MavlinkFrame
from hub.values import dataclass

AUTOPILOT: Final = 1
"""The component that is the autopilot."""
ARMED: Final = 128
"""MAV_MODE_FLAG_SAFETY_ARMED."""
STATION_KIND: Final = 6
"""MAV_TYPE_GCS."""
_CAMERA_KIND: Final = 30
_CAMERAS: Final = range(100, 106)
"""MAV_COMP_ID_CAMERA and those after it."""
_REQUEST: Final = 512
"""MAV_CMD_REQUEST_MESSAGE."""
_LISTENING_S: Final = 1.2
_ASKING_S: Final = 4.0
_AGAIN_S: Final = 0.5
"""Time between two requests of the same [s]."""
_REQUESTS: Final = 3
_MOST_COMPONENTS: Final = 64
_MOST_STREAMS: Final = 16
_RTP: Final = 1
_MPEG_TS: Final = 3
"""VIDEO_STREAM_TYPE of datagrams: their address is a port, with or without a host before it."""
_H265: Final = 2
"""VIDEO_STREAM_ENCODING."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundComponent:
    """A sender of heartbeats.

    Attributes:
        system: Number of its vehicle or station.
        component: Its number in it.
        kind: Its MAV_TYPE.
        autopilot: Its MAV_AUTOPILOT.
        armed: Whether its motors may move.
        signed: Whether its heartbeats have signatures.
    """

    system: int
    component: int
    kind: int
    autopilot: int
    armed: bool
    signed: bool

    @property
    def is_vehicle(self) -> bool:
        """Whether it is the autopilot of a vehicle."""
        return is_vehicle(self.component, self.autopilot, self.kind)

    def same_kind(self, other: FoundComponent) -> bool:
        """Whether another one has this type and this autopilot."""
        return (self.autopilot, self.kind) == (other.autopilot, other.kind)


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundStream:
    """A video stream.

    Attributes:
        component: The camera.
        name: Its name.
        address: Where pictures come from, as the camera says; of datagrams, where this machine
            waits for them.
    """

    component: int
    name: str
    address: str


class _State(enum.Enum):
    LISTENING = enum.auto()
    ASKING = enum.auto()
    DONE = enum.auto()


class VehicleFinder:
    """Finds vehicles; a `VehicleQuestion`.

    Attributes:
        components: All senders of heartbeats.
        vehicle: The vehicle that was asked; None: there is none, or there are several.
        firmware: Its version, a byte each: major, minor, patch, kind; 0: not known.
        parameters: Those of its parameters that were read.
        streams: The video streams of its cameras.
        answers: Whether it answers.
        receiver: Whether it has a radio receiver; None: it does not say.
    """

    def __init__(self, system: int = 0, *, reads: bool = True, extra: tuple[str, ...] = ()) -> None:
        """Take what to look for.

        Args:
            system: Number of the vehicle; 0: the only one.
            reads: Whether to read its parameters and streams.
            extra: Parameters to read besides those of its kind.
        """
        self._system, self._reads_more, self._extra = system, reads, extra
        self.components: dict[tuple[int, int], FoundComponent] = {}
        self.vehicle: FoundComponent | None = None
        self.firmware = 0
        self.streams: dict[tuple[int, int], FoundStream] = {}
        self.answers = False
        self.receiver: bool | None = None
        self._reads = ParameterReads()
        self._state = _State.LISTENING
        self._until = math.inf
        self._requests = 0
        self._asked_at = self._read_at = -math.inf

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters that were read, by name."""
        return self._reads.values

    @property
    def profile(self) -> VehicleProfile | None:
        """The rules of the vehicle's kind; None: it is not known."""
        if self.vehicle is None:
            return None
        return profile_of(self.vehicle.autopilot, self.vehicle.kind)

    @property
    def vehicles(self) -> list[FoundComponent]:
        """All vehicles, in the order of their numbers."""
        return sorted(
            (each for each in self.components.values() if each.is_vehicle),
            key=lambda each: each.system,
        )

    @property
    def wanted(self) -> tuple[str, ...]:
        """Names of the parameters that are read."""
        profile = self.profile
        own = profile.parameters if profile else ()
        return tuple(dict.fromkeys((*own, *self._extra)))

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self._state is _State.DONE

    @property
    def begun(self) -> bool:
        """Whether a vehicle was heard."""
        return self._until < math.inf

    def received(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the link."""
        if frame.name == "HEARTBEAT":
            self._heartbeat(frame, now)
        elif self.vehicle is not None and frame.system == self.vehicle.system:
            self._answer(frame)

    def due(self, now: float) -> Iterator[OutgoingMessage]:
        """The messages to send now."""
        if now > self._until:
            self._proceed(now)
        if self._state is _State.LISTENING and now - self._asked_at >= _AGAIN_S:
            self._asked_at = now
            yield "TIMESYNC", {"ts1": int(now * 1e9)}  # a UDP vehicle waits for a first datagram
        if self._state is _State.ASKING and self.vehicle is not None:
            yield from self._questions(self.vehicle.system, now)
            if self._is_answered(now):
                self._state = _State.DONE

    def _heartbeat(self, frame: MavlinkFrame, now: float) -> None:
        sender = frame.system, frame.component
        if sender not in self.components and len(self.components) >= _MOST_COMPONENTS:
            return
        found = FoundComponent(
            system=frame.system,
            component=frame.component,
            kind=frame["type"],
            autopilot=frame["autopilot"],
            armed=bool(frame["base_mode"] & ARMED),
            signed=frame.claims_signature,
        )
        known = self.components.get(sender)
        if known is not None and known.is_vehicle and not found.same_kind(known):
            return  # another one uses its number
        self.components[sender] = found
        if self.vehicle is not None and sender == (self.vehicle.system, AUTOPILOT):
            self.vehicle = found
        wanted = found.is_vehicle and self._system in (0, found.system)
        if wanted and self._state is _State.LISTENING and self._until == math.inf:
            self._until = now + _LISTENING_S

    def _answer(self, frame: MavlinkFrame) -> None:
        match frame.name:
            case "COMMAND_ACK" if frame["command"] == _REQUEST:
                self.answers = True
            case "AUTOPILOT_VERSION" if frame.component == AUTOPILOT:
                self.firmware, self.answers = frame["flight_sw_version"], True
            case "RC_CHANNELS" if frame.component == AUTOPILOT:
                self.receiver = frame["chancount"] > 0
            case "PARAM_VALUE" if frame.component == AUTOPILOT:
                bytewise = self.profile is not None and self.profile.bytewise
                value = parameter_value(frame, bytewise=bytewise)
                self._reads.take(frame["param_id"], value)
                self.answers = True
            case "VIDEO_STREAM_INFORMATION" if len(self.streams) < _MOST_STREAMS:
                self.streams[frame.component, frame["stream_id"]] = FoundStream(
                    component=frame.component,
                    name=plain(frame["name"]),
                    address=_stream_address(frame),
                )

    def _proceed(self, now: float) -> None:
        """Go on to the next state."""
        vehicles = [each for each in self.vehicles if self._system in (0, each.system)]
        if self._state is _State.ASKING or len(vehicles) != 1:
            self._state = _State.DONE
            return
        self.vehicle = vehicles[0]
        self._state, self._until = _State.ASKING, now + _ASKING_S
        self._asked_at = -math.inf
        if self._reads_more:
            self._reads.begin(self.wanted, OLDER_NAMES)

    def _is_answered(self, now: float) -> bool:
        """Whether nothing that was asked may still come."""
        if self._reads.reading:
            self._read_at = now
        if not self._reads_more:
            return bool(self.firmware) or self._requests >= _REQUESTS
        all_came = bool(self.firmware) and not self._cameras
        late = now - max(self._read_at, self._asked_at) > _AGAIN_S
        all_asked = self._requests >= _REQUESTS and late
        read = len(self.parameters) == len(self.wanted) or late
        return read and not self._reads.reading and (all_came or all_asked)

    @property
    def _cameras(self) -> list[FoundComponent]:
        """Cameras whose streams are not known."""
        system = self.vehicle.system if self.vehicle is not None else 0
        known = {component for component, _ in self.streams}
        return [
            each
            for each in self.components.values()
            if each.system == system
            and (each.component in _CAMERAS or each.kind == _CAMERA_KIND)
            and each.component not in known
        ]

    def _questions(self, system: int, now: float) -> Iterator[OutgoingMessage]:
        if name := self._reads.due(now):
            yield addressed("PARAM_REQUEST_READ", system, param_index=-1, param_id=name)
        if now - self._asked_at < _AGAIN_S or self._requests >= _REQUESTS:
            return
        self._asked_at = now
        self._requests += 1
        if not self.firmware:
            yield _request(system, AUTOPILOT, "AUTOPILOT_VERSION")
        if self.receiver is None:
            yield _request(system, AUTOPILOT, "RC_CHANNELS")
        for each in self._cameras:
            yield _request(system, each.component, "VIDEO_STREAM_INFORMATION")


def _stream_address(frame: MavlinkFrame) -> str:
    """The address of a stream for a robot file."""
    said = plain(frame["uri"])
    port = re.search(r"(?:^|:)(\d{1,5})/?$", said)
    if port is None or frame["type"] not in (_RTP, _MPEG_TS):
        return said
    if frame["type"] == _MPEG_TS:
        return f"udp://0.0.0.0:{port[1]}"
    return f"rtp://0.0.0.0:{port[1]}{'?codec=h265' if frame['encoding'] == _H265 else ''}"


def _request(system: int, component: int, name: str) -> OutgoingMessage:
    number = float(BY_NAME[name].number)
    return addressed("COMMAND_LONG", system, component, command=_REQUEST, param1=number)
