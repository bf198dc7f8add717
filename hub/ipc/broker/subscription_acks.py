"""Subscriptions on their way: each is complete when all publishers have seen it."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable

from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.roles import LOCAL
from hub.ipc.wire import control
from hub.values import dataclass

MAX_UNDER_WAY = 16_384
MAX_FAR = MAX_UNDER_WAY // 2
"""Most of clients with keys, so that no module of the robot waits for them."""
_MAX_EARLY = 4096


@dataclass(slots=True)
class _Confirmation:
    subscriber: Peer
    awaited: set[Peer]


class SubscriptionAcks:
    """All subscriptions under way, by token.

    A subscription travels to the publishers through ZeroMQ, beside the control messages. Behind it
    the subscriber sends a mark with a token that goes the same way. A publisher that sees the mark
    has seen the subscription, and sends READY.
    """

    def __init__(self) -> None:
        self._under_way: dict[str, _Confirmation] = {}
        self.far = 0
        self.early: OrderedDict[str, set[Peer]] = OrderedDict()

    def begin(self, subscriber: Peer, token: str, publishers: Iterable[Peer]) -> list[Outgoing]:
        """Wait until `subscriber` and all `publishers` have seen `token`."""
        far = subscriber.principal is not LOCAL
        full = len(self._under_way) >= MAX_UNDER_WAY or (far and self.far >= MAX_FAR)
        if full or (far and not token.startswith(f"{subscriber.publisher}.")):
            return []  # no SUBSCRIBED follows: a client with a key may guess the tokens of others
        awaited = {subscriber, *publishers} - self.early.pop(token, set())
        self._end(token)
        self._under_way[token] = _Confirmation(subscriber, awaited)
        self.far += far
        return self._conclude(token)

    def seen(self, peer: Peer, token: str) -> list[Outgoing]:
        """Note that `peer` has seen `token`."""
        under_way = self._under_way.get(token)
        if under_way is None:  # the mark was faster than the control message
            self.early.setdefault(token, set()).add(peer)
            if len(self.early) > _MAX_EARLY:
                self.early.popitem(last=False)
            return []
        under_way.awaited.discard(peer)
        return self._conclude(token)

    def drop(self, peer: Peer) -> list[Outgoing]:
        """Forget `peer`, which is gone."""
        for token in [t for t, each in self._under_way.items() if each.subscriber is peer]:
            self._end(token)
        for early in self.early.values():
            early.discard(peer)
        outgoing = []
        for token, each in list(self._under_way.items()):
            if peer in each.awaited:
                each.awaited.discard(peer)
                outgoing += self._conclude(token)
        return outgoing

    def _conclude(self, token: str) -> list[Outgoing]:
        under_way = self._under_way[token]
        if under_way.awaited:
            return []
        self._end(token)
        message = control.Subscribed(token=token)
        return [Outgoing(identity=under_way.subscriber.identity, message=message)]

    def _end(self, token: str) -> None:
        under_way = self._under_way.pop(token, None)
        if under_way is not None and under_way.subscriber.principal is not LOCAL:
            self.far -= 1
