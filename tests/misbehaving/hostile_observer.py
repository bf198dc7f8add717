"""The holder of an observer's key who does all it can to take the hub from the others.

python -m tests.misbehaving.hostile_observer ATTACK GATEWAY KEYFILE ADDRESS SECONDS: it attacks the
gateway (tcp://...) from an address of this machine, such as 127.0.0.11.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import socket
import sys
import time
from collections.abc import Callable
from pathlib import Path

import zmq

from hub.gcm import vision
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.wire import control, control_codec, frames

_PLACES = 7
_STATE_OUT, _PICTURE_OUT = 2, 6
_BURST = 200
_PAUSE_S = 0.002


class Hostile:
    """Raw sockets with one key, from one address."""

    def __init__(self, gateway: str, keys: Path, address: str) -> None:
        host, _, port = gateway.removeprefix("tcp://").rpartition(":")
        self.host, self.port, self.address = host, int(port), address
        self._keys = read_client_keys(keys)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._context.max_sockets = 2000
        self._names = itertools.count()

    def connect(self, kind: int = zmq.DEALER, place: int = 0) -> zmq.Socket[bytes]:
        """A socket that connects to a place and comes back when it is hung up on."""
        made = self._context.socket(kind)
        made.linger, made.sndhwm, made.rcvhwm = 0, 2000, 10
        made.reconnect_ivl = 50
        self._keys.apply(made)
        made.connect(f"tcp://{self.address}:0;{self.host}:{self.port + place}")
        return made

    def client(self) -> zmq.Socket[bytes]:
        """A control connection that has said HELLO."""
        made = self.connect()
        made.send(self.hello())
        return made

    def hello(self) -> bytes:
        """A HELLO with a new name."""
        name = f"eve{os.getpid()}-{next(self._names)}"
        return control_codec.pack(control.Hello(name=name, pid=1, client=next(self._names) + 1))

    def raw(self, place: int) -> socket.socket:
        """A TCP connection that says nothing yet."""
        made = socket.socket()
        made.settimeout(0.0)
        made.bind((self.address, 0))
        with contextlib.suppress(BlockingIOError):
            made.connect((self.host, self.port + place))
        return made


def _send(to: zmq.Socket[bytes], *parts: bytes, times: int = _BURST) -> None:
    with contextlib.suppress(zmq.Again):
        for _ in range(times):
            to.send_multipart(parts, zmq.NOBLOCK)


def _drain(*sockets: zmq.Socket[bytes]) -> None:
    for each in sockets:
        with contextlib.suppress(zmq.Again):
            for _ in range(_BURST):
                each.recv_multipart(zmq.NOBLOCK)


Step = Callable[[], None]


def _lists(eve: Hostile) -> Step:
    clients = [eve.client() for _ in range(3)]
    asked = control_codec.pack(control.List())

    def step() -> None:
        for each in clients:
            _send(each, asked)
        _drain(*clients)

    return step


def _clients(eve: Hostile) -> Step:
    clients = [eve.connect() for _ in range(200)]
    ping = control_codec.pack(control.Ping(epoch=0))

    def step() -> None:
        for each in clients:
            _send(each, eve.hello(), times=1)
            _send(each, ping, times=1)
        _drain(*clients)

    return step


def _connections(eve: Hostile) -> Step:
    def step() -> None:
        made = []
        for place in range(_PLACES):
            with contextlib.suppress(OSError):
                made += [eve.raw(place) for _ in range(5)]
        for each in made:
            each.close()

    return step


def _half_handshakes(eve: Hostile) -> Step:
    held: list[socket.socket] = []
    greeting = b"\xff" + bytes(8) + b"\x7f\3\1CURVE" + bytes(15) + b"\0" + bytes(31)

    def step() -> None:
        with contextlib.suppress(OSError):
            held.append(eve.raw(len(held) % _PLACES))
        for each in held[-20:]:
            with contextlib.suppress(OSError):
                each.send(greeting[: 1 + len(held) % 64])
        while len(held) > 500:
            held.pop(0).close()

    return step


def _definitions(eve: Hostile) -> Step:
    client, numbers = eve.client(), itertools.count()

    def step() -> None:
        for _ in range(_BURST):
            name = f"E{next(numbers)}"
            for said in (
                control.Define(
                    name=name,
                    format="{" + "int," * 100 + "int}",
                    fields="",
                    keep="all",
                    plane="state",
                    rate_hz=1.0,
                    lifespan_s=1.0,
                ),
                control.Advertise(name=name),
                control.Subscribe(name=name, token=f"1.{name}"),
                control.Unsubscribe(name=name),
                control.Watch(),
            ):
                _send(client, control_codec.pack(said), times=1)
        _drain(client)

    return step


def _subscriptions(eve: Hostile) -> Step:
    planes = [eve.connect(zmq.SUB, place) for place in (_STATE_OUT, _PICTURE_OUT)]
    numbers = itertools.count()

    def step() -> None:
        for each in planes:
            for _ in range(_BURST):
                each.subscribe(b"T%d" % next(numbers) + b"x" * 200)

    return step


def _short_subscriptions(eve: Hostile) -> Step:
    planes = [eve.connect(zmq.SUB, _STATE_OUT) for _ in range(10)]
    numbers = itertools.count()

    def step() -> None:
        for each in planes:
            number = b"%d" % next(numbers)
            each.subscribe(number)
            each.unsubscribe(number)

    return step


def _query() -> tuple[bytes, bytes]:
    definition = vision.IMAGE_REQUEST
    frame = frames.pack(
        frames.prefix(definition.name),
        publisher=0,
        fingerprint=definition.fingerprint,
        sequence=1,
        stamp_ns=time.monotonic_ns(),
        payload=definition.encode(vision.ImageRequest(width_px=640, height_px=480, quality=100)),
    )
    query = control.Query(number=1, name=definition.name, timeout_s=60.0)
    return control_codec.pack(query), frame


def _queries(eve: Hostile) -> Step:
    clients = [eve.client() for _ in range(4)]

    def step() -> None:
        for each in clients:
            _send(each, *_query())
        _drain(*clients)

    return step


def _big_frames(eve: Hostile) -> Step:
    client = eve.client()
    upward = eve.connect(zmq.XSUB, _STATE_OUT)
    query = control_codec.pack(control.Query(number=1, name="GCM_Image_Request", timeout_s=60.0))
    big = bytes(frames.MAX_FRAME - 1)

    def step() -> None:
        _send(client, query, big, times=1)
        _send(upward, big, times=1)
        _drain(client)
        time.sleep(0.02)

    return step


def _slow_reader(eve: Hostile) -> Step:
    """It subscribes to everything, asks for everything, and reads nothing."""
    planes = [eve.connect(zmq.SUB, place) for place in (2, 4, 6) for _ in range(4)]
    for each in planes:
        each.subscribe(b"")
    clients = [eve.client() for _ in range(4)]
    for each in clients:
        _send(each, control_codec.pack(control.Watch()), times=1)
    said = [(control_codec.pack(control.List()),), _query()]

    def step() -> None:
        for each in clients:
            for parts in said:
                _send(each, *parts, times=1)
        time.sleep(0.1)

    return step


ATTACKS: dict[str, Callable[[Hostile], Step]] = {
    "lists": _lists,
    "clients": _clients,
    "connections": _connections,
    "half handshakes": _half_handshakes,
    "definitions": _definitions,
    "subscriptions": _subscriptions,
    "short subscriptions": _short_subscriptions,
    "queries": _queries,
    "big frames": _big_frames,
    "slow reader": _slow_reader,
}


def main() -> None:
    attack, gateway, keys, address, seconds = sys.argv[1:]
    step = ATTACKS[attack](Hostile(gateway, Path(keys), address))
    end = time.monotonic() + float(seconds)
    while time.monotonic() < end:
        step()
        time.sleep(_PAUSE_S)
    os._exit(0)  # sockets with much to send would take their time


if __name__ == "__main__":
    main()
