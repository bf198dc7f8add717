"""Direct routes: the modules that may ask each other past central."""

from __future__ import annotations

from collections.abc import Iterable

from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.endpoints import is_direct_address
from hub.ipc.transport import sender_tickets
from hub.ipc.wire import control


class DirectRoutes:
    """The addresses of handlers for direct queries, and the peers that have them.

    Only a message with a single handler has a direct route. Central shares queries among several.
    """

    def open(self, handler: Peer, message: control.Handle) -> None:
        """Note the direct address of `handler`."""
        if handler.near and is_direct_address(message.address):
            handler.direct_handlers[message.name] = message

    def offer(self, asker: Peer, handler: Peer, name: str) -> list[Outgoing]:
        """Send `asker` the handler's address, if both can use it and `asker` lacks it."""
        direct = handler.direct_handlers.get(name)
        known = (asker, name) in handler.direct_askers
        if direct is None or known or asker is handler or not asker.near:
            return []
        handler.direct_askers.add((asker, name))
        ticket = sender_tickets.ticket(direct.key, asker.sends_under)
        route = control.DirectRoute(name=name, address=direct.address, ticket=ticket)
        return [Outgoing(identity=asker.identity, message=route)]

    def close(self, handler: Peer, name: str) -> list[Outgoing]:
        """Withdraw the direct route to `handler`."""
        ended = [(asker, each) for asker, each in handler.direct_askers if each == name]
        handler.direct_askers.difference_update(ended)
        route = control.DirectRoute(name=name, address="")
        return [Outgoing(identity=asker.identity, message=route) for asker, _ in ended]

    def close_all(self, handlers: Iterable[Peer], name: str) -> list[Outgoing]:
        """Withdraw the direct routes of a message that has several handlers now."""
        return [each for handler in tuple(handlers) for each in self.close(handler, name)]

    def drop(self, peer: Peer, others: Iterable[Peer]) -> list[Outgoing]:
        """Forget `peer`, which is gone; its askers go through central.

        Args:
            peer: The peer that is gone.
            others: The connected peers; they forget `peer` as an asker.
        """
        for other in others:
            if other.direct_askers:
                other.direct_askers = {each for each in other.direct_askers if each[0] is not peer}
        names = {name for _, name in peer.direct_askers}
        return [each for name in sorted(names) for each in self.close(peer, name)]
