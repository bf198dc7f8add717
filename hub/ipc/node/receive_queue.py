"""What came of the messages a client subscribes to: read, waiting, and handed to the handlers."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import zmq

from hub.errors import CodecError, FrameError, RangeError
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.subscription import Read, ReceivedFrame, Source, Subscription
from hub.ipc.transport import shared_ring, sockets
from hub.ipc.transport.clock_sync import ClockSync
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames

_BATCH = 256
_MOST_EVENTS = 2 * max(sockets.QUEUE.values())
"""What can wait on the way from one neighbour, at his end and at ours [frames]."""
_SLICE_S = 0.005
"""After so long of handling, what has come meanwhile is looked at: it may be more urgent [s]."""


def _topics(name: str) -> list[bytes]:
    """What stands before the NUL of a frame of this message."""
    return [frames.topic(name, kind)[:-1] for kind in (b"", frames.FAR, frames.RING)]


_new = tuple.__new__


class _Opened:
    """Messages of one publisher on their way to the handlers.

    Attributes:
        messages: Stamp [ns] and payload, or the numbers of a flat format, of each that is left.
        sequence: Number of the next.
        accepted: Whether their numbers were looked at before.
    """

    __slots__ = ("accepted", "inlet", "kind", "messages", "publisher", "sequence", "source")

    def __init__(
        self, inlet: Subscription, arrival: ReceivedFrame, *, accepted: bool = False
    ) -> None:
        self.inlet: Subscription | None = inlet
        self.publisher, self.sequence, self.kind, messages = arrival
        self.source = inlet.source(self.publisher)
        self.messages = iter(messages)
        self.accepted = accepted


class ReceiveQueue:
    """Everything that came to one client and was not handed on yet."""

    def __init__(
        self,
        *,
        clock: Callable[[], float],
        hub_time: ClockSync,
        complaints: FaultCounter,
        no_ring: Callable[[Subscription, str], None],
    ) -> None:
        """Nothing is taken before an inlet is added.

        Args:
            clock: Monotonic time [s].
            hub_time: What stamps are on.
            complaints: Where wrong frames and messages that come too late are counted.
            no_ring: Called when an inlet's payloads cannot be had from shared memory, with why.
        """
        self._clock = clock
        self._hub_time = hub_time
        self._complaints = complaints
        self._no_ring = no_ring
        self._topics: dict[bytes, Subscription] = {}
        self._waits = 0
        self._opened: list[_Opened] = []
        self._carriages: deque[bytes] = deque()
        self._queues: dict[int, deque[_Opened]] = {0: deque()}
        self._rings = shared_ring.Readers()

    @property
    def pending(self) -> bool:
        """Whether messages were taken from the sockets and not handed on yet."""
        return self._waits > 0 or bool(self._opened) or bool(self._carriages)

    def add(self, inlet: Subscription) -> None:
        """Take the frames of this message, or do so by another priority than before."""
        for topic in _topics(inlet.definition.name):
            self._topics[topic] = inlet
        if inlet.priority not in self._queues:
            self._queues[inlet.priority] = deque()
            self._queues = dict(sorted(self._queues.items(), reverse=True))

    def remove(self, inlet: Subscription) -> None:
        """Take them no longer; what waits goes to no handler if the inlet has none."""
        for topic in _topics(inlet.definition.name):
            del self._topics[topic]

    def close_rings(self) -> None:
        """Let go of all shared memory; what still waits there is opened again."""
        self._rings.close()

    def turn(self) -> None:
        """Hand on what waits."""
        self._finish()
        if self._waits:
            self._hand_on()

    def accept(self, inlet: Subscription, frame: frames.Frame) -> None:
        """Hand on a message that came another way, unless it or a later one has come already."""
        source = inlet.source(frame.publisher)
        if frame.sequence <= source.arrived:
            return
        read = self._decoded(inlet, frame.kind, frame.payload)
        if read is None:
            return
        source.arrived = frame.sequence
        self._deliver(inlet, source, frame.publisher, frame.sequence, frame.stamp_ns, read)

    def _finish(self) -> None:
        """Hand on what was begun: a handler that raised or listened itself has left it so."""
        while self._opened:
            self._hand_out(self._opened[-1])
        while self._carriages:
            self._take_frame(self._carriages.popleft())

    def take(self, socket: sockets.Socket) -> bool:
        """Take a batch from a socket; whether there may be more.

        What is kept in full and has no priority is handed on as it is read, as long as nothing
        waits; all else when everything was read, since something newer or more urgent may come.
        """
        self._finish()
        receive = socket.recv
        end = self._clock() + _SLICE_S
        for _ in range(_BATCH):
            try:
                raw = receive(zmq.NOBLOCK)
            except zmq.Again:
                return False
            if frames.is_train(raw):
                self._take_train(raw)
            else:
                self._take_frame(raw)
            if self._clock() > end:
                return True
        return True

    def take_events(self, socket: sockets.Socket) -> None:
        """Let what a socket holds of messages that are kept in full wait, and drop all else."""
        self._finish()
        for _ in range(_MOST_EVENTS):
            try:
                raw = socket.recv(zmq.NOBLOCK)
            except zmq.Again:
                return
            for each in self._taken_apart(raw) if frames.is_train(raw) else [raw]:
                inlet = self._topics.get(each[: each.find(b"\0")])
                if (
                    inlet is not None
                    and inlet.limit is None
                    and (arrival := self._read(inlet, each))
                ):
                    self._put(inlet, arrival)

    def _take_train(self, raw: bytes) -> None:
        self._carriages += self._taken_apart(raw)
        self._finish()

    def _taken_apart(self, train: bytes) -> list[bytes]:
        try:
            return frames.carriages(train)
        except FrameError as error:
            self._complaints.count("malformed frame", str(error))
            return []

    def _take_frame(self, raw: bytes) -> None:
        inlet = self._topics.get(raw[: raw.find(b"\0")])
        if inlet is None:
            self._strange(raw)
            return
        at_once = inlet.limit is None and inlet.priority == 0 and not self._waits
        if at_once and inlet.flat is not None and (found := inlet.flat.unpack(raw)):
            _, publisher, _, sequence, stamp_ns, _ = found[:6]
            source = inlet.source(publisher)
            read = self._decoded(inlet, frames.INLINE, found[6:])
            if read is not None and self._arrived(inlet, source, sequence):
                self._deliver(inlet, source, publisher, sequence, stamp_ns, read)
            return
        arrival = self._read(inlet, raw)
        if arrival is None:
            return
        if at_once:
            self._opened.append(_Opened(inlet, arrival))
            self._hand_out(self._opened[-1])
        else:
            self._put(inlet, arrival)

    def _read(self, inlet: Subscription, raw: bytes) -> ReceivedFrame | None:
        """What a frame brings; None, and counted, if it is malformed and stands for nothing."""
        try:
            return inlet.read(raw)
        except FrameError as error:
            self._complaints.count("malformed frame", str(error))
        except CodecError as error:
            self._complaints.count("wrong format", str(error))
        return inlet.unreadable()

    def _put(self, inlet: Subscription, arrival: ReceivedFrame) -> None:
        """Let messages wait; a limit lets the oldest of their publisher go."""
        publisher, sequence, kind, messages = arrival
        source = inlet.source(publisher)
        for number, (stamp_ns, message) in enumerate(messages, sequence):
            read: Any = message
            if kind == frames.INLINE:
                read = self._decoded(inlet, kind, message)
            if read is None or not self._arrived(inlet, source, number):
                continue
            one = ReceivedFrame(publisher, number, kind, [(stamp_ns, read)])
            waiting = _Opened(inlet, one, accepted=True)
            if inlet.limit is not None:
                if len(source.waiting) >= inlet.limit:
                    source.waiting.popleft().inlet = None
                source.waiting.append(waiting)
            self._queues[inlet.priority].append(waiting)
            self._waits += 1

    def _arrived(self, inlet: Subscription, source: Source, sequence: int) -> bool:
        """Whether a message of this number may be handed on; a gap before it is counted.

        Only for a message that was decoded, or that lies in a ring of this machine: a number that
        came with nonsense is not believed.
        """
        last = source.arrived
        if inlet.unordered:
            return True
        if sequence == last + 1 and last:
            source.arrived = sequence
            return True
        if not source.accepts(sequence):
            detail = f"{inlet.definition.name} {sequence} after {last}"
            self._complaints.count("out of order", detail)
            return False
        if source.arrived:
            inlet.lost += sequence - source.arrived - 1
        source.arrived = sequence
        return True

    def _strange(self, raw: bytes) -> None:
        """A frame that is none of ours, or came after it was unsubscribed."""
        try:
            frames.unpack(raw)
        except FrameError as error:
            self._complaints.count("malformed frame", str(error))

    def _hand_on(self) -> None:
        """Hand on what waits, most urgent first; after a while, look what has come meanwhile."""
        end = self._clock() + _SLICE_S
        for queue in self._queues.values():
            while queue:
                waiting = queue.popleft()
                self._waits -= 1
                if waiting.inlet is None:
                    continue  # a newer one came
                if waiting.source.waiting and waiting.source.waiting[0] is waiting:
                    waiting.source.waiting.popleft()
                self._opened.append(waiting)
                self._hand_out(waiting)
                if self._clock() > end:
                    return

    def _hand_out(self, opened: _Opened) -> None:
        """Hand messages to their handlers; after one that raises, the rest comes later."""
        inlet, source, publisher = opened.inlet, opened.source, opened.publisher
        if inlet is None:
            return
        for stamp_ns, message in opened.messages:
            sequence = opened.sequence
            opened.sequence = sequence + 1
            read = self._accepted(opened, inlet, sequence, message)
            if read is not None:
                self._deliver(inlet, source, publisher, sequence, stamp_ns, read)
        if opened in self._opened:  # not if a handler listened, and so had the rest handed out
            self._opened.remove(opened)

    def _accepted(
        self, opened: _Opened, inlet: Subscription, sequence: int, message: Any
    ) -> Read | None:
        """A message that is to be handed on; None if it cannot be read, or came before."""
        if opened.kind != frames.INLINE:
            if opened.accepted or self._arrived(inlet, opened.source, sequence):
                return self._decoded(inlet, opened.kind, message)
            return None
        if opened.accepted:
            known: Read = message
            return known
        read = self._decoded(inlet, frames.INLINE, message)
        if read is not None and self._arrived(inlet, opened.source, sequence):
            return read
        return None

    def _deliver(
        self,
        inlet: Subscription,
        source: Source,
        publisher: int,
        sequence: int,
        stamp_ns: int,
        read: Read,
    ) -> None:
        """Hand one message to its handlers, unless it is too old."""
        now = self._clock()
        measured = stamp_ns * 1e-9 - self._hub_time.offset
        age = now - measured
        if age < 0.0:
            age, measured = 0.0, now
        if age > inlet.oldest:
            inlet.oldest = age
        if age > inlet.lifespan_s:
            inlet.expired += 1
            self._complaints.count("too old", f"{inlet.definition.name} is {age:.2f} s old")
            return
        payload, value = read
        missed = 0
        if not inlet.unordered:
            missed = sequence - source.handed_on - 1 if source.handed_on else 0
            source.handed_on = sequence
        inlet.received += 1
        how = _new(MessageInfo, (publisher, sequence, missed, age, measured))
        handlers = inlet.handlers
        for each in handlers:
            if handlers is inlet.handlers or each in inlet.handlers:  # one may unsubscribe another
                handler, raw = each
                handler(payload if raw else value, how)

    def _decoded(self, inlet: Subscription, kind: int, message: Any) -> Read | None:
        """The payload and its value; None if it is not there, or cannot be read."""

        def note(text: str) -> None:
            inlet.unfit = inlet.unfit or text
            self._complaints.count("value changed", text)

        try:
            if message.__class__ is tuple and inlet.receive is not None:
                return message, inlet.receive(message, note)
            payload = self._payload(inlet, kind, message)
            return None if payload is None else (payload, inlet.definition.decode(payload, note))
        except RangeError as error:
            inlet.refused += 1
            inlet.unfit = inlet.unfit or str(error)
            self._complaints.count("out of range", str(error))
            return None
        except (CodecError, FrameError) as error:
            self._complaints.count("wrong format", str(error))
            return None

    def _payload(self, inlet: Subscription, kind: int, payload: memoryview) -> memoryview | None:
        """The payload itself; None if it is not there any more."""
        if kind == frames.INLINE:
            return payload
        if kind == frames.NO_RING:
            self._no_ring(inlet, "its publisher has none")
            return None
        try:
            found = self._rings.read(payload)
        except OSError as error:
            self._no_ring(inlet, str(error))
            return None
        if found is None:
            inlet.lost += 1
            self._complaints.count("overwritten", f"{inlet.definition.name}: read too late")
        return found
