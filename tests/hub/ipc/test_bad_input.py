"""Rubbish at every socket of central: it is counted, and good traffic does not notice."""

from __future__ import annotations

import contextlib
import functools
import logging
import random
import socket
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
import zmq

from hub.gcm.catalog import MESSAGES
from hub.ipc.broker.central import Central
from hub.ipc.definition import Plane
from hub.ipc.wire import control, control_codec, frames
from hub.ipc.wire.definition_listing import to_listing
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.raw_client import RawClient
from tests.support.waiting import until

_GREETING = b"\xff" + bytes(8) + b"\x7f" + b"\3\1" + b"NULL".ljust(20, b"\0") + b"\0" + bytes(31)
_PLACES = {"control": 0, "state in": 1, "state out": 2, "command in": 3, "command out": 4}


_TURNED_AWAY = (
    zmq.EVENT_DISCONNECTED
    | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
    | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
)


class Traffic:
    """A good pair; `check` sends more and sees that nothing at all was lost."""

    def __init__(self, one: Peer, other: Peer) -> None:
        self.one, self.other = one, other
        self.received = {d.name: other.collect(d) for d in (v.LOG, v.EVENT)}
        one.publish_until(v.LOG, self.received[v.LOG.name])
        one.publish_until(v.EVENT, self.received[v.EVENT.name])
        self._sent = 0
        other.call(lambda: other.client.respond(v.ASK, v.ANSWER, lambda ask: ask))
        other.call(lambda: other.client.directory.listing(5.0))

    def check(self) -> None:
        for _ in range(10):
            for definition in (v.LOG, v.EVENT):
                self.one.publish(definition, Number(value=self._sent))
            self._sent += 1
        for name, received in self.received.items():
            until(
                lambda received=received: self._values(received) == list(range(self._sent)),
                10.0,
                lambda name=name: f"good messages of {name} were lost",
            )
        answer = self.one.call(
            lambda: self.one.client.query_response(v.ASK, Number(value=1), v.ANSWER, timeout=10.0)
        )
        assert answer == Number(value=1)
        assert all(how.missed == 0 for received in self.received.values() for _, how in received)
        assert self.one.faults == self.other.faults == []

    @staticmethod
    def _values(received: list[Any]) -> list[int]:
        return [value.value for value, _ in received if value.value >= 0]


@pytest.fixture
def wanted_endpoint(tmp_path: Path) -> str:
    return f"ipc://{tmp_path}/central"


@pytest.fixture
def connect(make: Callable[..., Peer]) -> Callable[[str], Peer]:
    """What these peers say goes through central."""
    return lambda name: make(name, near=False)


@pytest.fixture
def traffic(connect: Callable[[str], Peer], caplog: pytest.LogCaptureFixture) -> Iterator[Traffic]:
    pair = Traffic(connect("one"), connect("other"))
    pair.check()
    process = psutil.Process()
    memory, files = process.memory_info().rss, process.num_fds()
    yield pair
    pair.check()
    warnings = [r.getMessage().partition(" (")[0] for r in caplog.records
                if r.name == "hub.ipc.broker.central" and r.levelno >= logging.WARNING]  # fmt: skip
    assert len(warnings) == len(set(warnings)), "central said the same twice"
    assert "internal fault" not in warnings
    assert process.memory_info().rss - memory < 64 << 20
    until(lambda: process.num_fds() <= files + 4, 5.0, "connections were left open")


@pytest.fixture
def dropped(traffic: Traffic) -> Callable[[str], int]:
    """How often central has dropped something, by reason, as any client can see it."""

    def count(reason: str) -> int:
        listing = traffic.one.call(lambda: traffic.one.client.directory.listing(5.0))
        return {count.reason: count.count for count in listing.dropped}.get(reason, 0)

    return count


Plain = Callable[[int, str], zmq.Socket[bytes]]


