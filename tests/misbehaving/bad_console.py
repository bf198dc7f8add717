"""Local clients of a mirror's hub that send wrong frames, and right ones that they may not send.

python -m tests.misbehaving.bad_console ENDPOINT COUNT RATE SEED: how many frames in all, and how
many a second. It writes what it sent as a JSON line.
"""

from __future__ import annotations

import collections
import json
import os
import random
import sys
import time
from typing import Any

import zmq

from hub.errors import HubError
from hub.gcm.control import CONSOLE_HEARTBEAT, CONTROL_REQUEST
from hub.gcm.geometry import TwistStamped
from hub.gcm.mapping import MAP_REQUEST
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.gcm.vision import IMAGE_REQUEST, ImageRequest
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.wire import control, frames
from hub.ipc.wire.control_codec import pack
from tests.misbehaving.bad_frames import control_frames, spoil
from tests.support.raw_client import Context, RawClient

_BURST_S = 0.005
_CLIENTS = 4
_STAY = 2000
"""Inputs after which the oldest client goes without a word, and another comes."""
_FAR = ((1 << 62) - 1, 1 << 62, (1 << 63) - 1, -1, -(1 << 63))
_TIMEOUTS = (0.1, 1.0, 1e300, float("nan"), -1.0)
_COMMANDS: tuple[MessageDefinition[Any], ...] = (
    VELOCITY_COMMAND,
    VELOCITY_COMMAND,
    CONSOLE_HEARTBEAT,
)
_ASKED: tuple[MessageDefinition[Any], ...] = (IMAGE_REQUEST, MAP_REQUEST, CONTROL_REQUEST)


class _Console(RawClient):
    """A client that central knows, and its sockets."""

    def __init__(self, context: Context, endpoint: str, name: str) -> None:
        super().__init__(context, endpoint, name)
        self.planes = [
            self.connect(zmq.PUB, self.input_of(plane), self.ticket)
            for plane in (Plane.COMMAND, Plane.STATE)
        ]


class BadConsoles:
    """Some of them at a time."""

    def __init__(self, endpoint: str, seed: int) -> None:
        self._endpoint = endpoint
        self._chance = random.Random(seed)
        self._context: Context = zmq.Context()
        self._controls = control_frames()
        self._came = 0
        self.sent: collections.Counter[str] = collections.Counter()
        self._present: collections.deque[_Console] = collections.deque()
        while len(self._present) < _CLIENTS:
            self._present.append(self._come())

    def one(self, number: int) -> None:
        """Send one frame."""
        if number % _STAY == _STAY - 1:
            self._present.popleft().close()
            self._present.append(self._come())
        console = self._chance.choice(self._present)
        self._chance.choice((self._command, self._command, self._query, self._control))(console)
        while console.control.poll(0):
            console.control.recv_multipart()

    def close(self) -> None:
        """Leave."""
        self._context.destroy(linger=200)

    def _come(self) -> _Console:
        self._came += 1
        self.sent["consoles"] += 1
        return _Console(self._context, self._endpoint, f"eve {os.getpid()} {self._came}")

    def _stamp(self) -> int:
        return self._chance.choice(_FAR) if self._chance.random() < 0.3 else time.monotonic_ns()

    def _command(self, console: _Console) -> None:
        """A velocity without control, or its rubbish; under its own number or one of nobody."""
        chance = self._chance
        definition = chance.choice(_COMMANDS)
        payload = b"".join(map(bytes, VELOCITY_COMMAND.encode(TwistStamped.planar(0.4, 0.0))))
        raw = frames.pack(
            frames.prefix(definition.name),
            publisher=console.number if chance.random() < 0.8 else chance.getrandbits(32),
            fingerprint=definition.fingerprint,
            sequence=chance.getrandbits(64 if chance.random() < 0.1 else 20),
            stamp_ns=self._stamp(),
            payload=[payload if chance.random() < 0.5 else spoil(payload, chance)],
        )
        if chance.random() < 0.5:
            raw = spoil(raw, chance, keep=len(frames.prefix(definition.name)))
        chance.choice(console.planes).send(raw)
        self.sent["command"] += 1

    def _query(self, console: _Console) -> None:
        """A question that nobody can answer; never a right one about control."""
        chance = self._chance
        request = chance.choice(_ASKED)
        payload = b"".join(map(bytes, IMAGE_REQUEST.encode(ImageRequest(width_px=4))))
        frame = frames.pack(
            frames.prefix(request.name),
            publisher=console.number,
            fingerprint=request.fingerprint if chance.random() < 0.8 else chance.getrandbits(64),
            sequence=1,
            stamp_ns=self._stamp(),
            payload=[payload[:6] if request is CONTROL_REQUEST else spoil(payload, chance)],
        )
        query = control.Query(
            number=chance.getrandbits(32), name=request.name,
            timeout_s=chance.choice(_TIMEOUTS),
        )  # fmt: skip
        self._tell(console, pack(query), frame)
        self.sent["query"] += 1

    def _control(self, console: _Console) -> None:
        chance = self._chance
        number, name = chance.getrandbits(32), chance.choice(_ASKED).name
        last = pack(control.Last(number=number, name=name, timeout_s=chance.choice(_TIMEOUTS)))
        raw = spoil(chance.choice([*self._controls, last]), chance, keep=chance.choice([0, 8, 8]))
        self._tell(console, raw, *([chance.randbytes(40)] if chance.random() < 0.2 else []))
        self.sent["control"] += 1

    def _tell(self, console: _Console, *parts: bytes) -> None:
        try:
            console.control.send_multipart(parts, zmq.NOBLOCK)
        except zmq.Again:
            self.sent["not taken"] += 1


def main() -> None:
    os.nice(10)
    endpoint, count, rate, seed = sys.argv[1:5]
    consoles = BadConsoles(endpoint, int(seed))
    started = time.monotonic()
    done = 0
    while done < int(count):
        due = min(int(count), int((time.monotonic() - started) * float(rate)))
        while done < due:
            try:
                consoles.one(done)
            except HubError:
                consoles.sent["faults"] += 1
            done += 1
        time.sleep(_BURST_S)
    took = round(time.monotonic() - started, 1)
    consoles.close()
    sys.stdout.write(json.dumps({"done": done, "took_s": took, **consoles.sent}) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
