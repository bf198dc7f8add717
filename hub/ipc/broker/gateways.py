"""The interface between central and a gateway. Gateways are in `hub/gateways/`.

Central opens each gateway at its start. In its own thread it serves the gateway's polled sockets
and reads control messages at its entrances; at its end it closes the gateway. A gateway forwards
broadcasts to and from the planes in threads of its own; `CentralAccess` has the addresses.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import zmq

from hub.ipc.broker.peers import Peer
from hub.ipc.broker.zap import ZapHandler
from hub.ipc.definition import Plane
from hub.ipc.roles import Principal
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.values import dataclass


class EntranceGuard(Protocol):
    """Decides about control messages that come from other machines."""

    def principal_of(self, frame: zmq.Frame) -> Principal:
        """The key of the connection that a frame came on.

        Raises:
            NotAllowedError: It has no valid key.
        """

    def admits(self, principal: Principal, identity: bytes, body: Sequence[zmq.Frame]) -> bool:
        """Whether central serves a control message.

        Args:
            principal: Holder of the connection's key.
            identity: Of its connection.
            body: Its parts.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEntrance:
    """A socket where control messages come in.

    Attributes:
        router: The socket (ROUTER).
        ports: TCP ports of each plane in turn, in and out, for clients of this entrance.
        paths: ipc:// paths of the same.
        guard: Decides about each message; None at the entrance for this machine.
    """

    router: sockets.Socket
    ports: tuple[int, ...]
    paths: tuple[str, ...] = ("",) * (2 * len(sockets.PLANES))
    guard: EntranceGuard | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CentralAccess:
    """The parts of central that a gateway may use.

    Attributes:
        context: Central's. Its second I/O thread is for gateways.
        planes: The inproc addresses of each plane: in, and out.
        peer_of: The peer of a number in frame headers; any thread may ask.
        has_connection: Whether a peer has the control connection of this descriptor.
        descriptors_of: The control connections of this key.
        disconnected: Reports the end of the control connection of this descriptor.
        send: Sends a control message to the connection of this identity.
        faults: Counts what is refused.
        clock: Monotonic time [s].
        zap: Answers handshakes; a gateway names the judge of its domains.
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
    zap: ZapHandler


class Gateway(Protocol):
    """An entrance for other machines. Central's thread calls every method.

    Attributes:
        endpoint: Address for clients, for people.
        entrances: Its sockets for control messages; may be empty.
        polled: Sockets that central polls for input; then it calls `serve`.
    """

    endpoint: str
    entrances: Sequence[ControlEntrance]
    polled: Sequence[sockets.Socket]

    def serve(self, polled: sockets.Socket) -> None:
        """Read one of the polled sockets, without waiting."""

    def report_ended(self) -> None:
        """Report all control connections that have ended."""

    def check(self) -> None:
        """Detect floods and removed keys; called about ten times a second."""

    def close(self) -> None:
        """Free all resources, after the end of central's thread."""


GatewayOpener = Callable[[CentralAccess], Gateway]
"""Opens a gateway; raises EndpointError or KeyFileError."""
