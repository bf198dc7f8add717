"""Queries at central: HANDLE, QUERY, LAST, RESPONSE and FAILURE."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hub.errors import FrameError
from hub.ipc.broker.direct_routes import DirectRoutes
from hub.ipc.broker.message_users import MessageUsers
from hub.ipc.broker.peers import Outgoing, Peer, Peers
from hub.ipc.broker.query_routing import Answer, Asked, QueryRouting
from hub.ipc.formats.codegen import Buffer
from hub.ipc.security import permissions
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control, frames


class Queries:
    """Routes queries to their handlers, and answers back."""

    def __init__(
        self,
        peers: Peers,
        handlers: MessageUsers,
        publishers: MessageUsers,
        *,
        clock: Callable[[], float],
        faults: FaultCounter,
    ) -> None:
        """Start without any.

        Args:
            peers: All that are connected.
            handlers: The peers that answer the queries of each message.
            publishers: The peers that publish each message; they have its last value.
            clock: Monotonic time [s].
            faults: Counts refusals and late answers.
        """
        self._peers = peers
        self._handlers = handlers
        self._publishers = publishers
        self._clock = clock
        self._faults = faults
        self.routing = QueryRouting(self._candidates, faults)
        self._direct_routes = DirectRoutes()

    def handle(self, peer: Peer, message: control.Handle) -> list[Outgoing]:
        """Add or remove `peer` as a handler of a message."""
        name = message.name
        if not message.on:
            return self._direct_routes.close(peer, name) + self._handlers.leave(peer, name)
        if self._handlers.refusal(peer, name):
            return []
        outgoing = self._direct_routes.close_all(self._handlers.of(name), name)
        outgoing += self._handlers.join(peer, name)
        self._direct_routes.open(peer, message)
        return outgoing

    def ask(self, peer: Peer, message: Asked, attached: Buffer | None) -> list[Outgoing]:
        """Route a query of `peer`, or its request for the last value of a message."""
        if attached is None and isinstance(message, control.Query):
            text = f"the query of {message.name[:80]} came without its message"
            failure = control.Failure(number=message.number, error="NoHandlerError", text=text)
            return [Outgoing(identity=peer.identity, message=failure)]
        if attached is not None and _is_forged(peer, attached):
            text = f"{peer.name} asks under a number not its own"
            self._faults.count("not allowed", f"{peer.name}: {text}")
            refusal = permissions.refusal(message, text)
            return [Outgoing(identity=peer.identity, message=refusal)]
        outgoing = self.routing.ask(peer, message, attached, self._clock())
        handlers = list(self._handlers.of(message.name))
        if isinstance(message, control.Query) and len(handlers) == 1:
            outgoing += self._direct_routes.offer(peer, handlers[0], message.name)
        return outgoing

    def answer(self, peer: Peer, message: Answer, attached: Buffer | None) -> list[Outgoing]:
        """Route an answer of `peer`."""
        return self.routing.answer(peer, message, attached)

    def expire(self) -> None:
        """Forget the queries that timed out."""
        self.routing.expire(self._clock())

    def drop(self, peer: Peer) -> list[Outgoing]:
        """Forget `peer`, which is gone and publishes nothing."""
        outgoing = self._direct_routes.drop(peer, self._peers)
        outgoing += self._handlers.leave_all(peer)
        return outgoing + self.routing.drop(peer, self._clock())

    def _candidates(self, query: Asked) -> Iterable[Peer]:
        users = self._handlers if isinstance(query, control.Query) else self._publishers
        return users.of(query.name)


def _is_forged(peer: Peer, attached: Buffer) -> bool:
    """Whether the number in a message's header is not its sender's."""
    try:
        return frames.unpack(attached).publisher != peer.publisher
    except FrameError:
        return False  # its handler says so
