"""A TCP connection to a bridge, perhaps with TLS, that never waits.

The bridge's system often leaves Nagle's algorithm on: then it holds back the end of a picture until
its beginning is acknowledged. So Linux is asked to acknowledge at once, before each read, since it
forgets that.
"""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import ssl
import struct
import sys
from collections.abc import Callable
from typing import Final

from hub.robots.host_lookup import HostLookup
from hub.robots.interfaces import FileLoop
from hub.robots.ros.address import RosAddress

_AT_ONCE: Final = 1 << 14
"""Most bytes of one call of the system; it limits the time for a flood of empty messages."""
_SIOCOUTQNSD: Final = 0x894B
"""Asks Linux for the bytes of a connection that it could not send yet."""
_RESET: Final = struct.pack("ii", 1, 0)
"""SO_LINGER: what waits is dropped at the close."""
_WAITS: Final = (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError)


class ByteStream:
    """One connection after another; used by one thread.

    Attributes:
        joined: Whether bytes can pass.
        drained: Whether the last `receive` read all that had come.
    """

    def __init__(self, address: RosAddress) -> None:
        """Take the address; nothing is opened yet."""
        self.joined = False
        self.drained = True
        self._address = address
        self._lookup = HostLookup(address.host, address.port, socket.SOCK_STREAM)
        self._attempts = 0
        self._tls: ssl.SSLContext | None = None
        self._socket: socket.socket | None = None
        self._connected = False
        self._watch: tuple[FileLoop, Callable[[], None]] | None = None
        self._watched = -1

    @property
    def is_open(self) -> bool:
        """Whether it is connected, or begins to be."""
        return self._socket is not None

    @property
    def addresses(self) -> int:
        """How many addresses the host has; each `open` takes the next one."""
        return self._lookup.number

    @property
    def unsent(self) -> int:
        """Bytes that the system could not send yet; 0 where it does not say that."""
        if self._socket is None or sys.platform != "linux":
            return 0
        import fcntl

        answer = fcntl.ioctl(self._socket.fileno(), _SIOCOUTQNSD, b"\0\0\0\0")
        return int.from_bytes(answer, sys.byteorder)

    def open(self) -> None:
        """Begin to connect to the next of the host's addresses.

        Raises:
            OSError: That fails, or the name is still being looked up.
        """
        family, address = self._lookup.address(self._attempts)
        self._attempts += 1
        self._socket = socket.socket(family, socket.SOCK_STREAM)
        self._socket.settimeout(0.0)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with contextlib.suppress(BlockingIOError):
            self._socket.connect(address)

    def join(self) -> None:
        """Go on to connect.

        Raises:
            OSError: It fails.
        """
        if self._socket is not None and not self._connected:
            self._connect(self._socket)
        if self._connected and isinstance(self._socket, ssl.SSLSocket):
            with contextlib.suppress(*_WAITS):
                self._socket.do_handshake()
                self.joined = True
        else:
            self.joined = self._connected

    def _connect(self, connecting: socket.socket) -> None:
        """Go on if the system has the connection."""
        number = connecting.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if number:
            raise OSError(number, os.strerror(number))
        try:
            connecting.getpeername()
        except OSError:  # not yet
            return
        if self._address.secure:
            if self._tls is None:
                self._tls = ssl.create_default_context()
            self._socket = self._tls.wrap_socket(
                connecting, server_hostname=self._address.host, do_handshake_on_connect=False
            )
        self._connected = True
        self._begin_watch()

    def receive(self) -> bytes:
        """The bytes that came, some of them; empty: there are none now.

        Raises:
            OSError: The connection has ended.
        """
        self.drained = True
        if self._socket is None:
            return b""
        try:
            if hasattr(socket, "TCP_QUICKACK"):
                self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
            data = self._socket.recv(_AT_ONCE)
        except _WAITS:
            return b""
        if not data:
            raise ConnectionResetError(errno.ECONNRESET, "the bridge ended the connection")
        self.drained = len(data) < _AT_ONCE and not self._address.secure
        return data

    def send(self, waiting: bytearray) -> None:
        """Send what leaves now, and remove it.

        Raises:
            OSError: The connection has ended.
        """
        if self._socket is not None:
            with contextlib.suppress(*_WAITS):
                while waiting:
                    del waiting[: self._socket.send(waiting)]

    def shut(self, *, reset: bool) -> None:
        """Close it.

        Args:
            reset: Whether what the system has not sent yet is dropped.
        """
        self._unwatch()
        if self._socket is not None:
            if reset:
                with contextlib.suppress(OSError):
                    self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
            self._socket.close()
        self._socket = None
        self.joined = self._connected = False

    def watch(self, loop: FileLoop, work: Callable[[], None]) -> None:
        """Have a loop call `work` whenever there is something to read."""
        self._unwatch()
        self._watch = (loop, work)
        if self._connected:
            self._begin_watch()

    def _begin_watch(self) -> None:
        if self._watch is not None and self._socket is not None:
            loop, work = self._watch
            self._watched = self._socket.fileno()
            loop.watch(self._watched, work)

    def _unwatch(self) -> None:
        if self._watch is not None and self._watched >= 0:
            file, self._watched = self._watched, -1
            self._watch[0].unwatch(file)
