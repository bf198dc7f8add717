"""Publishers and subscribers at central: ADVERTISE, SUBSCRIBE, UNSUBSCRIBE and READY."""

from __future__ import annotations

import itertools

from hub.ipc.broker.definitions import Definitions
from hub.ipc.broker.direct_subscribers import DirectSubscribers
from hub.ipc.broker.message_users import MessageUsers
from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.broker.presence import PresenceReports
from hub.ipc.broker.subscription_acks import SubscriptionAcks
from hub.ipc.security import permissions
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control
from hub.ipc.wire.control import Change

_MAX_TOKEN = 160


class Broadcasts:
    """Brings publishers and subscribers of one central together.

    Attributes:
        publishers: The peers that publish each message.
    """

    def __init__(
        self, definitions: Definitions, presence: PresenceReports, faults: FaultCounter
    ) -> None:
        """Start without any.

        Args:
            definitions: The messages that are defined.
            presence: Reports publishers and subscribers.
            faults: Counts what is refused.
        """
        self.publishers = MessageUsers(
            Change.PUBLISHERS, lambda peer: peer.publishes, definitions, presence, faults
        )
        self._subscribers = MessageUsers(
            Change.SUBSCRIBERS, lambda peer: peer.subscribes, definitions, presence, faults
        )
        self._direct_subscribers = DirectSubscribers()
        self.acks = SubscriptionAcks()

    def advertise(self, peer: Peer, message: control.Advertise) -> list[Outgoing]:
        """Note that `peer` publishes a message."""
        name = message.name
        if self.publishers.refusal(peer, name):
            return []
        reports = self.publishers.join(peer, name)
        direct = self._direct_subscribers.advertise(peer, name)
        others = self._subscribers.count(name) - len(direct)
        answer = control.Advertised(name=name, subscribed=others > 0)
        return [*direct, Outgoing(identity=peer.identity, message=answer), *reports]

    def subscribe(self, peer: Peer, message: control.Subscribe) -> list[Outgoing]:
        """Note that `peer` subscribes to a message."""
        # A peer without the right to define subscribes to what a module will define.
        text = self._subscribers.refusal(peer, message.name, undefined=True)
        if text:
            answer = permissions.refusal(message, text)
            return [Outgoing(identity=peer.identity, message=answer)]
        outgoing = self._subscribers.join(peer, message.name)
        publishers = list(self.publishers.of(message.name))
        outgoing += self._direct_subscribers.subscribe(peer, message, publishers)
        if 0 < len(message.token) <= _MAX_TOKEN:
            outgoing += self.acks.begin(peer, message.token, publishers)
        return outgoing

    def unsubscribe(self, peer: Peer, message: control.Unsubscribe) -> list[Outgoing]:
        """End a subscription of `peer`."""
        publishers = self.publishers.of(message.name)
        outgoing = self._direct_subscribers.unsubscribe(peer, message.name, publishers)
        return outgoing + self._subscribers.leave(peer, message.name)

    def ready(self, peer: Peer, message: control.Ready) -> list[Outgoing]:
        """Note that `peer` has seen the subscription of this token."""
        return self.acks.seen(peer, message.token) if len(message.token) <= _MAX_TOKEN else []

    def drop(self, peer: Peer) -> list[Outgoing]:
        """Forget `peer`, which is gone."""
        publishers = (self.publishers.of(name) for name in peer.subscribes)
        outgoing = self._direct_subscribers.drop(peer, itertools.chain.from_iterable(publishers))
        outgoing += self.publishers.leave_all(peer)
        outgoing += self._subscribers.leave_all(peer)
        return outgoing + self.acks.drop(peer)
