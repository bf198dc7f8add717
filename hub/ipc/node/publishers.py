"""All messages that a client publishes, and its sockets to central.

The sockets show the subscriptions of the other side (XPUB). So a publisher sees whether its message
has subscribers, and central gets READY when a new subscription has arrived here.

    Client.publish -> Publisher -> SendQueue -> DirectSockets, and the sockets to central
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.node.connection import Connection
from hub.ipc.node.direct_sockets import DirectSockets
from hub.ipc.node.publisher import Publisher
from hub.ipc.node.send_queue import SendQueue
from hub.ipc.transport import sender_tickets, sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.wire import control, frames

_AT_ONCE = 128
_MAX_FILTERS = 1 << 16
_MARK = b"~"


def mark(topic: bytes, token: str) -> bytes:
    """The topic of a mark: it follows a subscription, and no client publishes it."""
    return _MARK + topic + token.encode("ascii")


class Publishers:
    """All publishers of one client."""

    def __init__(self, transport: ClientTransport, connection: Connection) -> None:
        self._transport = transport
        self._connection = connection
        self._clock = transport.clock
        self.queue = SendQueue(self._send_to_central, transport.faults)
        self.direct_sockets = DirectSockets(transport)
        self._sockets: dict[Plane, sockets.Socket] = {}
        self._files: dict[Plane, int] = {}
        self._sends: dict[Plane, Callable[[bytes, int], Any]] = {}
        self._marks: dict[bytes, set[str]] = {}
        self._publishers: dict[str, Publisher] = {}

    @property
    def used(self) -> bool:
        """Whether it has publishers."""
        return bool(self._publishers)

    @property
    def pending(self) -> bool:
        """Whether messages of a burst wait to be sent."""
        return self.queue.pending

    @property
    def holding(self) -> bool:
        """Whether a publisher holds messages back."""
        return any(publisher.holding for publisher in self._publishers.values())

    def of(self, definition: MessageDefinition[Any]) -> Publisher:
        """The publisher of a defined message; a new one is advertised at central.

        Raises:
            NotAllowedError: The client's key or name does not allow it.
        """
        publisher = self._publishers.get(definition.name)
        if publisher is None:
            self._connection.demand_right(definition)
            publisher = Publisher(definition, self._connection, self.queue, self._transport)
            self._publishers[definition.name] = publisher
            if self._connection.publisher:
                publisher.begin()
                self._advertise(publisher)
        return publisher

    def forward(self, definition: MessageDefinition[Any], frame: frames.Frame) -> None:
        """Send a message of another hub under the numbers that it has there."""
        publisher = self.of(definition)
        publisher.count(len(frame.payload), self._clock())
        kind = b"" if self._connection.near else frames.FAR
        packed = functools.partial(
            frames.pack,
            publisher=frame.publisher,
            fingerprint=frame.fingerprint,
            sequence=frame.sequence,
            stamp_ns=frame.stamp_ns,
        )
        if publisher.direct_in_ring:  # they ask for the payload then
            prefix = frames.prefix(definition.name, frames.RING)
            nothing = packed(prefix, payload=(), kind=frames.NO_RING)
            self.queue.send(nothing, publisher.direct_in_ring, b"", definition.plane)
        whole = packed(frames.prefix(definition.name, kind), payload=(frame.payload,))
        self.queue.send(whole, publisher.direct, publisher.topic, definition.plane)

    def connect(self, addresses: Sequence[str]) -> None:
        """Connect to the input of each plane at a new central."""
        for plane, address in zip(sockets.PLANES, addresses, strict=True):
            if not self._connection.may_connect(plane):
                continue
            socket = sockets.make_plane(
                self._transport.context, zmq.XPUB, plane, self._connection.proof
            )
            sender_tickets.show(socket, self._connection.ticket)
            self._transport.handshakes.begin(socket)
            sockets.connect(socket, address)
            self._sockets[plane] = socket
            self._sends[plane] = sockets.sender(socket)
            self._files[plane] = self._transport.loop.register(
                socket, functools.partial(self._receive, socket)
            )
        for publisher in self._publishers.values():
            publisher.begin()

    def advertise_all(self) -> None:
        """Advertise all messages at a central that has the definitions."""
        for publisher in self._publishers.values():
            self._advertise(publisher)

    def disconnect(self, linger_ms: int = 0) -> None:
        """Disconnect from central; sent frames get `linger_ms` to leave."""
        for publisher in self._publishers.values():
            publisher.end()
        for file in self._files.values():
            self._transport.loop.unregister(file)
        with self.queue.lock:
            self.queue.clear_locked()
            self.queue.topics.clear()
            self.direct_sockets.close(linger_ms)
            for socket in self._sockets.values():
                self._transport.handshakes.end(socket)
                socket.close(linger_ms)
            self._sockets.clear()
            self._sends.clear()
        self._files.clear()
        self._marks.clear()

    def close(self) -> None:
        """Send waiting messages, and free all resources."""
        self.queue.close()
        self.disconnect(linger_ms=100)
        for publisher in self._publishers.values():
            publisher.close()

    def advertised(self, message: control.Advertised) -> None:
        """Handle the answer to ADVERTISE."""
        publisher = self._publishers.get(message.name)
        if publisher is not None:
            publisher.advertised(subscribed=message.subscribed, now=self._clock())

    def subscriber(self, message: control.Subscriber) -> None:
        """Add or remove a subscriber on this machine."""
        publisher = self._publishers.get(message.name)
        added = False
        with self.queue.lock:
            self.queue.flush_locked()
            if not message.inbox:
                self.direct_sockets.remove(message.name, message.subscriber)
            elif publisher is not None:
                added = self.direct_sockets.add(message, publisher.definition.plane)
            # Even without a socket to the subscriber: there may have been one before.
            for each in self._publishers.values() if not message.name else [publisher]:
                if each is not None:
                    direct = self.direct_sockets.receivers(each.definition.name)
                    each.direct, each.direct_in_ring = direct
        if added and message.token:
            self._connection.send(control.Ready(token=message.token))

    def reports(self) -> tuple[control.Published, ...]:
        """The publications of each publisher since the last report."""
        now = self._clock()
        made = (publisher.report(now) for publisher in self._publishers.values())
        return tuple(report for report in made if report is not None)

    def last(self, name: str) -> bytes | None:
        """The last message of this name, as a frame; waiting messages leave before it."""
        self.flush()
        publisher = self._publishers.get(name)
        return None if publisher is None else publisher.last()

    def flush(self) -> None:
        """Send all waiting messages; any thread may call this."""
        self.queue.flush()

    def check(self) -> None:
        """Retry what failed; call it about once a second."""
        self._check_open()
        with self.queue.lock:
            self.direct_sockets.close_unused()
            unreached = self.direct_sockets.unreached
        for message in unreached:  # this process may have descriptors again
            self.subscriber(message)
        for publisher in self._publishers.values():
            if publisher.unanswered and self._connection.publisher:
                self._advertise(publisher)  # the message may be defined now

    def _send_to_central(self, frame: bytes, topic: bytes, plane: Plane) -> None:
        """Send a frame; the lock of the queue is held."""
        send = self._sends.get(plane)
        if send is None:
            return
        try:
            send(frame, sockets.NOBLOCK)
        except zmq.Again:
            name = topic.strip(b"!\0").decode("ascii")
            self._transport.faults.count("not sent", f"{name}: no connection to central")
        self._transport.loop.touch(self._files[plane])

    def _check_open(self) -> None:
        now = self._clock()
        for publisher in self._publishers.values():
            publisher.check_open(now)

    def _advertise(self, publisher: Publisher) -> None:
        name = publisher.definition.name
        self._connection.send(control.Advertise(name=name))
        for token in self._marks.get(publisher.topic[:-1], ()):
            self._connection.send(control.Ready(token=token))

    def _receive(self, socket: sockets.Socket) -> bool:
        """Read the new subscriptions."""
        events = self._subscriptions(socket)
        for raw in events:
            on, topic = raw[:1] == b"\1", raw[1:]
            if topic[:1] == _MARK:
                self._marked(topic, on=on)
            elif not on:
                self.queue.topics.discard(topic)
            elif len(self.queue.topics) < _MAX_FILTERS:
                self.queue.topics.add(topic)
            else:
                self._transport.faults.count("too many subscriptions", "one more is ignored")
        if events:
            self._check_open()
        return len(events) == _AT_ONCE

    def _subscriptions(self, socket: sockets.Socket) -> list[bytes]:
        events: list[bytes] = []
        with self.queue.lock:
            if not socket.closed and sockets.readable(socket):
                try:
                    while len(events) < _AT_ONCE:
                        events.append(socket.recv(zmq.NOBLOCK))
                except zmq.Again:
                    pass
        return events

    def _marked(self, topic: bytes, *, on: bool) -> None:
        wanted, _, raw = topic[1:].partition(b"\0")
        token = raw.decode("ascii", "replace")
        if not on:
            self._marks.get(wanted, set()).discard(token)
            if wanted in self._marks and not self._marks[wanted]:
                del self._marks[wanted]
            return
        if len(self._marks) < _MAX_FILTERS:
            self._marks.setdefault(wanted, set()).add(token)
        publisher = self._publishers.get(wanted.removeprefix(frames.FAR).decode("ascii", "replace"))
        # A subscriber on this machine has an inbox; its subscription at central is for other
        # machines.
        sent = publisher is not None and publisher.topic[:-1] == wanted
        if sent or token.startswith(f"{self._connection.publisher}."):
            self._connection.send(control.Ready(token=token))
