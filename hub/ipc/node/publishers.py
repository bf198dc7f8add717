"""The sending side of a client's broadcasts: its publishers and the sockets they share.

The sockets are of the kind that sees the subscriptions of the other side (XPUB). So a publisher
knows whether anybody wants its message and in which way, holds back what it is given until the way
to those who have subscribed is open, and central is told when a new subscription has arrived here.

What is published in a burst is sent together: when enough has gathered, when the module listens, or
after a millisecond or two by a thread of its own. Therefore the sockets are used under a lock.
"""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.node.connection import Connection
from hub.ipc.node.direct_deliveries import DirectDeliveries, Take
from hub.ipc.node.publisher import BATCH_S, Batch, Publisher
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.handshakes import Handshakes
from hub.ipc.transport.loop import Loop
from hub.ipc.wire import control, frames

_AT_ONCE = 128
_MAX_FILTERS = 1 << 16
_MARK = b"~"


def mark(topic: bytes, token: str) -> bytes:
    """What a subscriber subscribes to behind a topic itself; nobody publishes it."""
    return _MARK + topic + token.encode("ascii")


class Publishers:
    """All publishers of one client.

    Attributes:
        connection: Where central is told.
        clock: Monotonic time [s].
        faults: Where failures are counted.
        near: Whether we are a neighbour of others.
        batch: What waits to be sent.
    """

    def __init__(
        self,
        context: sockets.Context,
        loop: Loop,
        connection: Connection,
        faults: FaultCounter,
        handshakes: Handshakes,
    ) -> None:
        self._handshakes = handshakes
        self.connection = connection
        self.clock = loop.clock
        self.faults = faults
        self.near = False
        self._deliveries = DirectDeliveries(context, faults)
        self._context = context
        self._loop = loop
        self.batch = Batch()
        self._sockets: dict[Plane, sockets.Socket] = {}
        self._files: dict[Plane, int] = {}
        self._sends: dict[Plane, Callable[[bytes, int], Any]] = {}
        self._filters: set[bytes] = set()
        self._marks: dict[bytes, set[str]] = {}
        self._publishers: dict[str, Publisher] = {}
        self._courier = _FlushThread(self.batch, self.flush)

    @property
    def used(self) -> bool:
        """Whether anything is published."""
        return bool(self._publishers)

    @property
    def pending(self) -> bool:
        """Whether messages of a burst wait to be sent."""
        return bool(self.batch.runs)

    @property
    def holding(self) -> bool:
        """Whether a publisher holds messages until its way is open."""
        return any(publisher.holding for publisher in self._publishers.values())

    def of(self, definition: MessageDefinition[Any]) -> Publisher:
        """The publisher of a message that is defined; central is told when it is new.

        Raises:
            NotAllowedError: Our key, or our name, does not let us publish it.
        """
        publisher = self._publishers.get(definition.name)
        if publisher is None:
            self.connection.demand_right(definition)
            publisher = self._publishers[definition.name] = Publisher(definition, self)
            if self.connection.publisher:
                publisher.begin()
                self._advertise(publisher)
        return publisher

    def connect(self, addresses: Sequence[str], *, near: bool) -> None:
        """Connect where each plane goes in, at a central that does not know us."""
        self.near = near
        for plane, address in zip(sockets.PLANES, addresses, strict=True):
            if not self.connection.may_connect(plane):
                continue
            socket = sockets.make_plane(self._context, zmq.XPUB, plane, self.connection.keys)
            self._handshakes.begin(socket)
            sockets.connect(socket, address)
            self._sockets[plane] = socket
            self._sends[plane] = sockets.sender(socket)
            self._files[plane] = self._loop.register(
                socket, functools.partial(self._receive, socket)
            )
        for publisher in self._publishers.values():
            publisher.begin()

    def advertise_all(self) -> None:
        """Tell central, which knows the definitions now, what we publish."""
        for publisher in self._publishers.values():
            self._advertise(publisher)

    def disconnect(self, linger_ms: int = 0) -> None:
        """Central is gone; what was just sent gets `linger_ms` to leave."""
        for publisher in self._publishers.values():
            publisher.end()
        for file in self._files.values():
            self._loop.unregister(file)
        with self.batch.lock:
            self.batch.runs.clear()
            self.batch.count = 0
            self._deliveries.close(linger_ms)
            for socket in self._sockets.values():
                self._handshakes.end(socket)
                socket.close(linger_ms)
            self._sockets.clear()
            self._sends.clear()
        self._files.clear()
        self._filters.clear()
        self._marks.clear()

    def close(self) -> None:
        """Send what waits, and free everything."""
        self.flush()
        self._courier.close()
        self.disconnect(linger_ms=100)
        for publisher in self._publishers.values():
            publisher.close()

    def advertised(self, message: control.Advertised) -> None:
        """Central has noted what we publish."""
        publisher = self._publishers.get(message.name)
        if publisher is not None:
            publisher.advertised(subscribed=message.subscribed, now=self.clock())

    def subscriber(self, message: control.Subscriber) -> None:
        """Central tells of a neighbour that subscribes, or does so no longer."""
        publisher = self._publishers.get(message.name)
        noted = False
        with self.batch.lock:
            if self.batch.runs:
                self.send_batch()
            if not message.inbox:
                self._deliveries.forget(message.name, message.subscriber)
            elif publisher is not None:
                noted = self._deliveries.note(message, publisher.definition.plane)
            # Also if there is no way to the subscriber: there may have been one before.
            for each in self._publishers.values() if not message.name else [publisher]:
                if each is not None:
                    each.takers = self._deliveries.takers(each.definition.name)
        if noted and message.token:
            self.connection.send(control.Ready(token=message.token))

    def reports(self) -> tuple[control.Published, ...]:
        """What was published by each publisher since the last time."""
        now = self.clock()
        made = (publisher.report(now) for publisher in self._publishers.values())
        return tuple(report for report in made if report is not None)

    def last(self, name: str) -> bytes | None:
        """The last message of this name, as a frame; it does not overtake what waits to be sent."""
        self.flush()
        publisher = self._publishers.get(name)
        return None if publisher is None else publisher.last()

    def send(self, publisher: Publisher, frame: bytes, *, place: bool = False) -> None:
        """Send behind what waits to all who want a publisher's message itself, or its place."""
        with self.batch.lock:
            if self.batch.runs:
                self.send_batch()
            for take in publisher.takers.in_ring if place else publisher.takers.whole:
                self._hand(take, frame)
            if not place and publisher.topic in self._filters:
                self._send(publisher, frame)

    def flush(self) -> None:
        """Send what waits; any thread may call this."""
        with self.batch.lock:
            if self.batch.runs:
                self.send_batch()

    def is_wanted(self, topic: bytes) -> bool:
        """Whether somebody at central subscribes to the topic."""
        return topic in self._filters

    def check(self) -> None:
        """Let nobody wait for ever; to be called every second or so."""
        self._look()
        with self.batch.lock:
            self._deliveries.tidy()
            unreached = self._deliveries.unreached
        for message in unreached:  # perhaps there are descriptors again
            self.subscriber(message)
        for publisher in self._publishers.values():
            if publisher.unanswered and self.connection.publisher:
                self._advertise(publisher)  # perhaps somebody has defined the message by now

    def send_batch(self) -> None:
        """Send what waits; the lock is held."""
        runs, self.batch.runs, self.batch.count = self.batch.runs, [], 0
        trains: dict[Take, list[bytes]] = {}
        before: tuple[Take, ...] = ()
        loading: list[list[bytes]] = []
        for publisher, first, items in runs:
            frame, takers, topic = publisher.run(first, items)
            if takers is not before:
                before, loading = takers, [trains.setdefault(take, []) for take in takers]
            for train in loading:
                train.append(frame)
            if topic in self._filters:
                self._send(publisher, frame)
        for take, whole in trains.items():
            self._hand(take, whole[0] if len(whole) == 1 else frames.train(whole))

    def call_courier(self) -> None:
        """Have what waits sent in a moment."""
        self._courier.call()

    def _hand(self, take: Take, frame: bytes) -> None:
        try:
            take(frame, sockets.NOBLOCK)
        except zmq.Again:
            self.faults.count("queue full", "a subscriber on this machine is behind")

    def _send(self, publisher: Publisher, frame: bytes) -> None:
        plane = publisher.definition.plane
        send = self._sends.get(plane)
        if send is None:
            return
        try:
            send(frame, sockets.NOBLOCK)
        except zmq.Again:
            name = publisher.definition.name
            self.faults.count("not sent", f"{name}: no connection to central")
        self._loop.touch(self._files[plane])

    def _look(self) -> None:
        now = self.clock()
        for publisher in self._publishers.values():
            publisher.look(now)

    def _advertise(self, publisher: Publisher) -> None:
        name = publisher.definition.name
        self.connection.send(control.Advertise(name=name))
        for token in self._marks.get(publisher.topic[:-1], ()):
            self.connection.send(control.Ready(token=token))

    def _receive(self, socket: sockets.Socket) -> bool:
        """Take the subscriptions that have come."""
        came = self._subscriptions(socket)
        for raw in came:
            on, topic = raw[:1] == b"\1", raw[1:]
            if topic[:1] == _MARK:
                self._marked(topic, on=on)
            elif not on:
                self._filters.discard(topic)
            elif len(self._filters) < _MAX_FILTERS:
                self._filters.add(topic)
            else:
                self.faults.count("too many subscriptions", "one more is not noted")
        if came:
            self._look()
        return len(came) == _AT_ONCE

    def _subscriptions(self, socket: sockets.Socket) -> list[bytes]:
        came: list[bytes] = []
        with self.batch.lock:
            if not socket.closed and sockets.readable(socket):
                try:
                    while len(came) < _AT_ONCE:
                        came.append(socket.recv(zmq.NOBLOCK))
                except zmq.Again:
                    pass
        return came

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
        # What a neighbour subscribes to at central is not what we send; it has an inbox for that.
        sent = publisher is not None and publisher.topic[:-1] == wanted
        if sent or token.startswith(f"{self.connection.publisher}."):
            self.connection.send(control.Ready(token=token))


class _FlushThread:
    """A thread that sends what waits, a moment after it was called."""

    def __init__(self, batch: Batch, flush: Callable[[], None]) -> None:
        self._batch = batch
        self._flush = flush
        self._wake = threading.Event()
        self._closed = False
        self._thread: threading.Thread | None = None

    def call(self) -> None:
        """Come in a moment."""
        self._batch.called = True
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="rune-courier", daemon=True)
            self._thread.start()
        self._wake.set()

    def close(self) -> None:
        """Never come again."""
        self._closed = True
        self._wake.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        while not self._closed:
            self._wake.wait()
            self._wake.clear()
            time.sleep(BATCH_S)
            self._batch.called = False  # before it looks: what comes from now on calls again
            self._flush()
