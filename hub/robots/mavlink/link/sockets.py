"""Links over UDP and TCP."""

from __future__ import annotations

import contextlib
import errno
import socket
from typing import Any, Final

from hub.robots.host_lookup import HostLookup
from hub.robots.mavlink.link.byte_link import AT_ONCE, ByteLink

_UNANSWERED_MS: Final = 3000
"""Time without an answer after which the system ends a connection [ms]."""
_CONNECTING_S: Final = 5.0
"""Longest time of a connection attempt [s]."""
_OTHER_SENDER_S: Final = 3.0
"""After this silence another sender takes the place of a vehicle that sent first [s]."""
_OTHER_PORT_S: Final = 1.2
"""The same for another port of its host: a vehicle that was started again has one [s]."""

_BIND_FAULTS: Final = {
    errno.EADDRINUSE: "another program of this machine, such as a hub or a ground station, listens "
    "at this port; end it, or give another port",
    errno.EADDRNOTAVAIL: "this machine has no such address",
}


class UdpLink(ByteLink):
    """Datagrams: to a vehicle, or to the one that sent first."""

    datagrams = True

    def __init__(self, host: str, port: int, *, listen: bool) -> None:
        """Take the vehicle's address, or the own one to listen at; nothing is opened yet."""
        super().__init__()
        self._lookup = HostLookup(host, port, socket.SOCK_DGRAM)
        self._listen = listen
        self._socket: socket.socket | None = None
        self._peer: Any = None
        self._last: Any = None
        self._heard_at = 0.0

    @property
    def port(self) -> int:
        """The own port; 0: the link is closed."""
        return int(self._socket.getsockname()[1]) if self._socket is not None else 0

    def _open(self) -> None:
        family, address = self._lookup.address()
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.settimeout(0.0)
        self._peer = None
        if self._listen:
            try:
                self._socket.bind(address)
            except OSError as fault:
                raise OSError(
                    fault.errno, _BIND_FAULTS.get(fault.errno or 0, str(fault))
                ) from fault
        else:
            self._peer = address

    def _receive(self) -> bytes:
        if self._socket is None:
            raise BlockingIOError
        while True:
            data, sender = self._socket.recvfrom(AT_ONCE)
            if self._listen and self._may_begin(sender[0]):
                self._peer, self.peers = sender, self.peers + (sender != self._last)
                self._last = sender
            if sender[0] == self._peer[0] and (not self._listen or sender == self._peer):
                self._heard_at = self._now
                return data
            self._unheard, self._unheard_at = f"{sender[0]}:{sender[1]}", self._now

    def _may_begin(self, host: str) -> bool:
        """Whether a sender at a host may take the place of the one before."""
        if self._peer is None:
            return True
        silence = _OTHER_PORT_S if host == self._peer[0] else _OTHER_SENDER_S
        return self._now - self._heard_at > silence

    def _send(self, data: bytes) -> int:
        if self._socket is None or self._peer is None:
            return 0
        return self._socket.sendto(data, self._peer)

    def _file(self) -> int:
        return self._socket.fileno() if self._socket is not None else -1

    def _shut(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class TcpLink(ByteLink):
    """A connection to a vehicle."""

    def __init__(self, host: str, port: int) -> None:
        """Take its address; nothing is opened yet."""
        super().__init__()
        self._lookup = HostLookup(host, port, socket.SOCK_STREAM)
        self._socket: socket.socket | None = None
        self._begun = 0.0
        self._connected = False

    def _open(self) -> None:
        family, address = self._lookup.address()
        self._socket = socket.socket(family, socket.SOCK_STREAM)
        self._socket.settimeout(0.0)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _UNANSWERED_MS)
        self._begun, self._connected = self._now, False
        with contextlib.suppress(BlockingIOError):
            self._socket.connect(address)

    def _receive(self) -> bytes:
        if self._socket is None:
            raise BlockingIOError
        try:
            data = self._socket.recv(AT_ONCE)
        except OSError as fault:
            waits = isinstance(fault, BlockingIOError) or fault.errno == errno.ENOTCONN
            if waits and not self._connected and not self._is_connected():
                if self._now - self._begun > _CONNECTING_S:
                    raise TimeoutError(errno.ETIMEDOUT, "it does not answer") from fault
                raise BlockingIOError from fault
            raise
        if not data:
            raise ConnectionResetError(errno.ECONNRESET, "the vehicle ended the connection")
        self._connected = True
        return data

    def _is_connected(self) -> bool:
        if self._socket is not None and not self._connected:
            with contextlib.suppress(OSError):
                self._socket.getpeername()
                self._connected = True
        return self._connected

    def _send(self, data: bytes) -> int:
        if self._socket is None or not self._is_connected():
            return 0
        return self._socket.send(data)

    def _file(self) -> int:
        return self._socket.fileno() if self._socket is not None else -1

    def _shut(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None
