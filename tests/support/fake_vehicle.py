"""A vehicle at the other end of a link: it answers questions, and does not move."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

from hub.robots.mavlink.asking.session import VehicleQuestion
from hub.robots.mavlink.wire.definitions import BY_NUMBER
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from hub.robots.mavlink.wire.signing import Signer

Sent = tuple[int, str, dict[str, Any]]
"""Component of the sender, name, fields."""
ACCEPTED, DENIED = 0, 2


class FakeVehicle:
    """The answers of one vehicle; tests change its attributes.

    Attributes:
        kind: Its MAV_TYPE.
        parameters: Value and MAV_PARAM_TYPE of each parameter, in their order.
        streams: Address of the video stream of each camera component.
        stream_fields: Further fields of these streams.
        missions: Items of each mission type.
        armed: Whether it is armed.
        lost: Messages, by name and place among those of the name, that do not reach anybody.
        deaf: Whether it answers nothing, as without its signing key.
        frozen: Parameters that keep their value.
        heard: Names of the messages that came.
        keys: Keys that SETUP_SIGNING gave it.
        beats: Further senders of heartbeats: component, type, autopilot.
        others: The same of other systems, whose number stands first.
    """

    def __init__(self, kind: int = 10, system: int = 1) -> None:
        self.kind, self.system = kind, system
        self.parameters: dict[str, tuple[float, int]] = {}
        self.streams: dict[int, str] = {}
        self.stream_fields: dict[str, int] = {}
        self.missions: dict[int, list[dict[str, Any]]] = {}
        self.armed = self.deaf = False
        self.lost: set[tuple[str, int]] = set()
        self.frozen: set[str] = set()
        self.heard: list[str] = []
        self.keys: list[bytes] = []
        self.beats: list[tuple[int, int, int]] = []
        self.others: list[tuple[int, int, int, int]] = []
        self._sent: dict[str, int] = {}

    def beat(self) -> list[Sent]:
        """Its heartbeats, once a second."""
        mode = 128 if self.armed else 0
        own = (1, self.kind, 3)
        return [
            (
                component,
                "HEARTBEAT",
                {"type": kind, "autopilot": autopilot, "base_mode": mode, "system_status": 3},
            )
            for component, kind, autopilot in (own, *self.beats)
        ]

    def answer(self, frame: MavlinkFrame) -> list[Sent]:
        """What it sends when a frame comes."""
        self.heard.append(frame.name)
        answers = () if self.deaf else self._answers(frame)
        return [each for each in answers if not self._is_lost(each[1])]

    def _is_lost(self, name: str) -> bool:
        place = self._sent[name] = self._sent.get(name, -1) + 1
        return (name, place) in self.lost

    def _answers(self, frame: MavlinkFrame) -> Iterator[Sent]:
        match frame.name:
            case "TIMESYNC":
                yield 1, "TIMESYNC", {"tc1": 1, "ts1": frame["ts1"]}
            case "COMMAND_LONG":
                yield from self._command(frame)
            case "SETUP_SIGNING":
                self.keys.append(bytes(frame["secret_key"]))
            case name if name.startswith("PARAM"):
                yield from self._parameter(frame)
            case name if name.startswith("MISSION_REQUEST"):
                yield self._mission(frame)

    def _parameter(self, frame: MavlinkFrame) -> Iterator[Sent]:
        if frame.name == "PARAM_REQUEST_LIST":
            yield from map(self._value, self.parameters)
            return
        names = [*self.parameters]
        name, place = frame["param_id"], frame.fields.get("param_index", -1)
        if 0 <= place < len(names):
            name = names[place]
        if name not in self.parameters:
            return
        if frame.name == "PARAM_SET" and name not in self.frozen:
            self.parameters[name] = (frame["param_value"], self.parameters[name][1])
        yield self._value(name)

    def _mission(self, frame: MavlinkFrame) -> Sent:
        kind = frame["mission_type"]
        fields = {"mission_type": kind, "target_system": 255, "target_component": 190}
        items = self.missions.get(kind, [])
        if frame.name == "MISSION_REQUEST_LIST":
            return 1, "MISSION_COUNT", {"count": len(items), **fields}
        return 1, "MISSION_ITEM_INT", {"seq": frame["seq"], **items[frame["seq"]], **fields}

    def _command(self, frame: MavlinkFrame) -> Iterator[Sent]:
        component = frame["target_component"]
        asked = BY_NUMBER.get(int(frame["param1"]))
        result = ACCEPTED
        if frame["command"] != 512 or asked is None:
            result = DENIED
        elif asked.name == "AUTOPILOT_VERSION":
            yield component, asked.name, {"flight_sw_version": 4 << 24 | 7 << 16}
        elif asked.name == "VIDEO_STREAM_INFORMATION" and component in self.streams:
            uri = self.streams[component]
            said = {"stream_id": 1, "name": "main", "uri": uri, **self.stream_fields}
            yield component, asked.name, said
        yield (
            component,
            "COMMAND_ACK",
            {
                "command": frame["command"],
                "result": result,
                "target_system": 255,
                "target_component": 190,
            },
        )

    def _value(self, name: str) -> Sent:
        value, kind = self.parameters[name]
        names = [*self.parameters]
        return (
            1,
            "PARAM_VALUE",
            {
                "param_id": name,
                "param_value": value,
                "param_type": kind,
                "param_count": len(names),
                "param_index": names.index(name),
            },
        )


class _Air:
    """Packs what vehicles send, and gives them what comes."""

    def __init__(self, vehicles: tuple[FakeVehicle, ...], signer: Signer | None = None) -> None:
        self._vehicles, self._signer = vehicles, signer
        self._packers: dict[tuple[int, int], FramePacker] = {}
        self._parser = FrameParser()

    def beats(self) -> list[bytes]:
        """The heartbeats of all."""
        frames = [frame for each in self._vehicles for frame in self._packed(each, each.beat())]
        for each in self._vehicles:
            for system, component, kind, autopilot in each.others:
                packer = FramePacker(system, component, self._signer)
                frames.append(packer.pack("HEARTBEAT", type=kind, autopilot=autopilot))
        return frames

    def answers(self, datagram: bytes) -> list[bytes]:
        """What they answer."""
        return [
            answer
            for frame in self._parser.datagram(datagram)
            for each in self._vehicles
            if frame.fields.get("target_system", 0) in (0, each.system)
            for answer in self._packed(each, each.answer(frame))
        ]

    def _packed(self, vehicle: FakeVehicle, messages: list[Sent]) -> Iterator[bytes]:
        for component, name, fields in messages:
            sender = vehicle.system, component
            packer = self._packers.setdefault(sender, FramePacker(*sender, self._signer))
            yield packer.pack(name, **fields)


def asked(question: VehicleQuestion, *vehicles: FakeVehicle, seconds: float = 20.0) -> bool:
    """Carry out a question without a link, in simulated time; returns whether it ended."""
    air, packer, parser = _Air(vehicles), FramePacker(255, 190), FrameParser()
    for tick in range(int(seconds / 0.01)):
        now = tick * 0.01
        frames = air.beats() if tick % 100 == 0 else []
        for name, fields in question.due(now):
            frames += air.answers(packer.pack(name, **fields))
        for frame in parser.feed(b"".join(frames)):
            question.received(frame, now)
        if question.done:
            return True
    return False


@contextlib.contextmanager
def served(*vehicles: FakeVehicle, signer: Signer | None = None) -> Iterator[str]:
    """The vehicles at one UDP address, which is the value."""
    stop = threading.Event()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
        link.bind(("127.0.0.1", 0))
        thread = threading.Thread(target=_serve, args=(_Air(vehicles, signer), link, stop))
        thread.start()
        try:
            yield f"udp://127.0.0.1:{link.getsockname()[1]}"
        finally:
            stop.set()
            thread.join()


def _serve(air: _Air, link: socket.socket, stop: threading.Event) -> None:
    peers: set[Any] = set()
    beat_at = time.monotonic()
    while not stop.is_set():
        if time.monotonic() >= beat_at:
            beat_at += 0.1
            _send(link, air.beats(), peers)
        if select.select([link], [], [], 0.02)[0]:
            with contextlib.suppress(ConnectionError):
                data, peer = link.recvfrom(65536)
                peers.add(peer)
                _send(link, air.answers(data), {peer})


def _send(link: socket.socket, frames: list[bytes], peers: set[Any]) -> None:
    for frame in frames:
        for peer in peers:
            link.sendto(frame, peer)
