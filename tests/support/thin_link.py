"""A thin link in front of a hub: delay, rate and a bounded buffer, in a process of its own.

It takes TCP connections at the hub's ports on another loopback address, and carries all of them in
one queue a direction, as a radio does. Each piece of up to 1,448 bytes pays for a packet's headers
too. It needs no rights; packets are not lost, as TCP would send them again, but wait.
"""

from __future__ import annotations

import collections
import os
import selectors
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, field

ADDRESS = "127.0.0.2"
PORTS = 7
_PIECE = 1448
_LARGE = 1_000_000
"""Where so much may wait, small buffers of sockets would only make TCP pause [bytes]."""
_HEADERS = 52
"""IP and TCP with time stamps [bytes]."""


@dataclass
class Direction:
    """What is on its way.

    Attributes:
        rate: [bit/s]
        delay: [s]
        room: How many bytes may wait [bytes].
    """

    rate: float
    delay: float
    room: int
    free: float = 0.0
    queue: collections.deque[tuple[float, float, socket.socket, bytes]] = field(
        default_factory=collections.deque
    )

    def put(self, to: socket.socket, data: bytes) -> None:
        sent = max(self.free, time.monotonic()) + (len(data) + _HEADERS) * 8 / self.rate
        self.free = sent
        self.queue.append((sent + self.delay, sent, to, data))

    def next(self) -> float:
        return self.queue[0][0] if self.queue else float("inf")

    def waiting(self, now: float) -> int:
        """Bytes that have not left yet."""
        return sum(len(data) for _, sent, _, data in self.queue if sent > now)


class Relay:
    """Carries between ADDRESS and 127.0.0.1."""

    def __init__(self, ports: list[int], rate: float, delay: float, room: int) -> None:
        self._selector = selectors.DefaultSelector()
        self._up = Direction(rate, delay, room)
        self._down = Direction(rate, delay, room)
        self._other: dict[socket.socket, tuple[socket.socket, Direction]] = {}
        for port in ports:
            listening = socket.create_server((ADDRESS, port))
            self._selector.register(listening, selectors.EVENT_READ, port)

    def run(self) -> None:
        """Until killed."""
        while True:
            now = time.monotonic()
            self._hold_back(now)
            wait = min(self._up.next(), self._down.next()) - now
            for key, _ in self._selector.select(max(0.0, min(wait, 0.005))):
                assert isinstance(key.fileobj, socket.socket)
                if key.data is not None:
                    self._accept(key.fileobj, key.data)
                elif key.fileobj in self._other:
                    self._read(key.fileobj)
            self._deliver(time.monotonic())

    def _hold_back(self, now: float) -> None:
        """Read nothing more for a direction that is full, so that TCP slows its senders down."""
        for direction in (self._up, self._down):
            full = direction.waiting(now) >= direction.room
            for one, (_, way) in self._other.items():
                if way is direction and (one in self._selector.get_map()) == full:
                    if full:
                        self._selector.unregister(one)
                    else:
                        self._selector.register(one, selectors.EVENT_READ)

    def _accept(self, listening: socket.socket, port: int) -> None:
        near, _ = listening.accept()
        far = socket.create_connection(("127.0.0.1", port))
        for one in (near, far):
            one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if self._up.room < _LARGE:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8192)
            self._selector.register(one, selectors.EVENT_READ)
        self._other[near], self._other[far] = (far, self._up), (near, self._down)

    def _read(self, one: socket.socket) -> None:
        to, direction = self._other[one]
        try:
            data = one.recv(_PIECE)
        except OSError:
            data = b""
        if data:
            direction.put(to, data)
        else:
            self._end(one)

    def _deliver(self, now: float) -> None:
        for direction in (self._up, self._down):
            while direction.next() <= now:
                _, _, to, data = direction.queue.popleft()
                try:
                    to.sendall(data)
                except OSError:
                    self._end(to)

    def _end(self, one: socket.socket) -> None:
        pair = self._other.pop(one, None)
        for each in (one, *(pair[:1] if pair else ())):
            self._other.pop(each, None)
            if each.fileno() >= 0:
                if each in self._selector.get_map():
                    self._selector.unregister(each)
                each.close()


class ThinLink:
    """The process.

    Attributes:
        endpoint: The hub's at the near end.
    """

    def __init__(
        self, hub: str, *, rate: float, delay: float = 0.02, room: int = 64_000, ports: int = PORTS
    ) -> None:
        """Start it, and wait until it listens.

        Args:
            hub: The hub's endpoint, tcp://127.0.0.1:PORT.
            rate: Each way [bit/s].
            delay: Each way [s].
            room: Bytes that may wait in it, each way.
            ports: How many there are in a row.
        """
        port = int(hub.rpartition(":")[2])
        self.endpoint = f"tcp://{ADDRESS}:{port}"
        arguments = [str(port), str(ports), str(rate), str(delay), str(room)]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.thin_link", *arguments],
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == b"ready\n"

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()


def main() -> None:
    """Carry as `ThinLink` says."""
    first, count = int(sys.argv[1]), int(sys.argv[2])
    rate, delay, room = float(sys.argv[3]), float(sys.argv[4]), int(sys.argv[5])
    relay = Relay(list(range(first, first + count)), rate, delay, room)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    relay.run()


if __name__ == "__main__":
    main()
