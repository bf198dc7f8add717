"""The relay, between real sockets on loopback addresses."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from hub.errors import EndpointError
from hub.shaper.carried import WINDOW
from hub.shaper.profile import EpisodesSpec, LinkProfile, load_profile
from hub.shaper.relay import MOST_CONNECTIONS, Relay
from tests.hub.shaper.profiles import profile
from tests.support.ports import free_port
from tests.support.waiting import until

Make = Callable[..., "Link"]
ADDRESS = "127.0.0.77"


class Link:
    """A relay that a thread runs, and a server behind it."""

    def __init__(self, made: LinkProfile, seed: int = 1) -> None:
        self.server = socket.create_server(("127.0.0.1", free_port()))
        self.server.settimeout(10.0)
        self.port = self.server.getsockname()[1]
        self.relay = Relay(ADDRESS, [("127.0.0.1", self.port)], made, seed)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self.relay.run, args=(self._ended.is_set,))
        self._thread.start()
        self._opened: list[socket.socket] = [self.server]

    def connect(self) -> socket.socket:
        """A client's socket."""
        self._opened.append(socket.create_connection((ADDRESS, self.port), 10.0))
        return self._opened[-1]

    def accept(self) -> socket.socket:
        """The hub's socket of the next connection."""
        self._opened.append(self.server.accept()[0])
        self._opened[-1].settimeout(10.0)
        return self._opened[-1]

    def pair(self) -> tuple[socket.socket, socket.socket]:
        return self.connect(), self.accept()

    def close(self) -> None:
        for each in self._opened:
            each.close()
        self._ended.set()
        self._thread.join()
        self.relay.close()


@pytest.fixture
def link() -> Iterator[Make]:
    with contextlib.ExitStack() as stack:
        yield lambda *given: stack.enter_context(contextlib.closing(Link(*given)))


def read(one: socket.socket, count: int) -> bytes:
    """So many bytes, or all before the end."""
    data = b""
    while len(data) < count and (more := one.recv(count - len(data))):
        data += more
    return data


def test_bytes_pass_both_ways_and_ends_too(link: Make) -> None:
    made = link(profile())
    near, far = made.pair()
    near.sendall(b"up")
    far.sendall(b"down")
    assert (read(far, 2), read(near, 4)) == (b"up", b"down")
    near.shutdown(socket.SHUT_WR)
    assert far.recv(1) == b""
    far.sendall(b"still")
    assert read(near, 5) == b"still"
    far.close()
    assert near.recv(1) == b""
    until(lambda: made.relay.connections == 0, 5.0)


def test_a_megabyte_each_way_at_once_arrives_whole(link: Make) -> None:
    near, far = link(profile(delay=0.001, rate=5e8)).pair()
    data = bytes(range(256)) * 4096
    senders = [threading.Thread(target=each.sendall, args=(data,)) for each in (near, far)]
    for each in senders:
        each.start()
    got: list[bytes] = []
    reader = threading.Thread(target=lambda: got.append(read(near, len(data))))
    reader.start()
    assert read(far, len(data)) == data
    for each in (*senders, reader):
        each.join()
    assert got == [data]


def test_a_large_message_over_a_lossy_link_arrives_whole(link: Make) -> None:
    near, far = link(profile(delay=0.005, rate=2e7, loss=0.1, burst=3.0)).pair()
    data = bytes(range(251)) * 1000
    near.sendall(data)
    assert read(far, len(data)) == data


def test_what_is_sent_takes_the_round_trip_and_the_connection_another(link: Make) -> None:
    made = link(profile(delay=0.1))
    began = time.monotonic()
    near, far = made.pair()
    assert time.monotonic() - began >= 0.1
    near.sendall(b"?")
    assert far.recv(1) == b"?"
    assert time.monotonic() - began >= 0.3
    far.sendall(b"!")
    assert near.recv(1) == b"!"
    assert time.monotonic() - began >= 0.4


