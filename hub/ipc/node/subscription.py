"""One message that a client subscribes to: its handlers, its publishers, and its reading."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

from hub.errors import CodecError
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.message_info import MessageInfo
from hub.ipc.wire import control, frames

Handler = Callable[[Any, MessageInfo], None]

_MAX_PUBLISHERS = 256
_MAX_JUMP = 1 << 24
_RESYNC_COUNT = 3
"""Number of impossible numbers in a row that are accepted: then an earlier one was wrong."""


class Source:
    """One publisher of one message.

    Attributes:
        arrived: Number of the last message that arrived.
        handed_on: Number of the last message that was handed on.
        waiting: Waiting messages, where their number is limited.
    """

    __slots__ = ("_refused_count", "_refused_number", "arrived", "handed_on", "waiting")

    def __init__(self) -> None:
        self.arrived = 0
        self.handed_on = 0
        self.waiting: deque[Any] = deque()
        self._refused_number = self._refused_count = 0

    def accepts(self, sequence: int) -> bool:
        """Whether a message may have this number.

        A number that was used or is far away is refused. `_RESYNC_COUNT` of them in a row are
        accepted: then an earlier one was wrong. So a damaged frame costs only a few messages.
        """
        if self.arrived < sequence <= self.arrived + _MAX_JUMP or (not self.arrived and sequence):
            self._refused_count = 0
            return True
        self._refused_count = self._refused_count + 1 if sequence == self._refused_number + 1 else 1
        self._refused_number = sequence
        if self._refused_count < _RESYNC_COUNT:
            return False
        self._refused_count = 0
        self.arrived, self.handed_on = sequence - 1, 0
        return True


class ReceivedFrame(NamedTuple):
    """The content of one frame.

    Attributes:
        publisher: Number of the sender's connection.
        first: Sequence number of the first message.
        kind: Kind of the frame.
        messages: For each message its stamp on the hub's clock [ns], and its payload or, of a flat
            format, its numbers.
    """

    publisher: int
    first: int
    kind: int
    messages: list[tuple[int, memoryview | tuple[Any, ...]]]


_JUST_NOW = 1 << 62


class Subscription:
    """One message that a client subscribes to.

    Attributes:
        definition: The message.
        handlers: The handlers.
        limit: Most waiting messages of each publisher; the oldest are dropped. None: no limit.
        priority: Higher ones are handed on first.
        in_ring: Whether it asks for descriptors.
        token: Of the subscription under way; empty: it is complete.
        received: Messages handed on.
        lost: Messages that did not arrive, by the sequence numbers.
        expired: Messages that were too old.
        refused: Messages with a value out of its range.
        unfit: The first fault in a value, in a sentence; empty: none.
        oldest: Largest age since the last report [s].
        late: Gets each message that was too old; None: nothing does.
        flat: Reads direct messages of a flat format; None for any other format.
        is_command: Whether its senders show tickets.
        unordered: Whether every frame counts, even with a wrong header.
        raw: Whether handlers get payloads, undecoded and of any age.
        label: What a subscriber that gathers calls it; None: it does not.
    """

    def __init__(self, definition: MessageDefinition[Any], *, raw: bool = False) -> None:
        self.definition = definition
        self.raw = raw
        self.label: Any = None
        self.handlers: list[Handler] = []
        self.limit: int | None = 1 if definition.keep is Keep.NEWEST and not raw else None
        self.priority = 0
        self.in_ring = False
        self.token = ""
        self.received = self.lost = self.expired = self.refused = 0
        self.unfit = ""
        self.oldest = 0.0
        self.late: Handler | None = None
        self.lifespan_s = math.inf if raw else definition.lifespan_s
        self.unordered = definition.unreadable is not None and not raw
        self.is_command = definition.plane is Plane.COMMAND and definition.unreadable is None
        self._sources: dict[int, Source] = {}
        self._reported = (0, 0, 0, 0)
        self._fingerprint = definition.fingerprint
        self._name = definition.name
        self._start = len(frames.prefix(definition.name))
        self._starts = {
            kind[0]: len(frames.prefix(definition.name, kind)) for kind in (frames.FAR, frames.RING)
        }
        self.flat: frames.FlatFrames | None = None
        self.receive: Callable[..., Any] | None = None
        if definition.flat_letters is not None and not raw:
            prefix = frames.prefix(definition.name)
            self.flat = frames.FlatFrames(prefix, self._fingerprint, definition.flat_letters)
            self.receive = definition.receive_flat

    def forget(self) -> None:
        """Forget the publishers: their numbers have new owners."""
        self._sources.clear()

    def source(self, publisher: int) -> Source:
        """The publisher of this number."""
        known = self._sources.get(publisher)
        if known is None:
            if len(self._sources) >= _MAX_PUBLISHERS:
                self._sources.clear()
            known = self._sources[publisher] = Source()
        return known

    def read(self, raw: bytes) -> ReceivedFrame:
        """The content of a frame of this message.

        Raises:
            FrameError: It is no frame.
            CodecError: It is in another format.
        """
        start = self._starts.get(raw[0], self._start)
        if len(raw) < start + frames.HEADER_SIZE:
            frame = frames.unpack(raw)
            payload, kind = frame.payload, frame.kind
            publisher, sequence, stamp = frame.publisher, frame.sequence, frame.stamp_ns
            fingerprint = frame.fingerprint
        else:
            header = frames.read_header(raw, start)
            version, kind, publisher, fingerprint, sequence, stamp, length = header
            payload = memoryview(raw)[start + frames.HEADER_SIZE :]
            in_ring = raw[:1] == frames.RING
            if (
                version != frames.VERSION
                or length != len(payload)
                or kind > frames.RING_BATCH
                or (kind in frames.RING_KINDS) != in_ring
            ):
                frames.unpack(raw)  # raises the reason
        if fingerprint != self._fingerprint:
            text = f"{self._name} came in another format"
            raise CodecError(text)
        if kind == frames.INLINE:
            message = (self.flat and self.flat.values(payload)) or payload
            return ReceivedFrame(publisher, sequence, kind, [(stamp, message)])
        if kind == frames.BATCH:
            messages: Any = self.flat.items(payload) if self.flat else None
            if messages is None:
                messages = frames.items(payload)
            return ReceivedFrame(publisher, sequence, frames.INLINE, messages)
        if kind == frames.RING_BATCH:
            descriptors: Any = frames.items(payload)
            return ReceivedFrame(publisher, sequence, frames.IN_RING, descriptors)
        return ReceivedFrame(publisher, sequence, kind, [(stamp, payload)])

    def unreadable(self) -> ReceivedFrame | None:
        """The replacement of an unreadable frame; None: there is none."""
        if not self.unordered:
            return None
        return ReceivedFrame(0, 0, frames.INLINE, [(_JUST_NOW, memoryview(b""))])

    def report(self) -> control.Received | None:
        """The receptions since the last report; None: there are none."""
        now = (self.received, self.lost, self.expired, self.refused)
        if now == self._reported:
            return None
        before, self._reported = self._reported, now
        oldest, self.oldest = self.oldest, 0.0
        return control.Received(
            name=self._name,
            received=now[0] - before[0],
            lost=now[1] - before[1],
            expired=now[2] - before[2],
            refused=now[3] - before[3],
            oldest_s=oldest,
        )
