"""The subscribers on this machine to which each publisher sends directly. No sockets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.endpoints import is_direct_address
from hub.ipc.transport import sender_tickets
from hub.ipc.wire import control


class DirectSubscribers:
    """The inboxes of subscribers, which central sends to their publishers.

    A publisher gets the address of an inbox before it gets ADVERTISED, or confirms the subscription
    of that inbox. So no message is published past the inbox of a confirmed subscription.
    """

    def __init__(self) -> None:
        self._inboxes: dict[str, dict[Peer, control.Subscribe]] = {}

    def subscribe(
        self, subscriber: Peer, message: control.Subscribe, publishers: Iterable[Peer]
    ) -> list[Outgoing]:
        """Send a subscriber's inbox to the publishers; they confirm the subscription."""
        if not (subscriber.near and is_direct_address(message.inbox)):
            return []
        self._inboxes.setdefault(message.name, {})[subscriber] = message
        return [
            _subscriber(each, subscriber, message, message.token)
            for each in publishers
            if each.near
        ]

    def advertise(self, publisher: Peer, name: str) -> list[Outgoing]:
        """Send a new publisher the inboxes of all subscribers."""
        if not publisher.near:
            return []
        inboxes = self._inboxes.get(name, {})
        return [_subscriber(publisher, each, message, "") for each, message in inboxes.items()]

    def unsubscribe(
        self, subscriber: Peer, name: str, publishers: Iterable[Peer]
    ) -> list[Outgoing]:
        """Withdraw the inbox from the publishers of a message."""
        inboxes = self._inboxes.get(name, {})
        if inboxes.pop(subscriber, None) is None:
            return []
        if not inboxes:
            del self._inboxes[name]
        over = control.Subscriber(name=name, subscriber=subscriber.publisher)
        return [Outgoing(identity=p.identity, message=over) for p in publishers if p.near]

    def drop(self, subscriber: Peer, publishers: Iterator[Peer]) -> list[Outgoing]:
        """Withdraw the inboxes of a subscriber that is gone, once per publisher."""
        for name in subscriber.subscribes:
            inboxes = self._inboxes.get(name, {})
            if inboxes.pop(subscriber, None) and not inboxes:
                del self._inboxes[name]
        over = control.Subscriber(name="", subscriber=subscriber.publisher)
        near = dict.fromkeys(each for each in publishers if each.near and each is not subscriber)
        return [Outgoing(identity=each.identity, message=over) for each in near]


def _subscriber(
    publisher: Peer, subscriber: Peer, message: control.Subscribe, token: str
) -> Outgoing:
    known = control.Subscriber(
        name=message.name,
        subscriber=subscriber.publisher,
        inbox=message.inbox,
        in_ring=message.in_ring,
        token=token,
        ticket=sender_tickets.ticket(message.key, publisher.sends_under),
    )
    return Outgoing(identity=publisher.identity, message=known)
