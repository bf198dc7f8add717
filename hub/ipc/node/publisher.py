"""Where one message leaves a client: alone, with others of a burst, or through shared memory."""

from __future__ import annotations

import math
import struct
import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.formats.codegen import Buffer
from hub.ipc.node.connection import Connection
from hub.ipc.node.direct_deliveries import DirectReceivers, Take
from hub.ipc.transport import shared_ring, sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control, frames

_HOLD_S = 2.0
"""Central says that somebody has subscribed; his subscription must have come after this [s]."""
_BURST_S = 200e-6
"""What is published so soon after the last one belongs to a burst [s]."""
_BATCH_ITEMS = 48
_BATCH_DESCRIPTORS = 16
BATCH_S = 0.5e-3
"""How long a message of a burst may wait for more while its module is busy elsewhere [s]."""
_MAX_ITEM = 2048
"""Longer payloads gain nothing by travelling together [bytes]."""
_UNFIT = (struct.error, AttributeError, TypeError, ValueError, OverflowError)


class Batch:
    """Messages that wait to be sent together; used under its lock.

    Attributes:
        lock: Guards it, and the sockets.
        runs: The messages, those of one publisher that follow each other together: the
            publisher, the sequence number of the first, and each; or the publisher, 0 and a
            whole frame.
        count: How many messages wait.
        since: When the first began to wait [s].
        previous: When the last one was published, whether it waits or not [s].
        latest: Whose message was the last one: one by one, frames of their own cost less.
        called: Whether the thread that sends what waits is on its way.
    """

    __slots__ = ("called", "count", "latest", "lock", "previous", "runs", "since")

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.runs: list[tuple[Publisher, int, list[bytes]]] = []
        self.latest: Publisher | None = None
        self.count = 0
        self.since = self.previous = 0.0
        self.called = False


class PublisherHost(Protocol):
    """What a publisher needs of the client's sockets."""

    connection: Connection
    clock: Callable[[], float]
    faults: FaultCounter
    near: bool
    batch: Batch

    def send(self, publisher: Publisher, frame: bytes, *, place: bool = False) -> None:
        """Send behind what waits to all who want a publisher's message itself, or its place."""

    def send_batch(self) -> None:
        """Send what waits; the lock is held."""

    def call_courier(self) -> None:
        """Have what waits sent in a moment."""

    def is_wanted(self, topic: bytes) -> bool:
        """Whether somebody at central subscribes to the topic."""


