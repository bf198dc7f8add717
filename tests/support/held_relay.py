"""A relay of TCP that a test can hold in each direction: what is sent then waits, as in a network.

Nothing is lost while it holds, so all of it comes when it goes on. A connection that one side
resets is reset at the other side too.
"""

from __future__ import annotations

import contextlib
import selectors
import socket
import struct
import threading
from dataclasses import dataclass

_AT_ONCE = 65_536
_RESET = struct.pack("ii", 1, 0)
TO_ROBOT, TO_HUB = "to_robot", "to_hub"


@dataclass(eq=False)
class _Way:
    """One direction of a connection."""

    source: socket.socket
    sink: socket.socket
    name: str


class HeldRelay:
    """Takes the hub's connections, and makes one to the robot for each.

    Attributes:
        port: Its own, on loopback.
        connections: How many were made.
    """

    def __init__(self, robot: int) -> None:
        """Relay to a port of loopback."""
        self.connections = 0
        self._robot = robot
        self._held: frozenset[str] = frozenset()
        self._resets = False
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self._ways: dict[socket.socket, _Way] = {}
        self._watched: set[socket.socket] = set()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._ends = False
        self._thread = threading.Thread(target=self._run, name="relay", daemon=True)
        self._thread.start()

    def hold(self, *ways: str) -> None:
        """Let nothing pass in these directions; both: no new connection is made either."""
        self._held = frozenset(ways)

    def go_on(self) -> None:
        """Let all pass again, with what has waited."""
        self._held = frozenset()

    def reset(self) -> None:
        """Break all connections."""
        self._resets = True

    def close(self) -> None:
        self._ends = True
        self._thread.join()

    def _run(self) -> None:
        while not self._ends:
            if self._resets:
                self._resets = False
                for way in list(self._ways.values()):
                    self._end(way)
            self._watch()
            for key, _ in self._selector.select(0.01):
                if key.fileobj is self._listener:
                    self._accept()
                elif key.fileobj in self._ways:
                    self._pass(self._ways[key.fileobj])
        for way in list(self._ways.values()):
            self._end(way)
        self._listener.close()
        self._selector.close()

    def _watch(self) -> None:
        """Watch the sockets of the directions that are not held."""
        wanted = {way.source for way in self._ways.values() if way.name not in self._held}
        for each in self._watched - wanted:
            self._selector.unregister(each)
        for each in wanted - self._watched:
            self._selector.register(each, selectors.EVENT_READ)
        self._watched = wanted

    def _accept(self) -> None:
        if len(self._held) == 2:
            return
        hub, _ = self._listener.accept()
        try:
            robot = socket.create_connection(("127.0.0.1", self._robot), 1.0)
        except OSError:
            hub.close()
            return
        self.connections += 1
        for one, other, name in ((hub, robot, TO_ROBOT), (robot, hub, TO_HUB)):
            one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._ways[one] = _Way(one, other, name)

    def _pass(self, way: _Way) -> None:
        try:
            data = way.source.recv(_AT_ONCE)
            way.sink.sendall(data)
        except OSError:
            data = b""
        if not data:
            self._end(way)

    def _end(self, way: _Way) -> None:
        for each in (way.source, way.sink):
            self._ways.pop(each, None)
            if each in self._watched:
                self._watched.discard(each)
                self._selector.unregister(each)
            with contextlib.suppress(OSError):
                each.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
            each.close()
