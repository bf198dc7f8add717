"""Hands each control message to the part of central that handles it. No sockets.

Each call takes an event and returns the control messages to send. A new control message is a row
in one of the two tables of `Registry`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hub.errors import NotAllowedError
from hub.ipc.broker.broadcasts import Broadcasts
from hub.ipc.broker.connections import Connections
from hub.ipc.broker.definitions import Definitions
from hub.ipc.broker.listing import Listings, set_log_level
from hub.ipc.broker.message_users import MessageUsers
from hub.ipc.broker.peers import Caller, Outgoing, Peer, Peers
from hub.ipc.broker.presence import PresenceReports
from hub.ipc.broker.queries import Queries
from hub.ipc.formats.codegen import Buffer
from hub.ipc.roles import Principal
from hub.ipc.security import permissions
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control, frames
from hub.ipc.wire.control import Change

_Action = Callable[[Peer, Any], list[Outgoing]]
_FrameAction = Callable[[Peer, Any, Buffer | None], list[Outgoing]]


class Registry:
    """The state and the decisions of one central."""

    def __init__(
        self,
        *,
        clock: Callable[[], float],
        faults: FaultCounter,
        reserved: frozenset[str] = frozenset(),
        key: str = "",
        forwarder: str = "",
    ) -> None:
        """Start without peers.

        Args:
            clock: Monotonic time [s].
            faults: Counts what is refused.
            reserved: Names of this robot's modules, beside `ROBOT_NAMES`.
            key: Of the tickets that clients show to central.
            forwarder: The client of this process that forwards messages of others; empty: none.
        """
        self._clock = clock
        self._faults = faults
        self.peers = Peers()
        presence = PresenceReports(self.peers)
        self._connections = Connections(
            self.peers,
            presence,
            self._forget,
            reserved=reserved,
            key=key,
            forwarder=forwarder,
            clock=clock,
            faults=faults,
        )
        self._definitions = Definitions(presence, faults)
        self.broadcasts = Broadcasts(self._definitions, presence, faults)
        handlers = MessageUsers(
            Change.HANDLERS, lambda peer: peer.handles, self._definitions, presence, faults
        )
        self.queries = Queries(
            self.peers, handlers, self.broadcasts.publishers, clock=clock, faults=faults
        )
        listings = Listings(self.peers, self._definitions, presence, clock=clock, faults=faults)
        self._actions: dict[type, _Action] = {
            control.Define: self._definitions.define,
            control.Advertise: self.broadcasts.advertise,
            control.Subscribe: self.broadcasts.subscribe,
            control.Unsubscribe: self.broadcasts.unsubscribe,
            control.Ready: self.broadcasts.ready,
            control.Handle: self.queries.handle,
            control.List: listings.answer,
            control.Watch: presence.watch,
            control.Report: self._report,
            control.Close: self._connections.close,
            control.LogLevel: set_log_level,
            control.Ping: self._connections.ping,
            control.Bye: self._connections.bye,
        }
        self._frame_actions: dict[type, _FrameAction] = {
            control.Query: self.queries.ask,
            control.Last: self.queries.ask,
            control.Response: self.queries.answer,
            control.Failure: self.queries.answer,
        }

    @property
    def epoch(self) -> int:
        """A number of this run of central."""
        return self._connections.epoch

    def connected(self) -> tuple[str, ...]:
        """Names of the peers; any thread may ask."""
        return self.peers.names()

    def peer_of(self, publisher: int) -> Peer | None:
        """The peer of this number in frame headers, None if there is none; any thread may ask."""
        return self.peers.numbered(publisher)

    def handle(self, caller: Caller, message: Any, attached: Buffer | None) -> list[Outgoing]:
        """Handle a control message."""
        if isinstance(message, control.Hello):
            return self._connections.hello(caller, message)
        peer = self.peers.of(caller.identity)
        if peer is None:
            return [Outgoing(identity=caller.identity, message=control.UnknownPeer())]
        peer.last_message = self._clock()
        kind = type(message)
        action, frame_action = self._actions.get(kind), self._frame_actions.get(kind)
        if action is None and frame_action is None:
            self._faults.count("unexpected control message", f"{kind.__name__} from {peer.name}")
            return []
        try:
            permissions.check(peer.principal, peer.name, message, self._definitions.plane_of)
        except NotAllowedError as error:
            self._faults.count("not allowed", f"{peer.name}: {error}")
            refusal = permissions.refusal(message, str(error))
            return [Outgoing(identity=peer.identity, message=refusal)] if refusal else []
        if frame_action is not None:
            return frame_action(peer, message, attached)
        return action(peer, message) if action is not None else []

    def broadcast(self, frame: frames.Frame) -> bool:
        """Check a broadcast, and count its faults; whether it has none."""
        definition = self._definitions.get(frame.name)
        if definition is None:
            self._faults.count("undefined message", f"{frame.name} is not defined")
        elif definition.fingerprint != frame.fingerprint:
            self._faults.count("wrong format", f"{frame.name} came in another format")
        else:
            return True
        return False

    def descriptors_of(self, principal: Principal) -> list[int]:
        """The control connections of this key."""
        return [peer.descriptor for peer in self.peers if peer.principal == principal]

    def has_connection(self, descriptor: int) -> bool:
        """Whether a peer has this control connection."""
        return any(peer.descriptor == descriptor for peer in self.peers)

    def disconnected(self, descriptor: int) -> list[Outgoing]:
        """Drop the peer whose control connection ended."""
        return self._connections.disconnected(descriptor)

    def unreachable(self, identity: bytes) -> list[Outgoing]:
        """Drop a peer that a message could not reach."""
        return self._connections.unreachable(identity)

    def expire(self) -> list[Outgoing]:
        """Drop silent peers and forget old queries; call it about ten times a second."""
        outgoing = self._connections.expire()
        self.queries.expire()
        return outgoing

    def _report(self, peer: Peer, message: control.Report) -> list[Outgoing]:
        self._definitions.report(peer, message, self._clock())
        return []

    def _forget(self, peer: Peer) -> list[Outgoing]:
        """End all uses of a peer that is gone."""
        # First the publishers: one that is gone has no last value.
        return self.broadcasts.drop(peer) + self.queries.drop(peer)