class Publisher:
    """Where one message leaves this client.

    Attributes:
        definition: The message.
        takers: The neighbours that it goes to.
        topic: What others subscribe to at central.
    """

    def __init__(self, definition: MessageDefinition[Any], ways: PublisherHost) -> None:
        self.definition = definition
        self._ways = ways
        self._connection = ways.connection
        self._hub_time = ways.connection.hub_time
        self._batch = ways.batch
        self._clock = ways.clock
        self._plane = definition.plane
        self.takers = DirectReceivers()
        self._ring_prefix = frames.prefix(definition.name, frames.RING)
        self._sequence = 0
        self._emitted = 0.0
        self._told, self._told_at, self._bytes = 0, ways.clock(), 0
        self._published = -math.inf
        # Commands never wait for others; of pictures only descriptors do.
        self._burst = _BURST_S if definition.plane is Plane.STATE else 0.0
        self._most = _BATCH_ITEMS if definition.plane is Plane.STATE else _BATCH_DESCRIPTORS
        self._last: bytes | tuple[int, int, bytes | shared_ring.Place] | None = None
        self._last_is_item = False
        self._ring: shared_ring.RingWriter | None = None
        self._held: deque[tuple[int, int, bytes]] | None = None
        self._open = False
        self._open_by = 0.0
        self._flat: frames.FlatFrames | None = None
        self._flat_length = 0
        if definition.flat_letters is not None:
            self._take_apart = definition.flat_values
        self._address()

    @property
    def unanswered(self) -> bool:
        """Whether central has not said yet that it has noted us."""
        return self._held is not None and self._open_by == 0.0

    @property
    def holding(self) -> bool:
        """Whether messages wait until the way is open."""
        return bool(self._held)

    @property
    def wanted(self) -> bool:
        """Whether somebody subscribes, as far as the way is open."""
        return any(self.takers) or self._ways.is_wanted(self.topic)

    def publish(self, value: Any, measured: float | None) -> None:
        """Send to all who subscribe.

        Raises:
            CodecError: The value does not fit the format.
        """
        flat = self._flat
        if flat is None or not self._open:
            self.publish_payload(self.definition.encode(value), measured)
            return
        now, batch = self._clock(), self._batch
        when = now if measured is None else measured
        stamp = int((when + self._hub_time.offset) * 1e9)
        sequence = self._sequence + 1
        try:
            values = self._take_apart(value)
            burst = now - batch.previous < self._burst
            item = burst and batch.latest is self
            if item:
                frame = flat.pack_item(stamp, values)
            else:
                frame = flat.pack(self._connection.publisher, sequence, stamp, values)
        except _UNFIT:  # the other way says in our own words what is wrong, or takes it
            self.publish_payload(self.definition.encode(value), measured)
            return
        self._sequence = sequence
        self._published = batch.previous = now
        self._bytes += self._flat_length
        self._last, self._last_is_item = frame, item
        batch.latest = self
        if item:
            self._join(sequence, frame, now)
        elif burst:
            self._join_frame(frame, now)
        else:
            self._ways.send(self, frame)

    def publish_payload(self, payload: Sequence[Buffer], measured: float | None) -> None:
        """Send a payload, given in pieces, to all who subscribe."""
        now = self._clock()
        when = now if measured is None else measured
        stamp = int((when + self._hub_time.offset) * 1e9)
        self._sequence += 1
        self._published = now
        length = frames.size(payload)
        self._bytes += length
        burst = now - self._batch.previous < self._burst and length <= _MAX_ITEM
        if self._open and burst:
            item = frames.pack_item(stamp, payload)
            self._last, self._last_is_item = item, True
            self._join(self._sequence, item, now)
        elif self._held is not None:
            self._hold(stamp, payload)
        else:
            self._emit(self._sequence, stamp, payload)
        self._batch.previous = now

    def advertised(self, *, subscribed: bool, now: float) -> None:
        """Central has noted us; if somebody has subscribed, we wait for the subscription itself."""
        if self._held is None:
            return
        if not subscribed or self._ways.is_wanted(self.topic):
            self._release()
        else:
            self._open_by = now + _HOLD_S

    def look(self, now: float) -> None:
        """Subscriptions have come, or time has passed."""
        if self._held is not None and self._open_by > 0.0:
            late = now > self._open_by
            if late:
                text = f"{self.definition.name}: a subscription was announced and did not come"
                self._ways.faults.count("subscription missing", text)
            if late or self._ways.is_wanted(self.topic):
                self._release()

    def begin(self) -> None:
        """A central that does not know us: nothing is sent before it says who has subscribed."""
        self._address()
        self._open_by = 0.0
        self._open = False
        self._held = deque(maxlen=sockets.QUEUE[self._plane])

    def end(self) -> None:
        """Central is gone; what waited for it would be old."""
        for _ in self._held or ():
            self._not_sent("the hub was gone before it said who has subscribed")
        self._held = None
        self._open = False
        self.takers = DirectReceivers()

    def report(self, now: float) -> control.Published | None:
        """What was published since the last time; None if nothing."""
        messages, over_s = self._sequence - self._told, now - self._told_at
        self._told, self._told_at = self._sequence, now
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
        """The last message as a frame with its payload; None if there is none any more."""
        frame = self._last_frame()
        return None if frame is None or len(frame) > frames.MAX_FRAME else frame

    def _last_frame(self) -> bytes | None:
        last = self._last
        if last is None:
            return None
        if isinstance(last, bytes):
            if self._last_is_item:
                stamp, payload = frames.item_payload(last)
                return self._frame(self._sequence, stamp, [payload])
            old = frames.unpack(last)  # perhaps from before we had this number
            return self._frame(old.sequence, old.stamp_ns, [old.payload])
        sequence, stamp, kept = last
        if isinstance(kept, shared_ring.Place):
            found = self._ring.read(kept) if self._ring else None
            return None if found is None else self._frame(sequence, stamp, [found])
        return self._frame(sequence, stamp, [kept])

    def run(self, first: int, items: Sequence[bytes]) -> tuple[bytes, tuple[Take, ...], bytes]:
        """Several messages, the first of which has the number `first`, or a frame that is whole.

        Returns:
            A frame for them; which neighbours take it; and under which topic others do, if any may.
        """
        if first == 0:
            return items[0], self.takers.whole, self.topic
        payload = frames.batch(items)
        if self._plane is not Plane.PICTURE:
            frame = self._frame(first, 0, payload, kind=frames.BATCH)
            return frame, self.takers.whole, self.topic
        kind, prefix = frames.RING_BATCH, self._ring_prefix
        frame = self._frame(first, 0, payload, kind=kind, prefix=prefix)
        return frame, self.takers.in_ring, b""

    def close(self) -> None:
        """Free the ring."""
        if self._ring is not None:
            self._ring.close()
            self._ring = None

    def _address(self) -> None:
        """Whom our frames are for: by neighbours they are told apart from those of others."""
        kind = b"" if self._ways.near else frames.FAR
        name, letters = self.definition.name, self.definition.flat_letters
        self.topic, self._prefix = frames.topic(name, kind), frames.prefix(name, kind)
        if letters is not None and self._plane is not Plane.PICTURE:
            self._flat = frames.FlatFrames(self._prefix, self.definition.fingerprint, letters)
            self._flat_length = self._flat.length

    def _join(self, sequence: int, item: bytes, now: float) -> None:
        """Send one message together with those that follow at once."""
        batch = self._batch
        with batch.lock:
            runs = batch.runs
            if runs and runs[-1][0] is self and runs[-1][1]:
                runs[-1][2].append(item)
            else:
                self._begin(now)
                runs.append((self, sequence, [item]))
            self._grow(now)

    def _join_frame(self, frame: bytes, now: float) -> None:
        """Send a whole frame together with others that follow at once."""
        batch = self._batch
        with batch.lock:
            self._begin(now)
            batch.runs.append((self, 0, [frame]))
            self._grow(now)

    def _begin(self, now: float) -> None:
        batch = self._batch
        if not batch.runs:
            batch.since = now
            if not batch.called:
                self._ways.call_courier()

    def _grow(self, now: float) -> None:
        batch = self._batch
        batch.count += 1
        if batch.count >= self._most or now - batch.since > BATCH_S:
            self._ways.send_batch()

    def _hold(self, stamp: int, payload: Sequence[Buffer]) -> None:
        held = self._held
        if held is None:
            return
        if held.maxlen == len(held):
            self._not_sent("central does not say who has subscribed")
        whole = b"".join(payload)  # the pieces may be views of what changes meanwhile
        self._last = (self._sequence, stamp, whole)
        held.append(self._last)

    def _not_sent(self, why: str) -> None:
        """Nobody else can count this: with the connection, its publisher's number changes."""
        self._ways.faults.count("not sent", f"{self.definition.name}: {why}")

    def _release(self) -> None:
        held, self._held = self._held or (), None
        self._open = True
        for sequence, stamp, payload in held:
            self._emit(sequence, stamp, [payload])

    def _emit(self, sequence: int, stamp: int, payload: Sequence[Buffer]) -> None:
        if self.takers.in_ring:
            self._emit_in_ring(sequence, stamp, payload)
            if not self.takers.whole and not self._ways.is_wanted(self.topic):
                return
        frame = self._frame(sequence, stamp, payload)
        self._last, self._last_is_item = frame, False
        if len(frame) > frames.MAX_FRAME:  # whoever gets that ends the connection
            text = f"{self.definition.name}: {len(frame)} bytes; at most {frames.MAX_FRAME} can go"
            self._ways.faults.count("too long", text)
        elif self._open:
            self._ways.send(self, frame)
        else:
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
                self._join(sequence, frames.pack_item(stamp, [descriptor]), now)
                return
        frame = self._frame(sequence, stamp, (descriptor,), kind=kind, prefix=self._ring_prefix)
        self._ways.send(self, frame, place=True)

    def _write(self, payload: Sequence[Buffer]) -> shared_ring.Place | None:
        """Put it into the ring; None if there is none that takes it."""
        if not shared_ring.available:
            return None
        length = frames.size(payload)
        if self._ring is None or length > self._ring.capacity:
            self.close()
            try:
                self._ring = shared_ring.RingWriter(length)
            except OSError as error:
                text = f"{self.definition.name} goes the plain way: {error}"
                self._ways.faults.count("no shared memory", text)
                return None
        return self._ring.write(payload)

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
