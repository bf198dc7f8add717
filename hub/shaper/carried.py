"""One TCP connection through a link shaper: its two sockets, and what waits to be written there."""

from __future__ import annotations

import collections
import contextlib
import enum
import errno
import os
import socket
from typing import TypeAlias

WINDOW = 256 * 1024
"""Largest content of a connection in one direction of the link, as a TCP window [bytes].

A profile with a larger queue has a window of that size.
"""
SEGMENT = 1448
"""Largest segment of TCP, without headers [bytes]."""
_SMALL_BUFFER = 16_384


class Mark(enum.Enum):
    """What a connection carries besides data.

    Attributes:
        OPEN: Its begin, and the answer to that.
        END: The end of the data in one direction.
        RESET: Its end in both directions.
    """

    OPEN = enum.auto()
    END = enum.auto()
    RESET = enum.auto()


Content: TypeAlias = bytes | Mark


class LinkEnd:
    """One of the two sockets; it never waits.

    Attributes:
        socket: The socket.
        connecting: Whether its connection is begun and not yet made.
        open: Whether its data may be read: the connection is made through the link.
        ended: Whether all its data were read.
        broken: Whether it is closed already, because its connection broke.
        events: What the selector waits for.
        held: Content from here that did not leave the other end yet [bytes].
        served: When it was read last [s].
    """

    def __init__(self, own: socket.socket, window: int, *, connecting: bool = False) -> None:
        """Take over a socket.

        Args:
            own: The socket.
            window: Largest content from here in the link [bytes].
            connecting: Whether its connection is begun and not yet made.
        """
        own.settimeout(0.0)
        with contextlib.suppress(OSError):  # it may have ended already
            own.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket, self._window = own, window
        self.connecting = connecting
        self.open = self.ended = self.broken = False
        self.events = 0
        self.held = 0
        self.served = 0.0
        self._waiting: collections.deque[bytes] = collections.deque()
        self._ending = False

    @property
    def writes(self) -> bool:
        """Whether it waits until it can write, or is connected."""
        return self.connecting or bool(self._waiting)

    @property
    def reads(self) -> bool:
        """Whether its data may enter the link."""
        return self.open and not self.ended and self.held < self._window

    @property
    def finished(self) -> bool:
        """Whether all its data were read, and all were written that it gets."""
        return self.ended and self._ending and not self._waiting

    def read(self, most: int) -> bytes | None:
        """Up to `most` bytes; empty: its data end; None: there are none now.

        Raises:
            OSError: The connection broke.
        """
        try:
            data = self.socket.recv(most)
        except BlockingIOError:
            return None
        self.ended = not data
        return data

    def write(self, data: bytes = b"") -> int:
        """Write these bytes and those that wait, as far as there is room.

        Returns:
            How many bytes were written.

        Raises:
            OSError: The connection broke.
        """
        if data:
            self._waiting.append(data)
        written = 0
        with contextlib.suppress(BlockingIOError):
            while self._waiting:
                first = self._waiting.popleft()
                try:
                    count = self.socket.send(first)
                except BlockingIOError:
                    self._waiting.appendleft(first)
                    raise
                written += count
                if count < len(first):
                    self._waiting.appendleft(first[count:])
        if self._ending and not self._waiting:
            self.socket.shutdown(socket.SHUT_WR)
        return written

    def end_writing(self) -> None:
        """End its data after those that wait.

        Raises:
            OSError: The connection broke.
        """
        self._ending = True
        self.write()

    def failure(self) -> int:
        """The error of a connection that was begun; 0: it is made."""
        return self.socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)


class Carried:
    """A connection.

    Attributes:
        near: The socket to the client.
        far: The socket to the hub; None: it is not opened yet.
        place: The place of its port in the hub's row.
    """

    def __init__(self, near: LinkEnd, place: int) -> None:
        self.near = near
        self.far: LinkEnd | None = None
        self.place = place

    @property
    def ends(self) -> tuple[LinkEnd, ...]:
        """Its sockets."""
        return (self.near,) if self.far is None else (self.near, self.far)


def make_small(own: socket.socket) -> None:
    """Give a socket that listens, or will connect, a small buffer: a full link slows senders soon.

    Segments are as on Ethernet. Those of the loopback have 64 KiB. Then a sender would wait for
    room that a small buffer never has, and go on by a timer only.
    """
    own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _SMALL_BUFFER)
    with contextlib.suppress(OSError):  # macOS has no such option before the connection
        own.setsockopt(socket.IPPROTO_TCP, socket.TCP_MAXSEG, SEGMENT)


def begin_connection(address: tuple[str, int], source: str, *, small: bool) -> socket.socket:
    """A socket whose connection to the hub is begun.

    Args:
        address: Of the hub.
        small: Whether its buffer is small.
        source: Address of this machine to connect from; empty: the usual one.

    Raises:
        OSError: There is no way there.
    """
    made = socket.socket(socket.AF_INET6 if ":" in address[0] else socket.AF_INET)
    made.settimeout(0.0)
    try:
        if small:
            make_small(made)
        if source:
            made.bind((source, 0))
        code = made.connect_ex(address)
        if code not in (0, errno.EINPROGRESS, errno.EWOULDBLOCK):
            raise OSError(code, os.strerror(code))
    except OSError:
        made.close()
        raise
    return made
