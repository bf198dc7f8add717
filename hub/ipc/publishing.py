"""The sending side of a client's broadcasts: its outlets and the sockets they share.

The sockets are of the kind that sees the subscriptions of the other side (XPUB). So an outlet knows
whether anybody wants its message and in which way, holds back what it is given until the way to
those who have subscribed is open, and central is told when a new subscription has arrived here.

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

from hub.ipc import control, frames, ring, sockets
from hub.ipc.complaints import Complaints
from hub.ipc.connection import Connection
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.loop import Loop
from hub.ipc.outlet import BATCH_S, Batch, Outlet
from hub.ipc.security import Action, demand

_AT_ONCE = 1024
_MAX_FILTERS = 1 << 16
_MARK = b"~"


def mark(name: str, token: str) -> bytes:
    """What a subscriber subscribes to behind the message `name` itself; nobody publishes it."""
    return _MARK + frames.topic(name) + token.encode("ascii")


class Outlets:
    """All outlets of one client.

    Attributes:
        connection: Where central is told.
        clock: Monotonic time [s].
        complaints: Where failures are counted.
        local: Whether central is on this machine, so that rings can be used.
        batch: What waits to be sent.
    """

    def __init__(
        self,
        context: sockets.Context,
        loop: Loop,
        connection: Connection,
        complaints: Complaints,
    ) -> None:
        self.connection = connection
        self.clock = loop.clock
        self.complaints = complaints
        self.local = False
        self._context = context
        self._loop = loop
        self.batch = Batch()
        self._sockets: dict[Plane, sockets.Socket] = {}
        self._files: dict[Plane, int] = {}
        self._sends: dict[Plane, Callable[[bytes, int], Any]] = {}
        self._filters: set[bytes] = set()
        self._marks: dict[str, set[str]] = {}
        self._outlets: dict[str, Outlet] = {}
        self._courier = _Courier(self.batch, self.flush)

    @property
    def pending(self) -> bool:
        """Whether messages of a burst wait to be sent."""
        return bool(self.batch.items)

    @property
    def holding(self) -> bool:
        """Whether an outlet holds messages until its way is open."""
        return any(outlet.holding for outlet in self._outlets.values())

    def of(self, definition: MessageDefinition[Any]) -> Outlet:
        """The outlet of a message that is defined; central is told when it is new.

        Raises:
            NotAllowedError: Our key does not let us publish it.
        """
        outlet = self._outlets.get(definition.name)
        if outlet is None:
            if self.connection.keys and not self.connection.may_publish(definition.plane):
                commands = definition.plane is Plane.COMMAND
                action = Action.PUBLISH_COMMAND if commands else Action.PUBLISH_STATE
                demand(self.connection.keys.bearer, action)
            outlet = self._outlets[definition.name] = Outlet(definition, self)
            if self.connection.publisher:
                outlet.begin()
                self._advertise(outlet)
        return outlet

    def connect(self, addresses: Sequence[str], *, local: bool) -> None:
        """Connect to a central that does not know us: where each plane goes in."""
        self.disconnect()
        self.local = local and ring.available
        for plane, address in zip(sockets.PLANES, addresses, strict=True):
            if not self.connection.may_publish(plane):
                continue
            socket = sockets.make_plane(self._context, zmq.XPUB, plane, self.connection.keys)
            sockets.connect(socket, address)
            self._sockets[plane] = socket
            self._sends[plane] = sockets.sender(socket)
            self._files[plane] = self._loop.register(
                socket, functools.partial(self._receive, socket)
            )
        for outlet in self._outlets.values():
            outlet.begin()

    def advertise_all(self) -> None:
        """Tell central, which knows the definitions now, what we publish."""
        for outlet in self._outlets.values():
            self._advertise(outlet)

    def disconnect(self, linger_ms: int = 0) -> None:
        """Central is gone; what was just sent gets `linger_ms` to leave."""
        for outlet in self._outlets.values():
            outlet.end()
        for file in self._files.values():
            self._loop.unregister(file)
        with self.batch.lock:
            self.batch.items.clear()
            for socket in self._sockets.values():
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
        for outlet in self._outlets.values():
            outlet.close()

    def advertised(self, message: control.Advertised) -> None:
        """Central has noted what we publish."""
        outlet = self._outlets.get(message.name)
        if outlet is not None:
            outlet.advertised(subscribed=message.subscribed, now=self.clock())

    def last(self, name: str) -> bytes | None:
        """The last message of this name, as a frame."""
        outlet = self._outlets.get(name)
        return None if outlet is None else outlet.last()

    def send(self, plane: Plane, name: str, frame: bytes) -> None:
        """Send on a plane, behind what waits to be sent; never waits itself."""
        with self.batch.lock:
            if self.batch.items:
                self.send_batch()
            self._send(plane, name, frame)

    def flush(self) -> None:
        """Send what waits; any thread may call this."""
        with self.batch.lock:
            if self.batch.items:
                self.send_batch()

    def is_wanted(self, topic: bytes) -> bool:
        """Whether somebody subscribes to the topic."""
        return topic in self._filters

    def check(self) -> None:
        """Let nobody wait for ever; to be called every second or so."""
        self._look()
        for outlet in self._outlets.values():
            if outlet.unanswered and self.connection.publisher:
                self._advertise(outlet)  # perhaps somebody has defined the message by now

    def send_batch(self) -> None:
        """Send what waits; the lock is held."""
        outlet, items = self.batch.outlet, self.batch.items
        if outlet is not None:
            plane, frame = outlet.batch(self.batch.first, items)
            self._send(plane, outlet.definition.name, frame)
        items.clear()

    def call_courier(self) -> None:
        """Have what waits sent in a moment."""
        self._courier.call()

    def _send(self, plane: Plane, name: str, frame: bytes) -> None:
        send = self._sends.get(plane)
        if send is None:
            return
        try:
            send(frame, sockets.NOBLOCK)
        except zmq.Again:
            self.complaints.count("not sent", f"{name}: no connection to central")
        self._loop.touch(self._files[plane])

    def _look(self) -> None:
        now = self.clock()
        for outlet in self._outlets.values():
            outlet.look(now)

    def _advertise(self, outlet: Outlet) -> None:
        name = outlet.definition.name
        self.connection.tell(control.Advertise(name=name))
        for token in self._marks.get(name, ()):
            self.connection.tell(control.Ready(token=token))

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
                self.complaints.count("too many subscriptions", "one more is not noted")
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
        name, _, token = topic[1:].decode("ascii", "replace").partition("\0")
        if not on:
            self._marks.get(name, set()).discard(token)
            if name in self._marks and not self._marks[name]:
                del self._marks[name]
            return
        if len(self._marks) < _MAX_FILTERS:
            self._marks.setdefault(name, set()).add(token)
        ours = token.startswith(f"{self.connection.publisher}.")
        if name in self._outlets or ours:
            self.connection.tell(control.Ready(token=token))


class _Courier:
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
