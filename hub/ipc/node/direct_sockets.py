"""The sockets to the inboxes of subscribers on this machine."""

from __future__ import annotations

import zmq

from hub.ipc import endpoints
from hub.ipc.definition import Plane
from hub.ipc.node.send_queue import Send
from hub.ipc.transport import sender_tickets, sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.wire import control

_MAX_UNREACHED = 1 << 16


class DirectSockets:
    """One socket to each inbox. Only one thread may use them at a time."""

    def __init__(self, transport: ClientTransport) -> None:
        self._transport = transport
        # By inbox: its socket, its send function, and the messages that go there.
        self._sockets: dict[str, sockets.Socket] = {}
        self._sends: dict[str, Send] = {}
        self._names: dict[str, set[str]] = {}
        self._unused: set[str] = set()
        # By message and number of the subscriber.
        self._subscribers: dict[str, dict[int, control.Subscriber]] = {}
        self._unreached: dict[tuple[str, int], control.Subscriber] = {}
        self._tuples: dict[tuple[Send, ...], tuple[Send, ...]] = {}

    def __len__(self) -> int:
        return len(self._sockets)

    @property
    def unreached(self) -> tuple[control.Subscriber, ...]:
        """Subscribers without a socket, because none could be made; add them again later."""
        return tuple(self._unreached.values())

    def add(self, subscriber: control.Subscriber, plane: Plane) -> bool:
        """Add a subscriber of a message of `plane`; False: no socket could be made."""
        name, inbox = subscriber.name, subscriber.inbox
        self._remove(name, subscriber.subscriber)
        if not endpoints.is_direct_address(inbox):
            self._transport.faults.count("malformed control frame", f"an inbox at {inbox[:80]!r}")
            return False
        if not self._open(subscriber, Plane.STATE if subscriber.in_ring else plane):
            if len(self._unreached) < _MAX_UNREACHED:
                self._unreached[name, subscriber.subscriber] = subscriber
            return False
        self._names[inbox].add(name)
        self._subscribers.setdefault(name, {})[subscriber.subscriber] = subscriber
        return True

    def remove(self, name: str, subscriber: int) -> None:
        """End a subscription; without a name: all of a subscriber that is gone.

        The socket of a connected subscriber stays open for a while: after a new subscription, a new
        socket would overtake the messages that still wait in the first one.
        """
        if name:
            self._remove(name, subscriber)
            return
        names = {*self._subscribers, *(each for each, _ in self._unreached)}
        inboxes = {self._remove(each, subscriber) for each in names}
        for inbox in inboxes & self._sockets.keys():
            if not self._names[inbox]:
                self._close(inbox)

    def close_unused(self) -> None:
        """Close the sockets that were unused last time too; call it about once a second."""
        unused = {inbox for inbox, names in self._names.items() if not names}
        for inbox in unused & self._unused:
            self._close(inbox)
        self._unused = unused

    def receivers(self, name: str) -> tuple[tuple[Send, ...], tuple[Send, ...]]:
        """The subscribers of a message, and its readers from shared memory."""
        known = self._subscribers.get(name, {}).values()
        whole = tuple(self._sends[each.inbox] for each in known if not each.in_ring)
        in_ring = tuple(self._sends[each.inbox] for each in known if each.in_ring)
        # Messages with the same subscribers have the same tuple, so that bundles fill faster.
        return self._tuples.setdefault(whole, whole), in_ring

    def close(self, linger_ms: int) -> None:
        """Close all sockets; sent frames get `linger_ms` to leave."""
        for socket in self._sockets.values():
            socket.close(linger_ms)
        for each in (self._sockets, self._sends, self._names, self._unused):
            each.clear()
        self._subscribers.clear()
        self._unreached.clear()
        self._tuples.clear()

    def _remove(self, name: str, subscriber: int) -> str:
        """Forget a subscriber of a message; returns its inbox, if any."""
        self._unreached.pop((name, subscriber), None)
        others = self._subscribers.get(name, {})
        known = others.pop(subscriber, None)
        if known is None:
            return ""
        if all(known.inbox != other.inbox for other in others.values()):
            self._names[known.inbox].discard(name)
        return known.inbox

    def _close(self, inbox: str) -> None:
        self._sockets.pop(inbox).close(0)
        del self._sends[inbox], self._names[inbox]
        self._tuples.clear()

    def _open(self, subscriber: control.Subscriber, plane: Plane) -> bool:
        inbox = subscriber.inbox
        if inbox in self._sockets:
            return True
        queue = sockets.GATHER_QUEUE if inbox.startswith(endpoints.GATHER_PREFIX) else 0
        try:
            socket = sockets.make_inbox(self._transport.context, zmq.PUSH, plane, queue)
            sender_tickets.show(socket, subscriber.ticket)
            socket.connect(inbox)
        except zmq.ZMQError as error:
            self._transport.faults.count("no way to a subscriber", str(error))
            return False
        self._sockets[inbox] = socket
        self._sends[inbox] = sockets.sender(socket)
        self._names[inbox] = set()
        return True
