"""Descriptors that central keeps free: when too few are left, new connections are turned away.

A process without a free descriptor can neither take the connections that wait for it nor refuse
them. ZeroMQ (4.3.5) then tries again without a pause and takes a processor for itself; at an ipc://
address it ends the process. To unbind is no way out, as that ends all connections made there.
"""

from __future__ import annotations

import contextlib
import socket
import struct

from hub.ipc.transport.fault_counter import FaultCounter

with contextlib.suppress(ImportError):  # Windows has no such limits
    import resource

WANTED = 16_384
"""How many descriptors central asks the system for."""
LOCAL, BEYOND = 1 / 2, 3 / 8
"""The part of the descriptors that may be in use when a connection from this machine, or from
another one, is taken. ZeroMQ's thread takes waiting connections before central can turn one away.
It may be ahead by the 1000 events that each of the seven sockets queues at each end. With `WANTED`
descriptors, half of them has room for most of that."""

_ANY = socket.AF_INET6
"""Has room for an address of each family; to ask for the family takes as long as all else."""
_TCP_INFO = 11
_TCP_INFO_SIZE, _RECEIVED_AT, _RECEIVED = 192, 128, struct.Struct("=Q")
"""tcp_info of Linux (tcp(7)) and where tcpi_bytes_received stands in it."""


def allow_many() -> None:
    """Raise this process's limit to `WANTED` descriptors, or to what the system gives."""
    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = WANTED if most == resource.RLIM_INFINITY else min(WANTED, most)
    if now != resource.RLIM_INFINITY and now < wanted:
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))


def hang_up(descriptor: int) -> None:
    """End a connection that stays ZeroMQ's to close.

    Only what comes in is ended: if both ways were, the system would signal ZeroMQ even while
    the connection's queue is full, which it does not expect.
    """
    with contextlib.suppress(OSError):  # it has gone by itself
        connection = socket.socket(_ANY, socket.SOCK_STREAM, fileno=descriptor)
        try:
            connection.shutdown(socket.SHUT_RD)
        finally:
            connection.detach()


def ends_of(descriptor: int) -> tuple[int, str] | None:
    """The TCP port here and the address there of a connection; None if it is none any more."""
    with contextlib.suppress(OSError):
        connection = socket.socket(_ANY, socket.SOCK_STREAM, fileno=descriptor)
        try:
            here, there = connection.getsockname(), connection.getpeername()
        finally:
            connection.detach()
        if isinstance(here, tuple) and isinstance(there, tuple):  # else it is no TCP
            return int(here[1]), str(there[0])
    return None


def received(descriptor: int) -> int:
    """Bytes that have come in on a TCP connection since it was made; 0 if the system cannot say."""
    with contextlib.suppress(OSError, struct.error):  # it has gone by itself
        connection = socket.socket(_ANY, socket.SOCK_STREAM, fileno=descriptor)
        try:
            known = connection.getsockopt(socket.IPPROTO_TCP, _TCP_INFO, _TCP_INFO_SIZE)
            return int(_RECEIVED.unpack_from(known, _RECEIVED_AT)[0])
        finally:
            connection.detach()
    return 0


class Reserve:
    """Keeps some of this process's descriptors free."""

    def __init__(self, faults: FaultCounter, *, part: float = LOCAL) -> None:
        """Watch the connections that `admit` gets.

        Args:
            faults: Where those turned away are counted.
            part: The part of the descriptors that may be in use, from 0 to 1.
        """
        self._faults = faults
        self._part = part

    def admit(self, descriptor: int, where: str) -> None:
        """A connection was accepted; it is ended at once if it has one of the last descriptors.

        The system gives the lowest free number, so a high one shows that those below are in use.
        Should the connection have gone meanwhile, whatever has its number now has one of the last
        as well.

        Args:
            descriptor: Of the connection, which stays ZeroMQ's to close.
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
