"""A reserve of file descriptors: if too few are left, central refuses new connections.

A process without a free descriptor can neither accept nor refuse a waiting connection. ZeroMQ
(4.3.5) then retries without a pause and occupies a processor; at an ipc:// address it ends the
process. To unbind is no remedy, because that ends all connections of the address.
"""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import sys

from hub.ipc.transport.fault_counter import FaultCounter

with contextlib.suppress(ImportError):  # Windows has no such limits
    import resource

WANTED = 16_384
"""Number of descriptors that central asks the system for."""
LOCAL, BEYOND = 1 / 2, 3 / 8
"""Largest used part of the descriptors at which central accepts a connection from this machine, or
from another one. ZeroMQ's thread accepts connections before central can refuse one. It may be ahead
by the 1000 events that each of the seven sockets queues at each end. With `WANTED` descriptors,
half of them has room for most of that."""

_ANY = socket.AF_INET6
"""Has room for an address of each family; a call for the family would double the time."""
_PEER = struct.Struct("3i")
_OWN_ADDRESS = "127.0.0.1"
_TCP_INFO = 11
_TCP_INFO_SIZE, _RECEIVED_AT, _RECEIVED = 192, 128, struct.Struct("=Q")
"""Size of tcp_info of Linux (tcp(7)), and place of tcpi_bytes_received in it."""


def allow_many() -> None:
    """Raise this process's limit to `WANTED` descriptors, or as far as the system allows."""
    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = WANTED if most == resource.RLIM_INFINITY else min(WANTED, most)
    if now != resource.RLIM_INFINITY and now < wanted:
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))


def hang_up(descriptor: int) -> None:
    """End a connection; ZeroMQ closes it.

    Only its input ends. An end of both directions would signal ZeroMQ even while the
    connection's queue is full, which it does not expect.
    """
    with contextlib.suppress(OSError):  # it has ended by itself
        connection = socket.socket(_ANY, socket.SOCK_STREAM, fileno=descriptor)
        try:
            connection.shutdown(socket.SHUT_RD)
        finally:
            connection.detach()


def ends_of(descriptor: int) -> tuple[int, str] | None:
    """The TCP port here and the address there of a connection; None: it has ended."""
    with contextlib.suppress(OSError):
        connection = socket.socket(_ANY, socket.SOCK_STREAM, fileno=descriptor)
        try:
            here, there = connection.getsockname(), connection.getpeername()
        finally:
            connection.detach()
        if isinstance(here, tuple) and isinstance(there, tuple):  # else it is no TCP
            return int(here[1]), str(there[0])
    return None


def relayed(descriptor: int) -> bool:
    """Whether a connection comes from another loopback address than 127.0.0.1.

    Clients of this machine connect from 127.0.0.1. A relay for them connects from the address at
    which it listens, so that nothing goes past it.
    """
    ends = ends_of(descriptor) if descriptor >= 0 else None
    there = ends[1].removeprefix("::ffff:") if ends is not None else ""
    return there.startswith("127.") and there != _OWN_ADDRESS


def peer_of(connection: socket.socket) -> tuple[int, int]:
    """Process and user at the other end of a Unix socket, by SO_PEERCRED; only Linux has that.

    Raises:
        OSError: The connection has ended.
    """
    raw = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _PEER.size)
    process, user, _ = _PEER.unpack(raw)
    return process, user


def is_from_this_process(descriptor: int) -> bool:
    """Whether a connection at a Unix socket may come from this process: only Linux shows it."""
    if sys.platform != "linux":
        return True
    with contextlib.suppress(OSError, struct.error):  # it has ended by itself
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM, fileno=descriptor)
        try:
            return peer_of(connection)[0] == os.getpid()
        finally:
            connection.detach()
    return False


def received(descriptor: int) -> int:
    """Received bytes of a TCP connection; 0: the system does not report them."""
    with contextlib.suppress(OSError, struct.error):  # it has ended by itself
        connection = socket.socket(_ANY, socket.SOCK_STREAM, fileno=descriptor)
        try:
            known = connection.getsockopt(socket.IPPROTO_TCP, _TCP_INFO, _TCP_INFO_SIZE)
            return int(_RECEIVED.unpack_from(known, _RECEIVED_AT)[0])
        finally:
            connection.detach()
    return 0


class Reserve:
    """Refuses connections to keep some of this process's descriptors free."""

    def __init__(self, faults: FaultCounter, *, part: float = LOCAL) -> None:
        """Watch the connections that `admit` gets.

        Args:
            faults: Counts refused connections.
            part: The part of the descriptors that may be in use, from 0 to 1.
        """
        self._faults = faults
        self._part = part

    def admit(self, descriptor: int, where: str) -> None:
        """Check an accepted connection: end it if it has one of the last descriptors.

        The system gives the lowest free number, so a high one shows that all below are in use.
        If the connection has ended meanwhile, another file with one of the last numbers ends.

        Args:
            descriptor: Of the connection; ZeroMQ closes it.
            where: The socket that accepted it, for the log.
        """
        most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        if most == resource.RLIM_INFINITY or descriptor < most * self._part:
            return
        self._faults.count(
            "too many connections",
            f"one on {where} is turned away, as this process may have {most} descriptors; "
            "raise that limit (ulimit -n), or end the programs that connect so often",
        )
        hang_up(descriptor)
