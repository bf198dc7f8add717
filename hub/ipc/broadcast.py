"""A client's side of the broadcasts: the sockets of each plane, subscriptions, and what came in."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import zmq

from hub.errors import CodecError, FrameError
from hub.ipc import frames, sockets
from hub.ipc.age import AgeEstimator
from hub.ipc.complaints import Complaints
from hub.ipc.definition import Keep, MessageDefinition, Plane

_logger = logging.getLogger(__name__)

_BATCH = 256
_MAX_PUBLISHERS = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class Reception:
    """How a message came.

    Attributes:
        publisher: Number of the sender's connection.
        sequence: Counts the messages of this name from this publisher, from 1.
        missed: Messages of it that did not come since the one before.
        age: Time since it was measured, beyond the fastest way seen from this publisher [s].
        measured: When it was measured, on this process's monotonic clock [s]; too late by the
            time of the fastest way.
    """

    publisher: int
    sequence: int
    missed: int
    age: float
    measured: float


def reception(frame: frames.Frame, ages: AgeEstimator, now: float, *, last: int = 0) -> Reception:
    """How `frame` came, after the one with sequence number `last`."""
    age = ages.age(frame.publisher, frame.stamp_ns * 1e-9, now)
    return Reception(
        publisher=frame.publisher,
        sequence=frame.sequence,
        missed=frame.sequence - last - 1 if last else 0,
        age=age,
        measured=now - age,
    )


def decode(definition: MessageDefinition[Any], frame: frames.Frame) -> Any:
    """The value in a frame that should be of `definition`.

    Raises:
        CodecError: It is another message, in another format, or malformed.
    """
    if frame.name != definition.name or frame.fingerprint != definition.fingerprint:
        text = f"{frame.name} came where {definition.name} in its own format was expected"
        raise CodecError(text)
    return definition.decode(frame.payload)


@dataclass(slots=True)
class _Subscription:
    definition: MessageDefinition[Any]
    handlers: list[Callable[[Any, Reception], None]]
    last: dict[int, int]


class Broadcasts:
    """The broadcast sockets of one client; owned by the client's thread."""

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        poller: zmq.Poller,
        ages: AgeEstimator,
        complaints: Complaints,
        clock: Callable[[], float],
    ) -> None:
        self._context = context
        self._poller = poller
        self._ages = ages
        self._complaints = complaints
        self._clock = clock
        self._sending: dict[Plane, zmq.Socket[bytes]] = {}
        self._receiving: dict[Plane, zmq.Socket[bytes]] = {}
        self._subscriptions: dict[str, _Subscription] = {}
        self._taken: deque[tuple[_Subscription, frames.Frame]] = deque()

    @property
    def waiting(self) -> bool:
        """Whether messages were taken but not handed on yet, because a handler failed."""
        return bool(self._taken)

    def connect(self, addresses: Sequence[str]) -> None:
        """Connect to a new run of central: for each plane where to send and where to receive."""
        self.close()
        self._ages.forget()
        for index, plane in enumerate(sockets.PLANES):
            queue = sockets.QUEUE[plane]
            self._sending[plane] = sockets.make(self._context, zmq.PUB, queue)
            sockets.connect(self._sending[plane], addresses[2 * index])
            self._receiving[plane] = sockets.make(self._context, zmq.SUB, queue)
            sockets.connect(self._receiving[plane], addresses[2 * index + 1])
            self._poller.register(self._receiving[plane], zmq.POLLIN)
        for subscription in self._subscriptions.values():
            subscription.last.clear()
            self._listen_for(subscription.definition)

    def close(self, linger_ms: int = 0) -> None:
        """Drop the connections; what was just sent gets `linger_ms` to leave."""
        for socket in self._receiving.values():
            self._poller.unregister(socket)
            socket.close(0)
        for socket in self._sending.values():
            socket.close(linger_ms)
        self._receiving.clear()
        self._sending.clear()

    def send(self, definition: MessageDefinition[Any], frame: bytes) -> None:
        """Send to all who subscribe; never waits."""
        socket = self._sending.get(definition.plane)
        if socket is None:
            return
        try:
            socket.send(frame, zmq.NOBLOCK)
        except zmq.Again:
            self._complaints.count("not sent", f"{definition.name}: no connection to central")

    def subscribe(
        self, definition: MessageDefinition[Any], handler: Callable[[Any, Reception], None]
    ) -> None:
        """Call `handler` for every message of `definition`."""
        known = self._subscriptions.get(definition.name)
        if known is not None:
            known.handlers.append(handler)
            return
        self._subscriptions[definition.name] = _Subscription(definition, [handler], {})
        self._listen_for(definition)

    def _listen_for(self, definition: MessageDefinition[Any]) -> None:
        if definition.plane in self._receiving:
            self._receiving[definition.plane].subscribe(frames.topic(definition.name))

    def receive(self, ready: dict[Any, int]) -> None:
        """Hand on what the ready sockets hold."""
        self._deliver_taken()
        # Commands first: they must not wait behind a burst of states.
        for plane in (Plane.COMMAND, Plane.STATE):
            socket = self._receiving.get(plane)
            if socket is not None and socket in ready:
                self._receive(socket)

    def _receive(self, socket: zmq.Socket[bytes]) -> None:
        """Take a batch; of a message that keeps the newest, only the newest is handed on."""
        batch: dict[object, tuple[_Subscription, frames.Frame]] = {}
        for index in range(_BATCH):
            try:
                frame = frames.unpack(socket.recv(zmq.NOBLOCK))
            except zmq.Again:
                break
            except FrameError as error:
                self._complaints.count("malformed frame", str(error))
                continue
            subscription = self._subscriptions.get(frame.name)
            if subscription is None:
                continue
            newest = subscription.definition.keep is Keep.NEWEST
            key: object = (frame.name, frame.publisher) if newest else index
            batch.pop(key, None)
            batch[key] = (subscription, frame)
        self._taken.extend(batch.values())
        self._deliver_taken()

    def _deliver_taken(self) -> None:
        # One by one from a queue: after a handler that raises, the rest is still there.
        while self._taken:
            self._deliver(*self._taken.popleft())

    def _deliver(self, subscription: _Subscription, frame: frames.Frame) -> None:
        last = subscription.last.get(frame.publisher, 0)
        if frame.sequence <= last:
            detail = f"{frame.name} {frame.sequence} after {last}"
            self._complaints.count("out of order", detail)
            return
        try:
            value = decode(subscription.definition, frame)
        except CodecError as error:
            self._complaints.count("wrong format", str(error))
            return
        how = reception(frame, self._ages, self._clock(), last=last)
        if how.age > subscription.definition.lifespan_s:
            self._complaints.count("too old", f"{frame.name} is {how.age:.2f} s old")
            return
        if len(subscription.last) >= _MAX_PUBLISHERS:
            subscription.last.clear()
        subscription.last[frame.publisher] = frame.sequence
        for handler in subscription.handlers:
            handler(value, how)
