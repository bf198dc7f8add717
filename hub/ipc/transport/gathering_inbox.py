"""The inbox of a client that wants all messages cheaply, and may get them some milliseconds late.

Messages wait in the system until the client looks, every `GATHER_S`. ZeroMQ would wake a thread of
its own for each message that comes, and that costs more than all the rest. Publishers see no
difference: their PUSH sockets use ZMTP with this side, and hold what the system does not take.
"""

from __future__ import annotations

import contextlib
import functools
import os
import secrets
import socket
from typing import Protocol

from hub.errors import FrameError
from hub.ipc import endpoints
from hub.ipc.transport import file_descriptors
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.transport.sockets import CONNECTING
from hub.ipc.wire import zmtp

GATHER_S = 0.05
"""Longest time between two looks [s]."""
_SHORTEST_S = 0.005
_ROOM = 208 << 10
"""Room of the system for messages of one publisher: Linux's default [bytes]. ZeroMQ sets none."""
_EACH, _SHARE = 2048, 3
"""Room that a frame takes at most: for itself, and for each of its bytes [bytes]."""
_AT_ONCE = 1 << 20
_MOST_AT_ONCE = 8
"""Most reads of a connection in one look: a flood does not keep the others waiting."""
_GREETING_S = 3.0
"""Longest time until a connection is ready [s]."""


class TakeGathered(Protocol):
    """The receiver of what was gathered."""

    def begin(self, since: float, now: float) -> None:
        """A look begins; what it finds came between these times [s]."""

    def take(self, data: bytes, places: list[int]) -> None:
        """Take the messages of one connection: begin and end of each, in turn."""

    def end(self) -> None:
        """The look is over."""


class _Incoming:
    """One publisher."""

    def __init__(self, link: socket.socket, opened: float) -> None:
        self.link = link
        self.opened = opened
        self.watched = True
        self.stream = zmtp.Stream()


class GatheringInbox:
    """An inbox.

    Attributes:
        address: Address for publishers.
    """

    def __init__(self, transport: ClientTransport, receiver: TakeGathered) -> None:
        """Open.

        Args:
            transport: The client's.
            receiver: Gets the messages.
        """
        self.address = f"{endpoints.GATHER_PREFIX}{secrets.token_hex(8)}"
        self._loop, self._faults, self._clock = transport.loop, transport.faults, transport.clock
        self._receiver = receiver
        self._connections: list[_Incoming] = []
        self._buffer = memoryview(bytearray(_AT_ONCE))
        self._looked = self._clock()
        self._period = GATHER_S
        self._closed = False
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.settimeout(0.0)
        self._listener.bind("\0" + self.address.removeprefix("ipc://@"))
        self._listener.listen(CONNECTING)
        self._loop.watch(self._listener.fileno(), self._accept)
        self._timer = self._loop.alarm(self.take_now)
        self._timer.due = self._looked + GATHER_S

    def take_now(self) -> None:
        """Read all messages."""
        now = self._clock()
        since, self._looked = self._looked, now
        self._receiver.begin(since, now)
        fullest = 0
        try:
            for each in tuple(self._connections):
                if each.stream.ready:
                    fullest = max(fullest, self._read(each))
                elif now - each.opened > _GREETING_S:
                    self._drop(each, "a connection does not say READY")
        finally:
            self._receiver.end()
            self._plan(now, fullest)

    def _plan(self, now: float, fullest: int) -> None:
        """Look again soon if a publisher had no room left: it keeps more, and can send it now."""
        if fullest > 0.9 * _ROOM:
            self._period = _SHORTEST_S
        else:
            self._period = min(GATHER_S, self._period * 2)
        self._timer.due = now + self._period

    def close(self) -> None:
        """Close; messages in it are dropped."""
        if self._closed:
            return
        self._closed = True
        self._timer.cancel()
        self._loop.unwatch(self._listener.fileno())
        self._listener.close()
        for each in tuple(self._connections):
            self._end(each)

    def _accept(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while True:
                link, _ = self._listener.accept()
                self._greet(link)

    def _greet(self, link: socket.socket) -> None:
        """Begin a connection of this user; all others end."""
        if file_descriptors.peer_of(link)[1] != os.getuid():
            link.close()
            return
        link.settimeout(0.0)
        connection = _Incoming(link, self._clock())
        self._connections.append(connection)
        self._loop.watch(link.fileno(), functools.partial(self._shake_hands, connection))
        self._send(connection, zmtp.GREETING + zmtp.READY)

    def _shake_hands(self, connection: _Incoming) -> None:
        """Read until the connection is ready; from then on it waits for the next look."""
        self._receiver.begin(self._looked, self._clock())
        try:
            self._read(connection)
        finally:
            self._receiver.end()
        if connection.stream.ready:
            self._unwatch(connection)

    def _read(self, connection: _Incoming) -> int:
        """Read what a connection has; how much room that took in the system [bytes]."""
        taken = 0
        try:
            for _ in range(_MOST_AT_ONCE):
                was_ready = connection.stream.ready
                count = connection.link.recv_into(self._buffer)
                data, places = connection.stream.feed(bytes(self._buffer[:count]))
                taken += len(places) // 2 * _EACH + count * _SHARE
                if places:
                    self._receiver.take(data, places)
                if answer := connection.stream.answer():
                    self._send(connection, answer)
                if not count:
                    self._end(connection)
                    break
                if count < _AT_ONCE or not was_ready:
                    break  # that was all; what follows, also an end, waits for the next look
        except BlockingIOError:
            pass
        except FrameError as error:
            self._drop(connection, str(error))
        except OSError:
            self._end(connection)
        return taken

    def _send(self, connection: _Incoming, data: bytes) -> None:
        with contextlib.suppress(OSError):  # what follows shows that it ended
            connection.link.send(data)

    def _drop(self, connection: _Incoming, why: str) -> None:
        self._faults.count("bad handshake", why)
        self._end(connection)

    def _end(self, connection: _Incoming) -> None:
        self._unwatch(connection)
        self._connections.remove(connection)
        connection.link.close()

    def _unwatch(self, connection: _Incoming) -> None:
        if connection.watched:
            connection.watched = False
            self._loop.unwatch(connection.link.fileno())