@pytest.fixture
def plain(central: Central) -> Iterator[Plain]:
    """Makes sockets of somebody who speaks ZeroMQ but knows nothing of this protocol."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    made: list[zmq.Socket[bytes]] = []

    def make(kind: int, place: str) -> zmq.Socket[bytes]:
        made.append(context.socket(kind))
        made[-1].rcvhwm = 10
        # From before it connects, or what comes of that could be missed.
        made[-1].get_monitor_socket(_TURNED_AWAY)
        made[-1].connect(f"ipc://{_path(central, place)}")
        return made[-1]

    yield make
    context.destroy(linger=0)


def _path(central: Central, place: str) -> str:
    paths = (central.endpoints[0].removeprefix("ipc://"), *central.entrances[0].paths)
    return paths[_PLACES[place]]


def _throw(path: str, raw: bytes) -> socket.socket:
    thrown = socket.socket(socket.AF_UNIX)
    thrown.settimeout(5.0)
    thrown.connect(path)
    with contextlib.suppress(OSError):
        thrown.sendall(raw)
    return thrown


@pytest.mark.parametrize("place", _PLACES)
def test_random_bytes_on_a_raw_connection(
    central: Central, traffic: Traffic, dropped: Callable[[str], int], place: str
) -> None:
    randomness = random.Random(place)
    for number in range(30):
        raw = randomness.randbytes(randomness.randint(1, 2000))
        start = _GREETING[: randomness.randint(0, len(_GREETING))] if number % 2 else b""
        _throw(_path(central, place), start + raw).close()
    with _throw(_path(central, place), b"GET / HTTP/1.1\r\nHost: robot\r\n\r\n" * 10):
        until(lambda: dropped(f"bad handshake on {place}") >= 10, 10.0)
    traffic.check()


@pytest.mark.parametrize("place", _PLACES)
def test_greeting_cut_anywhere_and_connection_held_open(
    central: Central, traffic: Traffic, place: str
) -> None:
    with contextlib.ExitStack() as held:
        for length in range(0, len(_GREETING), 6):
            held.enter_context(_throw(_path(central, place), _GREETING[:length]))
        traffic.check()


def _handshake(path: str, socket_type: bytes) -> socket.socket:
    """A raw connection that has come as far as sending messages."""
    raw = _throw(path, _GREETING)
    ready = b"\5READY" + b"\x0bSocket-Type" + struct.pack(">I", len(socket_type)) + socket_type
    if socket_type == b"DEALER":
        ready += b"\x08Identity" + struct.pack(">I", 0)
    raw.sendall(b"\4" + bytes([len(ready)]) + ready)
    heard = b""
    while len(heard) < 66:
        heard += raw.recv(4096)
    return raw


@pytest.mark.parametrize(
    ("place", "socket_type"),
    [
        ("control", b"DEALER"),
        ("state in", b"PUB"),
        ("command in", b"PUB"),
        ("state out", b"SUB"),
        ("command out", b"SUB"),
    ],
)
def test_announced_giant_frame_costs_the_connection_and_no_memory(
    central: Central, traffic: Traffic, place: str, socket_type: bytes
) -> None:
    before = psutil.Process().memory_info().rss
    for _ in range(3):
        with _handshake(_path(central, place), socket_type) as raw:
            raw.settimeout(10.0)
            # Central hangs up long before it has all that is sent.
            with pytest.raises(ConnectionError):  # noqa: PT012 - any of them
                raw.sendall(b"\2" + struct.pack(">Q", 8 << 30))
                for _ in range(1024):
                    raw.sendall(bytes(1 << 16))
    assert psutil.Process().memory_info().rss - before < 32 << 20
    traffic.check()


def _good_frame(name: str, fingerprint: int, payload: bytes, publisher: int = 9) -> bytes:
    return frames.pack(
        frames.prefix(name),
        publisher=publisher,
        fingerprint=fingerprint,
        sequence=1,
        stamp_ns=1,
        payload=[payload],
    )


@pytest.mark.parametrize(
    ("plane", "definition", "malformed"),
    # Central drops a command of several parts whole, and those with a random number.
    [(Plane.STATE, v.LOG, 1100), (Plane.COMMAND, v.EVENT, 44)],
    ids=["state", "command"],
)
def test_plain_publisher_of_rubbish(
    traffic: Traffic,
    central: Central,
    dropped: Callable[[str], int],
    plane: Plane,
    definition: Any,
    malformed: int,
) -> None:
    """It publishes under a name that is subscribed, because all else it does not even send."""
    with zmq.Context() as context:
        speaker = RawClient(context, central.endpoints[0], "speaker")
        publisher = speaker.connect(zmq.XPUB, speaker.input_of(plane), speaker.ticket)
        # The subscriptions come first: from then on it is let send.
        until(lambda: publisher.poll(0), 5.0)
        topic = frames.topic(definition.name)
        pack = functools.partial(_good_frame, definition.name, publisher=speaker.number)
        good = pack(definition.fingerprint, b"\0\1\0\0\1\0\0\0")
        randomness = random.Random(1)
        for length in range(len(topic), len(good)):
            publisher.send(good[:length])
        for _ in range(100):
            publisher.send(topic + randomness.randbytes(randomness.randint(0, 300)))
        publisher.send(pack(5, b"\0\1\0\0\1\0\0\0"))
        # Whole at central, which looks into no payload; the subscriber drops it.
        publisher.send(pack(definition.fingerprint, b"\0\1\0\0"))
        publisher.send_multipart([topic, *[b"x"] * 1000])
        until(lambda: dropped("malformed frame") >= 100, 10.0)
        until(lambda: dropped("wrong format") == 1, 10.0)
        faults = traffic.other.client.faults.counts
        until(lambda: faults["malformed frame"] >= malformed, 10.0)
        until(lambda: faults["wrong format"] == 2, 10.0)
        speaker.close()
    traffic.check()


def test_undefined_message_is_counted(
    traffic: Traffic,
    dropped: Callable[[str], int],
    plain: Plain,
) -> None:
    listener = plain(zmq.SUB, "state out")
    listener.subscribe(b"Nobody_Defined\0")
    publisher = plain(zmq.PUB, "state in")
    frame = _good_frame("Nobody_Defined", 5, b"\0\1\0\0")
    until(lambda: dropped("undefined message"), 10.0, meanwhile=lambda: publisher.send(frame))
    traffic.check()


def test_plain_dealers_with_random_and_cut_control_frames(
    traffic: Traffic,
    dropped: Callable[[str], int],
    plain: Plain,
) -> None:
    randomness = random.Random(2)
    hello = control_codec.pack(control.Hello(name="rubbish", pid=1))
    sent = 0
    for _ in range(4):
        dealer = plain(zmq.DEALER, "control")
        for length in range(len(hello)):
            dealer.send(hello[:length])
        for kind in range(20):
            start = b"RUNE\1" + bytes([kind, 0, 0])
            dealer.send(start + randomness.randbytes(randomness.randint(0, 80)))
            dealer.send(start + b"\0\1\0\0" + randomness.randbytes(randomness.randint(0, 80)))
        dealer.send_multipart([b"x"] * 5000)
        dealer.send_multipart([hello, b"", b""])
        sent += len(hello) + 2
    until(lambda: dropped("malformed control frame") >= sent, 10.0)
    traffic.check()


def test_peer_that_says_hello_and_then_nonsense(
    traffic: Traffic,
    dropped: Callable[[str], int],
    plain: Plain,
) -> None:
    dealer = plain(zmq.DEALER, "control")
    log = to_listing(v.LOG)
    deep = to_listing(MESSAGES[0]).__class__(
        name="Deep", format="{}", fields="a{" * 20_000, keep="newest", plane="state",
        rate_hz=0.0, lifespan_s=0.0,
    )  # fmt: skip
    said = [
        control.Hello(name="nonsense", pid=-1),
        control.Hello(name="nonsense again", pid=-1),
        deep,
        log,
        control.Handle(name="T_Ask" * 100_000),
        control.Handle(name="Undefined"),
        control.Response(number=1),
        control.Failure(number=2**32 - 1, error="HubError", text="x" * 100_000),
        control.Query(number=1, name="T_Nobody", timeout_s=float("nan")),
        control.Welcome(
            publisher=1,
            epoch=1,
            machine=1,
            sent=0.0,
            hub_time=0.0,
            near=True,
            ports=(1,) * 6,
            paths=("",) * 6,
        ),
        control.Pong(epoch=1, sent=0.0, hub_time=0.0),
    ]
    for message in said:
        dealer.send(control_codec.pack(message))
    query = control.Query(number=2, name="T_Ask", timeout_s=5.0)
    dealer.send_multipart([control_codec.pack(query), b"no frame"])
    for reason, count in {
        "refused definition": 1,
        "refused name": 2,
        "late answer": 2,
        "unexpected control message": 2,
    }.items():
        until(lambda reason=reason, count=count: dropped(reason) == count, 5.0, reason)
    answers: list[Any] = []

    def failures() -> dict[int, str]:
        while dealer.poll(0):
            answers.append(control_codec.unpack(dealer.recv_multipart()[0]))
        return {a.number: a.error for a in answers if isinstance(a, control.Failure)}

    until(lambda: len(failures()) == 2, 5.0)
    assert failures() == {1: "NoHandlerError", 2: "HandlerFailedError"}
    traffic.check()


def test_frames_of_another_protocol_version_are_counted(
    traffic: Traffic,
    dropped: Callable[[str], int],
    plain: Plain,
) -> None:
    dealer = plain(zmq.DEALER, "control")
    hello = bytearray(control_codec.pack(control.Hello(name="future", pid=1)))
    hello[4] += 1
    dealer.send(bytes(hello))
    until(lambda: dropped("malformed control frame") == 1, 5.0)
    traffic.check()


@pytest.mark.parametrize(
    ("place", "kind"),
    [
        ("control", zmq.SUB),
        ("state in", zmq.PUSH),
        ("state out", zmq.PULL),
        ("command in", zmq.DEALER),
        ("command out", zmq.REQ),
    ],
)
def test_socket_of_the_wrong_kind_is_turned_away(
    traffic: Traffic,
    plain: Plain,
    place: str,
    kind: int,
) -> None:
    monitor = plain(kind, place).get_monitor_socket()
    until(lambda: monitor.poll(0), 10.0)
    traffic.check()


def test_two_hundred_subscriptions_to_rubbish(traffic: Traffic, plain: Plain) -> None:
    randomness = random.Random(3)
    for place in ("state out", "command out"):
        subscriber = plain(zmq.XSUB, place)
        for number in range(200):
            subscriber.send(b"\1" + randomness.randbytes(number + 1))
            subscriber.send(bytes([number % 256]) * 20)
        # Unsubscribes what it never had.
        subscriber.send(b"\0" + frames.topic(v.LOG.name))
    traffic.check()


def test_subscriber_that_never_reads_stalls_nobody(traffic: Traffic, plain: Plain) -> None:
    stuck = plain(zmq.SUB, "state out")
    stuck.subscribe(b"")
    until(lambda: stuck.poll(0), 10.0, meanwhile=traffic.check)
    for _ in range(20):
        traffic.check()


def test_three_hundred_connections_that_come_and_go(central: Central, traffic: Traffic) -> None:
    for number in range(300):
        place = list(_PLACES)[number % len(_PLACES)]
        _throw(_path(central, place), _GREETING[: number % 65]).close()
        if number % 100 == 0:
            traffic.check()
    assert set(central.connected()) == {"one", "other"}
