"""One message that a client publishes: numbered, framed, and handed to the send queue.

| state | a published message |
| --- | --- |
| without central | is counted as not sent |
| advertised, without central's answer | is held back |
| a subscriber is announced, its subscription under way | is held back, for `_HOLD_S` at most |
| open | goes to the send queue, or into shared memory and its descriptor to the queue |
"""

from __future__ import annotations

import math
import struct
from collections import deque
from collections.abc import Sequence
from typing import Any

from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.formats.codegen import Buffer
from hub.ipc.node.connection import NEVER, Connection
from hub.ipc.node.send_queue import Send, SendQueue
from hub.ipc.transport import shared_ring, sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.wire import control, frames

_HOLD_S = 2.0
"""Longest wait for a subscription that central announced [s]."""
_BURST_S = 200e-6
"""Longest time between two messages of a burst, on average [s]."""
_BATCH_ITEMS = 48
_BATCH_DESCRIPTORS = 16
_MAX_ITEM = 2048
"""Longest payload that gains by a shared frame [bytes]."""
_UNFIT = (struct.error, AttributeError, TypeError, ValueError, OverflowError)


class Publisher:
    """One message of a client.

    Attributes:
        definition: The message.
        direct: The subscribers on this machine that get the message itself.
        direct_in_ring: The subscribers that get a descriptor of shared memory.
        topic: Topic of all other subscribers, at central.
    """

    def __init__(
        self,
        definition: MessageDefinition[Any],
        connection: Connection,
        queue: SendQueue,
        transport: ClientTransport,
    ) -> None:
        self.definition = definition
        self._connection = connection
        self._hub_time = connection.hub_time
        self._queue = queue
        self._combine = self._combined
        self._clock = transport.clock
        self._faults = transport.faults
        self._plane = definition.plane
        self.direct: tuple[Send, ...] = ()
        self.direct_in_ring: tuple[Send, ...] = ()
        self._ring_prefix = frames.prefix(definition.name, frames.RING)
        self.sequence = 0
        self._emitted = 0.0
        self._reported, self._reported_at, self._bytes = 0, transport.clock(), 0
        self._published = -math.inf
        # Commands never join a burst; of pictures only descriptors do.
        self._burst = 2 * _BURST_S if definition.plane is Plane.STATE else 0.0
        self._limit = _BATCH_ITEMS if definition.plane is Plane.STATE else _BATCH_DESCRIPTORS
        self._last: bytes | tuple[int, int, bytes | shared_ring.Place] | None = None
        self._last_is_item = False
        self.ring = shared_ring.GrowingRing()
        self.held: deque[tuple[int, int, bytes]] | None = None
        self._open = False
        self._open_by = 0.0
        self._flat: frames.FlatFrames | None = None
        self._flat_length = 0
        if definition.flat_letters is not None:
            self._take_apart = definition.flat_values
        self._address()

    @property
    def unanswered(self) -> bool:
        """Whether central's answer to ADVERTISE is missing."""
        return self.held is not None and self._open_by == 0.0

    @property
    def holding(self) -> bool:
        """Whether messages are held back."""
        return bool(self.held)

    @property
    def wanted(self) -> bool:
        """Whether the message has subscribers that it reaches by now."""
        known = self.direct or self.direct_in_ring or self.topic in self._queue.topics
        return self._open and bool(known)

    def publish(self, value: Any, measured: float | None) -> None:
        """Send to all subscribers.

        Raises:
            CodecError: The value does not fit the format.
        """
        flat = self._flat
        if flat is None or not self._open:
            self.publish_payload(self.definition.encode(value), measured)
            return
        now, queue = self._clock(), self._queue
        when = now if measured is None else measured
        stamp = int((when + self._hub_time.least) * 1e9)
        sequence = self.sequence + 1
        try:
            values = self._take_apart(value)
            burst = now - queue.second_last < self._burst
            item = burst and queue.latest is self
            if item:
                frame = flat.pack_item(stamp, values)
            else:
                frame = flat.pack(self._connection.publisher, sequence, stamp, values)
        except _UNFIT:  # the general encoder takes it, or its error names the field
            self.publish_payload(self.definition.encode(value), measured)
            return
        self.sequence = sequence
        queue.second_last, queue.last = queue.last, now
        self._published = now
        self._bytes += self._flat_length
        self._last, self._last_is_item = frame, item
        queue.latest = self
        if burst:
            queue.add(self._combine, sequence if item else 0, frame, now, self._limit)
        else:
            queue.send(frame, self.direct, self.topic, self._plane)

    def publish_payload(self, payload: Sequence[Buffer], measured: float | None) -> None:
        """Send a payload, given in pieces, to all subscribers."""
        now = self._clock()
        stamp = int(((now if measured is None else measured) + self._hub_time.least) * 1e9)
        length = frames.size(payload)
        self.count(length, now)
        queue = self._queue
        burst = now - queue.second_last < self._burst and length <= _MAX_ITEM
        if self._open and burst:
            item = frames.pack_item(stamp, payload)
            self._last, self._last_is_item = item, True
            queue.add(self._combine, self.sequence, item, now, self._limit)
        elif (held := self.held) is not None:
            self._hold(held, stamp, payload)
        else:
            self._emit(self.sequence, stamp, payload)
        queue.second_last, queue.last = queue.last, now

    def count(self, length: int, now: float) -> None:
        """Count a message of this length [bytes], sent now [s]."""
        self.sequence += 1
        self._published = now
        self._bytes += length

    def advertised(self, *, subscribed: bool, now: float) -> None:
        """Handle the answer to ADVERTISE; wait for an announced subscription."""
        if self.held is None:
            return
        if not subscribed or self.topic in self._queue.topics:
            self._release()
        else:
            self._open_by = now + _HOLD_S

    def check_open(self, now: float) -> None:
        """Open if the announced subscription has arrived, or is late."""
        if self.held is not None and self._open_by > 0.0:
            late = now > self._open_by
            if late:
                text = f"{self.definition.name}: a subscription was announced and did not come"
                self._faults.count("subscription missing", text)
            if late or self.topic in self._queue.topics:
                self._release()

    def begin(self) -> None:
        """Hold messages until a new central reports the subscribers."""
        self._address()
        self._open_by = 0.0
        self._open = False
        self.held = deque(maxlen=sockets.QUEUE[self._plane])

    def end(self) -> None:
        """Drop the held messages after the loss of central: they would be old."""
        for _ in self.held or ():
            self._not_sent("the hub was gone before it listed the subscribers")
        self.held = None
        self._open = False
        self.direct = self.direct_in_ring = ()

    def report(self, now: float) -> control.Published | None:
        """The publications since the last report; None: there are none."""
        messages, over_s = self.sequence - self._reported, now - self._reported_at
        self._reported, self._reported_at = self.sequence, now
        if not messages:
            return None
        size, self._bytes = self._bytes, 0
        return control.Published(
            name=self.definition.name,
            messages=messages,
            bytes=size,
            over_s=over_s,
            silent_s=now - self._published,
        )

    def last(self) -> bytes | None:
        """The last message as a frame with its payload; None: there is none."""
        frame = self._last_frame()
        return None if frame is None or len(frame) > frames.MAX_FRAME else frame

    def _last_frame(self) -> bytes | None:
        last = self._last
        if last is None:
            return None
        if isinstance(last, bytes):
            if self._last_is_item:
                stamp, payload = frames.item_payload(last)
                return self._frame(self.sequence, stamp, [payload])
            old = frames.unpack(last)  # the client's number may have changed
            return self._frame(old.sequence, old.stamp_ns, [old.payload])
        sequence, stamp, kept = last
        if isinstance(kept, shared_ring.Place):
            found = self.ring.read(kept)
            return None if found is None else self._frame(sequence, stamp, [found])
        return self._frame(sequence, stamp, [kept])

    def _combined(
        self, first: int, items: Sequence[bytes]
    ) -> tuple[bytes, tuple[Send, ...], bytes, Plane]:
        """One frame of several messages; see `send_queue.Combine`."""
        if first == 0:
            return items[0], self.direct, self.topic, self._plane
        if self._plane is not Plane.PICTURE:
            stamp, kind, payload = frames.joined(items)
            frame = self._frame(first, stamp, payload, kind=kind)
            return frame, self.direct, self.topic, self._plane
        kind, prefix = frames.RING_BATCH, self._ring_prefix
        frame = self._frame(first, 0, frames.batch(items), kind=kind, prefix=prefix)
        return frame, self.direct_in_ring, b"", self._plane

    def close(self) -> None:
        """Free the ring."""
        self.ring.close()

    def _address(self) -> None:
        """Set the topic: it shows whether this client also sends to subscribers directly."""
        kind = b"" if self._connection.near else frames.FAR
        name, letters = self.definition.name, self.definition.flat_letters
        self.topic, self._prefix = frames.topic(name, kind), frames.prefix(name, kind)
        if letters is not None and self._plane is not Plane.PICTURE:
            self._flat = frames.FlatFrames(self._prefix, self.definition.fingerprint, letters)
            self._flat_length = self._flat.length

    def _hold(
        self, held: deque[tuple[int, int, bytes]], stamp: int, payload: Sequence[Buffer]
    ) -> None:
        if held.maxlen == len(held):
            self._not_sent("central does not list the subscribers")
        # Joined: the pieces may be views of changing data.
        held.append(last := (self.sequence, stamp, b"".join(payload)))
        self._last = last

    def _not_sent(self, why: str) -> None:
        """Count a lost message here: subscribers cannot, because the client's number changes."""
        self._faults.count("not sent", f"{self.definition.name}: {why}")

    def _release(self) -> None:
        held, self.held = self.held or (), None
        self._open = True
        for sequence, stamp, payload in held:
            self._emit(sequence, stamp, [payload])

    def _emit(self, sequence: int, stamp: int, payload: Sequence[Buffer]) -> None:
        if self.direct_in_ring:
            self._emit_in_ring(sequence, stamp, payload)
            if not self.direct and self.topic not in self._queue.topics:
                return
        frame = self._frame(sequence, stamp, payload)
        self._last, self._last_is_item = frame, False
        if len(frame) > frames.MAX_FRAME:  # the receiver would end the connection
            text = f"{self.definition.name}: {len(frame)} bytes; at most {frames.MAX_FRAME} can go"
            self._faults.count("too long", text)
        elif self._open:
            self._queue.send(frame, self.direct, self.topic, self._plane)
        elif self._connection.joined != NEVER:  # before that none can miss it
            self._not_sent("there is no hub")

    def _emit_in_ring(self, sequence: int, stamp: int, payload: Sequence[Buffer]) -> None:
        place = self._write(payload)
        now = self._clock()
        burst, self._emitted = now - self._emitted < _BURST_S, now
        kind, descriptor = frames.NO_RING, b""
        if place is None:
            self._last = (sequence, stamp, b"".join(payload))
        else:
            self._last = (sequence, stamp, place)
            kind, descriptor = frames.IN_RING, place.pack()
            if burst:
                item = frames.pack_item(stamp, [descriptor])
                self._queue.add(self._combine, sequence, item, now, self._limit)
                return
        frame = self._frame(sequence, stamp, (descriptor,), kind=kind, prefix=self._ring_prefix)
        self._queue.send(frame, self.direct_in_ring, b"", self._plane)

    def _write(self, payload: Sequence[Buffer]) -> shared_ring.Place | None:
        """Put a payload into the ring; None: there is no ring."""
        if not shared_ring.available:
            return None
        try:
            return self.ring.write(payload, frames.size(payload))
        except OSError as error:
            self._faults.count("no shared memory", f"{self.definition.name}: {error}")
            return None

    def _frame(
        self,
        sequence: int,
        stamp: int,
        payload: Sequence[Buffer],
        *,
        kind: int = frames.INLINE,
        prefix: bytes = b"",
    ) -> bytes:
        return frames.pack(
            prefix or self._prefix,
            publisher=self._connection.publisher,
            fingerprint=self.definition.fingerprint,
            sequence=sequence,
            stamp_ns=stamp,
            payload=payload,
            kind=kind,
        )
