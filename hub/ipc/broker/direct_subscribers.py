"""Whom each publisher sends to directly: subscribers in central's own neighbourhood. No sockets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.endpoints import is_direct_address
from hub.ipc.wire import control


class DirectSubscribers:
    """The inboxes of those who subscribe, and what their publishers are told of them.

    Only central brings the two together: a publisher learns of an inbox before it learns that it is
    noted itself, or confirms the subscription that brought it. So nothing is published past an
    inbox that stands.
    """

    def __init__(self) -> None:
        self._inboxes: dict[str, dict[Peer, control.Subscribe]] = {}

    def subscribe(
        self, subscriber: Peer, message: control.Subscribe, publishers: Iterable[Peer]
    ) -> list[Outgoing]:
        """Tell the publishers; they confirm the subscription."""
        if not (subscriber.near and is_direct_address(message.inbox)):
            return []
        self._inboxes.setdefault(message.name, {})[subscriber] = message
        return [_told(each, subscriber, message, message.token) for each in publishers if each.near]

    def advertise(self, publisher: Peer, name: str) -> list[Outgoing]:
        """Tell a new publisher of all who have subscribed."""
        if not publisher.near:
            return []
        inboxes = self._inboxes.get(name, {})
        return [_told(publisher, each, message, "") for each, message in inboxes.items()]

    def unsubscribe(
        self, subscriber: Peer, name: str, publishers: Iterable[Peer]
    ) -> list[Outgoing]:
        """Tell the publishers that they need send no more of it."""
        inboxes = self._inboxes.get(name, {})
        if inboxes.pop(subscriber, None) is None:
            return []
        if not inboxes:
            del self._inboxes[name]
        over = control.Subscriber(name=name, subscriber=subscriber.publisher)
        return [Outgoing(identity=p.identity, message=over) for p in publishers if p.near]

    def drop(self, subscriber: Peer, publishers: Iterator[Peer]) -> list[Outgoing]:
        """It is gone: tell all publishers of anything it subscribed to, once."""
        for name in subscriber.subscribes:
            inboxes = self._inboxes.get(name, {})
            if inboxes.pop(subscriber, None) and not inboxes:
                del self._inboxes[name]
        over = control.Subscriber(name="", subscriber=subscriber.publisher)
        told = dict.fromkeys(each for each in publishers if each.near and each is not subscriber)
        return [Outgoing(identity=each.identity, message=over) for each in told]


def _told(publisher: Peer, subscriber: Peer, message: control.Subscribe, token: str) -> Outgoing:
    told = control.Subscriber(
        name=message.name,
        subscriber=subscriber.publisher,
        inbox=message.inbox,
        in_ring=message.in_ring,
        token=token,
    )
    return Outgoing(identity=publisher.identity, message=told)
