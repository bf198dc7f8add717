"""What central and a gateway are to each other. Gateways are in `hub/gateways/`.

Central knows this interface only. It opens each gateway at its start, serves what the gateway
polls in its own thread, takes control messages at the gateway's entrances, and closes it at last.

A gateway is free in how it reaches other machines. It brings broadcasts to and from the planes in
threads of its own; `CentralAccess` says where they are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import zmq

from hub.ipc.broker.peers import Peer
from hub.ipc.definition import Plane
from hub.ipc.roles import Principal
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter


class EntranceGuard(Protocol):
    """Decides about control messages that come from other machines."""

    def principal_of(self, frame: zmq.Frame) -> Principal:
        """The key of the connection on which a frame came.

        Raises:
            NotAllowedError: It has none that counts.
        """

    def admits(self, principal: Principal, identity: bytes, body: Sequence[zmq.Frame]) -> bool:
        """Whether central serves a control message.

        Args:
            principal: Whose key it came with.
            identity: Of its connection.
            body: Its parts.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEntrance:
    """A socket where control messages come in.

    Attributes:
        router: The socket (ROUTER).
        ports: TCP ports of each plane in turn, in and out, for clients that use this entrance.
        paths: ipc:// paths of the same.
        guard: Decides about each message; None at the entrance for this machine.
    """

    router: sockets.Socket
    ports: tuple[int, ...]
    paths: tuple[str, ...] = ("",) * (2 * len(sockets.PLANES))
    guard: EntranceGuard | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CentralAccess:
    """What a gateway may use of central.

    Attributes:
        context: Central's. Its second I/O thread is for gateways.
        planes: The inproc addresses of each plane: where messages go in, and where they come out.
        peer_of: The peer of a number in frame headers; any thread may ask.
        has_connection: Whether the control connection of this descriptor is that of a peer.
        descriptors_of: The control connections that were made with this key.
        disconnected: The control connection of this descriptor has ended.
        send: Sends a control message to the connection of this identity.
        faults: Counts what is refused.
        clock: Monotonic time [s].
    """

    context: sockets.Context
    planes: Mapping[Plane, tuple[str, str]]
    peer_of: Callable[[int], Peer | None]
    has_connection: Callable[[int], bool]
    descriptors_of: Callable[[Principal], list[int]]
    disconnected: Callable[[int], None]
    send: Callable[[bytes, Any], None]
    faults: FaultCounter
    clock: Callable[[], float]


class Gateway(Protocol):
    """A way in for others than clients of this machine. Central's thread calls all of it.

    Attributes:
        endpoint: Where clients connect, for people.
        entrances: Where its control messages come in; may be empty.
        polled: Sockets to be polled for input; then `serve` is called.
    """

    endpoint: str
    entrances: Sequence[ControlEntrance]
    polled: Sequence[sockets.Socket]

    def serve(self, polled: sockets.Socket) -> None:
        """Read one of the polled sockets, without waiting."""

    def see_ended(self) -> None:
        """Report all control connections that ended up to now."""

    def check(self) -> None:
        """Look for what no socket shows, such as floods; called ten times a second or so."""

    def close(self) -> None:
        """Free everything; called when central's thread has ended."""


GatewayOpener = Callable[[CentralAccess], Gateway]
"""Opens a gateway; raises EndpointError or KeyFileError."""
