"""Wrong frames to the door of Foxglove, from several programs that speak its protocol.

python -m tests.misbehaving.bad_panel ADDRESS COUNT RATE SEED FREE: how many frames in all, and how
many a second. Unless FREE is 0, nobody has control of the robot: then no frame is a velocity that
could drive it. It writes what it sent as a JSON line.
"""

from __future__ import annotations

import base64
import collections
import contextlib
import json
import os
import random
import socket
import struct
import sys
import time
from typing import Any

from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import ClientConnection, connect

from hub.doors.panels.panel_twist import twist_of
from hub.doors.panels.wishes import CMD_VEL
from hub.errors import HubError
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import VELOCITY_COMMAND
from tests.misbehaving.bad_frames import spoil
from tests.support.foxglove_panel import SUBPROTOCOL

_BURST_S = 0.005
_PROGRAMS = 4
_RAW = 40
"""One input of this number is bytes on a connection of their own."""
_KINDS = ("geometry_msgs/Twist", "geometry_msgs/TwistStamped")
_ENCODINGS = ("json", "cdr")


def _ops() -> list[bytes]:
    """One of each kind that a program may say."""
    channels = [
        {"id": number, "topic": topic, "encoding": encoding, "schemaName": kind}
        for number, topic in ((1, CMD_VEL), (2, CMD_VEL), (3, "/other"))
        for encoding in _ENCODINGS
        for kind in _KINDS
    ]
    said: list[dict[str, Any]] = [
        {
            "op": "subscribe",
            "subscriptions": [{"id": 1, "channelId": 1}, {"id": 2, "channelId": 9}],
        },
        {"op": "subscribe", "subscriptions": [{"id": n, "channelId": n} for n in range(1, 90)]},
        {"op": "unsubscribe", "subscriptionIds": [1, 2, 3]},
        *({"op": "advertise", "channels": [each]} for each in channels),
        {"op": "advertise", "channels": [{**channels[0], "id": n} for n in range(100, 150)]},
        {"op": "unadvertise", "channelIds": [1, 2, 3]},
        {"op": "getParameters", "parameterNames": ["robot.name", "x" * 99], "id": "a"},
        {"op": "getParameters", "parameterNames": [], "id": "b"},
        {"op": "setParameters", "parameters": [{"name": "robot.name", "value": [1, {"a": None}]}]},
        {"op": "subscribeParameterUpdates", "parameterNames": ["robot.name", "none"]},
        {"op": "unsubscribeParameterUpdates", "parameterNames": ["robot.name"]},
        {"op": "subscribeConnectionGraph"},
        {"op": "fetchAsset", "uri": "file:///etc/passwd", "requestId": 1},
        {"op": "playbackControlRequest", "state": 1},
    ]
    return [json.dumps(each).encode() for each in said]


