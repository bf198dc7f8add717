"""Which modules may ask each other directly, as far as central has told them."""

from __future__ import annotations

from collections.abc import Iterable

from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.endpoints import is_direct_address
from hub.ipc.wire import control


class DirectRoutes:
    """The doors of those who answer, and who was told of them.

    Only one who answers alone is asked directly, because central shares queries among several.
    """

    def open(self, handler: Peer, message: control.Handle) -> None:
        """`handler` can be asked directly."""
        if handler.near and is_direct_address(message.address):
            handler.doors[message.name] = message.address

    def offer(self, asker: Peer, handler: Peer, name: str) -> list[Outgoing]:
        """Tell `asker` of the door, if both can use it and it does not know."""
        address = handler.doors.get(name, "")
        known = (asker, name) in handler.routed
        if not address or known or asker is handler or not asker.near:
            return []
        handler.routed.add((asker, name))
        route = control.DirectRoute(name=name, address=address)
        return [Outgoing(identity=asker.identity, message=route)]

    def close(self, handler: Peer, name: str) -> list[Outgoing]:
        """Queries of this name go to `handler` through central again."""
        ended = [(asker, each) for asker, each in handler.routed if each == name]
        handler.routed.difference_update(ended)
        route = control.DirectRoute(name=name, address="")
        return [Outgoing(identity=asker.identity, message=route) for asker, _ in ended]

    def close_all(self, handlers: Iterable[Peer], name: str) -> list[Outgoing]:
        """There are several who answer now."""
        return [each for handler in tuple(handlers) for each in self.close(handler, name)]

    def drop(self, peer: Peer, others: Iterable[Peer]) -> list[Outgoing]:
        """`peer` is gone; who asked it directly asks through central.

        Args:
            peer: Who is gone.
            others: Who is still there; they forget that `peer` asked them.
        """
        for other in others:
            if other.routed:
                other.routed = {(asker, name) for asker, name in other.routed if asker is not peer}
        names = {name for _, name in peer.routed}
        return [each for name in sorted(names) for each in self.close(peer, name)]
