"""Which neighbours a client's messages go to directly, and the sockets to their inboxes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import zmq

from hub.ipc import endpoints
from hub.ipc.definition import Plane
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control

_MAX_UNREACHED = 1 << 16

Take = Callable[[bytes, int], Any]
"""Sends a frame to one neighbour; the number is of flags."""


class DirectReceivers(NamedTuple):
    """Who takes one message.

    Attributes:
        whole: Those who want the message itself.
        in_ring: Those who want a descriptor of shared memory.
    """

    whole: tuple[Take, ...] = ()
    in_ring: tuple[Take, ...] = ()


class _DirectRequest(NamedTuple):
    inbox: str
    in_ring: bool


class _DirectSocket:
    """The socket to one inbox.

    Attributes:
        take: Sends to it.
        names: The messages that go there.
        idle: Whether none went there when it was last looked at.
    """

    def __init__(self, socket: sockets.Socket) -> None:
        self._socket = socket
        self.take = sockets.sender(socket)
        self.names: set[str] = set()
        self.idle = False

    def close(self, linger_ms: int) -> None:
        self._socket.close(linger_ms)


class DirectDeliveries:
    """The ways to all inboxes; not to be used by two threads at once."""

    def __init__(self, context: sockets.Context, faults: FaultCounter) -> None:
        self._context = context
        self._faults = faults
        self._ways: dict[str, _DirectSocket] = {}
        self._wants: dict[str, dict[int, _DirectRequest]] = {}
        self._tuples: dict[tuple[Take, ...], tuple[Take, ...]] = {}
        self._unreached: dict[tuple[str, int], control.Subscriber] = {}

    @property
    def unreached(self) -> tuple[control.Subscriber, ...]:
        """Subscriptions of neighbours that there was no way to; to be noted again some time."""
        return tuple(self._unreached.values())

    def note(self, message: control.Subscriber, plane: Plane) -> bool:
        """A neighbour subscribes to a message of `plane`; False if there is no way to it."""
        self._forget(message.name, message.subscriber)
        if not endpoints.is_direct_address(message.inbox):
            where = f"an inbox at {message.inbox[:80]!r}"
            self._faults.count("malformed control frame", where)
            return False
        way = self._way(message.inbox, Plane.STATE if message.in_ring else plane)
        if way is None:
            if len(self._unreached) < _MAX_UNREACHED:
                self._unreached[message.name, message.subscriber] = message
            return False
        way.names.add(message.name)
        want = _DirectRequest(message.inbox, message.in_ring)
        self._wants.setdefault(message.name, {})[message.subscriber] = want
        return True

    def forget(self, name: str, subscriber: int) -> None:
        """It subscribes to the message no longer; if there is no name, it is gone.

        As long as it is there its way stays open for a while. Would it subscribe again and get
        another one, what still lies in the first would come behind what is sent later.
        """
        if name:
            self._forget(name, subscriber)
            return
        names = {*self._wants, *(each for each, _ in self._unreached)}
        inboxes = {self._forget(each, subscriber) for each in names}
        for inbox in inboxes & self._ways.keys():
            if not self._ways[inbox].names:
                self._close(inbox)

    def tidy(self) -> None:
        """Close the ways that were not needed last time either; to be called every second or so."""
        for inbox, way in tuple(self._ways.items()):
            if way.idle and not way.names:
                self._close(inbox)
            way.idle = not way.names

    def takers(self, name: str) -> DirectReceivers:
        """Who takes a message."""
        wants = self._wants.get(name, {}).values()
        whole = tuple(self._ways[want.inbox].take for want in wants if not want.in_ring)
        in_ring = tuple(self._ways[want.inbox].take for want in wants if want.in_ring)
        # Messages with the same takers have the same tuple, so that trains are loaded faster.
        return DirectReceivers(self._tuples.setdefault(whole, whole), in_ring)

    def close(self, linger_ms: int) -> None:
        """Close all ways; what was just sent gets `linger_ms` to leave."""
        self._wants.clear()
        self._tuples.clear()
        self._unreached.clear()
        while self._ways:
            self._ways.popitem()[1].close(linger_ms)

    def _forget(self, name: str, subscriber: int) -> str:
        """The subscriber takes the message no longer; at which inbox it did, if it did."""
        self._unreached.pop((name, subscriber), None)
        wants = self._wants.get(name, {})
        want = wants.pop(subscriber, None)
        if want is not None and all(want.inbox != other.inbox for other in wants.values()):
            self._ways[want.inbox].names.discard(name)
        return want.inbox if want is not None else ""

    def _close(self, inbox: str) -> None:
        self._ways.pop(inbox).close(0)
        self._tuples.clear()

    def _way(self, inbox: str, plane: Plane) -> _DirectSocket | None:
        if inbox in self._ways:
            return self._ways[inbox]
        try:
            socket = sockets.make_inbox(self._context, zmq.PUSH, plane)
            socket.connect(inbox)
        except zmq.ZMQError as error:
            self._faults.count("no way to a subscriber", str(error))
            return None
        way = self._ways[inbox] = _DirectSocket(socket)
        return way