def _velocities() -> list[bytes]:
    fast = TwistStamped.planar(0.4, 0.0)
    plain = {"linear": {"x": 0.4, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
    stamped = b"".join(map(bytes, VELOCITY_COMMAND.encode(fast)))
    return [
        json.dumps(plain).encode(),
        json.dumps({"header": {"stamp": {}}, "twist": plain}).encode(),
        stamped,
        stamped[:4] + struct.pack("<6d", 0.4, 0, 0, 0, 0, 0),
        b'{"linear": {"x": NaN}}',
        b'{"linear": {"x": 1e999}}',
        b"[" * 3000,
        b"\0" * 5000,
    ]


def drives(payload: bytes) -> bool:
    """Whether a panel of any kind drives with these bytes."""
    for encoding in _ENCODINGS:
        for kind in _KINDS:
            with contextlib.suppress(HubError):
                if not twist_of(encoding, kind, payload).neutral:
                    return True
    return False


class BadPanels:
    """Programs that connect again when the door hangs up."""

    def __init__(self, address: str, seed: int, *, free: bool) -> None:
        self._address, self._free = address, free
        self._chance = random.Random(seed)
        self._ops, self._velocities = _ops(), _velocities()
        self._programs: list[ClientConnection | None] = [None] * _PROGRAMS
        self.sent: collections.Counter[str] = collections.Counter()

    def one(self, number: int) -> None:
        """Send one wrong frame."""
        if number % _RAW == 0:
            self._raw()
            return
        place = number % _PROGRAMS
        program = self._programs[place] = self._programs[place] or self._opened()
        if program is None:
            self.sent["not let in"] += 1
            return
        try:
            program.send(self._frame())
            if place:  # the first never reads what the door says
                self._drain(program)
        except (ConnectionClosed, OSError):
            self.sent["hung up"] += 1
            self._programs[place] = None

    def close(self) -> None:
        """Leave."""
        for each in self._programs:
            if each is not None:
                with contextlib.suppress(ConnectionClosed, OSError):
                    each.close()

    def _opened(self) -> ClientConnection | None:
        try:
            opened = connect(
                self._address, subprotocols=[SUBPROTOCOL], max_size=None, close_timeout=0.2,
                open_timeout=5.0, ping_interval=None,
            )  # fmt: skip
            for each in self._ops[3:7]:  # some panels may drive
                opened.send(each.decode())
        except (InvalidHandshake, ConnectionClosed, OSError):
            return None
        return opened

    def _drain(self, program: ClientConnection) -> None:
        with contextlib.suppress(TimeoutError):
            while True:
                program.recv(0)

    def _frame(self) -> bytes | str:
        chance = self._chance
        if chance.random() < 0.5:
            op = chance.choice(self._ops)
            said = spoil(op, chance) if chance.random() < 0.8 else op
            self.sent["text"] += 1
            return said.decode("utf-8", "replace") if chance.random() < 0.95 else said
        self.sent["binary"] += 1
        while True:
            opcode = 1 if chance.random() < 0.8 else chance.randrange(256)
            channel = chance.choice([1, 1, 1, 2, 3, 77, 0xFFFFFFFF])
            payload = chance.choice(self._velocities)
            if chance.random() < 0.9:
                payload = spoil(payload, chance)
            frame = struct.pack("<BI", opcode, channel) + payload
            if chance.random() < 0.1:
                frame = spoil(frame, chance)
            if not (self._free and drives(frame[5:])):
                return frame

    def _raw(self) -> None:
        """Bytes that are no WebSocket, before or after the handshake."""
        chance = self._chance
        host, _, port = self._address.removeprefix("ws://").rpartition(":")
        key = base64.b64encode(chance.randbytes(16)).decode()
        hello = (
            f"GET / HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
            f"Sec-WebSocket-Protocol: {SUBPROTOCOL}\r\n\r\n"
        ).encode()
        right = chance.random() < 0.5
        self.sent["raw after a handshake" if right else "raw"] += 1
        # The door may hang up in the middle.
        with contextlib.suppress(OSError), socket.create_connection((host, int(port)), 2.0) as peer:
            peer.settimeout(2.0)
            peer.sendall(hello if right else spoil(hello, chance))
            if right:
                peer.recv(4096)
                op = chance.choice(self._ops)
                mask = chance.randbytes(4)
                masked = bytes(each ^ mask[at % 4] for at, each in enumerate(op[:120]))
                frame = bytes((0x81, 0x80 | len(masked))) + mask + masked
                huge = b"\x82\xff" + struct.pack(">Q", 1 << 40) + mask
                peer.sendall(spoil(chance.choice([frame, huge]), chance))


def main() -> None:
    os.nice(10)  # the attack is on the door, not on the processor
    address, count, rate, seed, free = sys.argv[1:6]
    attack = BadPanels(address, int(seed), free=free != "0")
    started = time.monotonic()
    done = 0
    while done < int(count):
        due = min(int(count), int((time.monotonic() - started) * float(rate)))
        while done < due:
            attack.one(done)
            done += 1
        time.sleep(_BURST_S)
    took = round(time.monotonic() - started, 1)
    attack.close()
    sys.stdout.write(json.dumps({"done": done, "took_s": took, **attack.sent}) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