def test_all_connections_share_the_rate(link: Make) -> None:
    made = link(profile(rate=2e6, queue=10_000))
    pairs = [made.pair() for _ in range(3)]
    began = time.monotonic()
    senders = [threading.Thread(target=near.sendall, args=(bytes(50_000),)) for near, _ in pairs]
    for each in senders:
        each.start()
    for _, far in pairs:
        assert len(read(far, 50_000)) == 50_000
    assert time.monotonic() - began >= 150_000 * 8 / 2e6
    for each in senders:
        each.join()


def test_a_sender_that_never_pauses_fills_the_link(link: Make) -> None:
    """Buffers smaller than the segments of the loopback once left 0.7 of 5 Mbit/s."""
    near, far = link(profile(rate=5e6, delay=0.01)).pair()
    sender = threading.Thread(target=near.sendall, args=(bytes(1_250_000),))  # for 2 s
    sender.start()
    far.settimeout(0.2)
    got = 0

    def reading() -> bool:
        nonlocal got
        with contextlib.suppress(TimeoutError):
            got += len(far.recv(65_536))
        return got == 1_250_000

    until(reading, 8.0, lambda: f"{got} bytes came")
    sender.join()


def test_a_full_link_holds_little_and_slows_the_sender(link: Make) -> None:
    made = link(profile(rate=64e3, queue=8000))
    near, far = made.pair()
    near.settimeout(0.2)
    with pytest.raises(TimeoutError):
        near.sendall(bytes(50_000_000))
    until(lambda: made.relay.held()[0] >= 8000, 5.0)
    assert len(far.recv(1448)) > 0
    assert made.relay.held()[0] < 8000 + 3 * 1500


def test_a_hub_that_does_not_read_fills_a_window_and_no_more(link: Make) -> None:
    made = link(profile(rate=1e9))
    near, _ = made.pair()
    near.settimeout(0.2)
    with pytest.raises(TimeoutError):
        near.sendall(bytes(100_000_000))
    assert WINDOW <= made.relay.held()[0] < WINDOW + 200_000


def test_in_a_blackout_nothing_passes_and_afterwards_all(link: Make) -> None:
    made = link(profile(blackouts=EpisodesSpec(gap=(2.0, 2.0), length=(0.5, 0.5))))
    near, far = made.pair()
    conditions = made.relay.model.up.conditions
    until(lambda: conditions.blackout(time.monotonic() - made.relay.started), 5.0)
    near.sendall(b"late")
    assert read(far, 4) == b"late"
    assert not conditions.blackout(time.monotonic() - made.relay.started)
    assert made.relay.model.up.counts.lost >= 1


def test_a_broken_connection_breaks_the_other_side(link: Make) -> None:
    made = link(profile(delay=0.01))
    for broken, other in (made.pair(), made.pair()[::-1]):
        broken.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
        broken.close()
        with contextlib.suppress(ConnectionError):
            assert other.recv(1) == b""
    until(lambda: made.relay.connections == 0, 5.0)


def test_without_a_hub_the_connection_ends(link: Make) -> None:
    made = link(profile(delay=0.01))
    made.server.close()
    near = made.connect()
    with contextlib.suppress(ConnectionError):
        assert near.recv(1) == b""
    until(lambda: made.relay.connections == 0, 5.0)


def test_one_connection_too_many_is_closed_and_the_others_live(link: Make) -> None:
    made = link(profile())
    pairs = [made.pair() for _ in range(MOST_CONNECTIONS)]
    with contextlib.suppress(ConnectionError):
        assert made.connect().recv(1) == b""
    assert made.relay.refused == 1
    near, far = pairs[0]
    near.sendall(b"x")
    assert far.recv(1) == b"x"


def test_a_busy_port_is_named() -> None:
    with (
        contextlib.closing(socket.create_server((ADDRESS, free_port()))) as taken,
        pytest.raises(EndpointError, match=f"{ADDRESS}:{taken.getsockname()[1]}"),
    ):
        Relay(ADDRESS, [("127.0.0.1", taken.getsockname()[1])], load_profile("lan"), 1)
