"""The received messages of a client, until their handlers get them.

| the message | it goes to its handlers |
| --- | --- |
| all are kept, no priority, empty queue | as it is read |
| any other | after all sockets are read; higher priority first |
| older than its lifespan, ahead of the clock with a lifespan, or repeated | never, and is counted |
| a command without a lifespan, ahead of the clock | as any other; its age is not known |

A sleep of this machine, in which its clock stands still, counts for the age of what is older.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any

import zmq

from hub.ipc.message_info import MessageInfo
from hub.ipc.node.frame_reader import FrameReader
from hub.ipc.node.subscription import ReceivedFrame, Source, Subscription
from hub.ipc.transport import sockets
from hub.ipc.transport.clock_sync import ClockSync
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames

_BATCH = 256
_MOST_EVENTS = 2 * max(sockets.QUEUE.values())
"""Most frames that wait between two clients of this machine, at both ends."""
_AHEAD_S = 0.05
"""Farthest that the stamp of a command may lie ahead: honest ones never do, on any line [s]."""
SLICE_S = 0.005
"""Longest time in handlers before the sockets are read again [s]."""


def _topics(name: str) -> list[bytes]:
    """The texts before the NUL in frames of this message."""
    return [frames.topic(name, kind)[:-1] for kind in (b"", frames.FAR, frames.RING)]


_new = tuple.__new__


class _Opened:
    """Messages of one publisher on their way to the handlers.

    Attributes:
        messages: Stamp [ns] and payload, or the numbers of a flat format, of each.
        sequence: Number of the next.
        accepted: Whether their numbers were checked before.
    """

    __slots__ = ("accepted", "kind", "messages", "publisher", "sequence", "source", "subscription")

    def __init__(
        self, subscription: Subscription, received: ReceivedFrame, *, accepted: bool = False
    ) -> None:
        self.subscription: Subscription | None = subscription
        self.publisher, self.sequence, self.kind, messages = received
        self.source = subscription.source(self.publisher)
        self.messages = iter(messages)
        self.accepted = accepted


class ReceiveQueue:
    """The received messages of one client that wait for the handlers.

    Attributes:
        topics: The subscription of each text before the NUL in frames.
        reader: Reads frames.
    """

    def __init__(
        self,
        *,
        clock: Callable[[], float],
        hub_time: ClockSync,
        faults: FaultCounter,
        no_ring: Callable[[Subscription, str], None],
    ) -> None:
        """Without subscriptions it reads nothing.

        Args:
            clock: Monotonic time [s].
            hub_time: The clock of stamps.
            faults: Counts wrong frames and late messages.
            no_ring: Called with the reason if shared memory has no payload.
        """
        self._clock = clock
        self._hub_time = hub_time
        self._faults = faults
        self.reader = FrameReader(faults, no_ring)
        self._decoded = self.reader.decoded
        self.topics: dict[bytes, Subscription] = {}
        self._woke, self._slept = -math.inf, 0.0
        self._waits = 0
        self._opened: list[_Opened] = []
        self._bundled: deque[tuple[bytes, bool]] = deque()
        self._queues: dict[int, deque[_Opened]] = {0: deque()}

    def stood_still(self, time: float) -> None:
        """Note that the clock stood still for `time` [s] until now, as this machine slept."""
        if time > 0.0:
            self._woke, self._slept = self._clock(), time

    @property
    def pending(self) -> bool:
        """Whether messages wait."""
        return self._waits > 0 or bool(self._opened) or bool(self._bundled)

    def add(self, subscription: Subscription) -> None:
        """Receive this message, or change its priority."""
        for topic in _topics(subscription.definition.name):
            self.topics[topic] = subscription
        if subscription.priority not in self._queues:
            self._queues[subscription.priority] = deque()
            self._queues = dict(sorted(self._queues.items(), reverse=True))

    def remove(self, subscription: Subscription) -> None:
        """Stop receiving it; waiting messages are dropped."""
        for topic in _topics(subscription.definition.name):
            del self.topics[topic]

    def close_rings(self) -> None:
        """Close all shared memory; waiting messages open it again."""
        self.reader.close()

    def turn(self) -> None:
        """Deliver waiting messages."""
        self._finish()
        if self._waits:
            self._deliver_waiting()

    def accept(self, subscription: Subscription, frame: frames.Frame) -> None:
        """Handle a message from an answer, unless it or a later one has arrived already."""
        source = subscription.source(frame.publisher)
        if frame.sequence <= source.arrived:
            return
        value = self._decoded(subscription, frame.kind, frame.payload)
        if value is None:
            return
        source.arrived = frame.sequence
        self._deliver(subscription, source, frame.publisher, frame.sequence, frame.stamp_ns, value)

    def _finish(self) -> None:
        """Deliver the rest after a handler that raised or listened itself."""
        while self._opened:
            self._hand_out(self._opened[-1])
        while self._bundled:
            raw, commands = self._bundled.popleft()
            self.take_frame(raw, commands=commands)

    def take(self, receive: Callable[[int], bytes | None], *, commands: bool = True) -> bool:
        """Read a batch from a socket; whether there may be more.

        Most messages wait until all sockets are read: a newer or more urgent one may follow.

        Args:
            receive: `recv` of the socket; None: a message was refused.
            commands: Whether commands may come there.
        """
        self._finish()
        end = self._clock() + SLICE_S
        for _ in range(_BATCH):
            try:
                raw = receive(zmq.NOBLOCK)
            except zmq.Again:
                return False
            if raw is None:
                continue
            if frames.is_bundle(raw):
                self._bundled += [(each, commands) for each in self.reader.split(raw)]
                self._finish()
            else:
                self.take_frame(raw, commands=commands)
            if self._clock() > end:
                return True
        return True

    def take_events(self, receive: Callable[[int], bytes | None], *, commands: bool = True) -> None:
        """Read a socket as `take` does: keep the messages of `Keep.ALL`, and drop all others."""
        self._finish()
        for _ in range(_MOST_EVENTS):
            try:
                raw = receive(zmq.NOBLOCK)
            except zmq.Again:
                return
            if raw is None:
                continue
            for each in self.reader.split(raw) if frames.is_bundle(raw) else [raw]:
                subscription = self.topics.get(each[: each.find(b"\0")])
                if (
                    subscription is not None
                    and subscription.limit is None
                    and (commands or not subscription.is_command)
                    and (received := self.reader.read(subscription, each))
                ):
                    self._put(subscription, received)

    def take_frame(self, raw: bytes, *, commands: bool = True) -> None:
        """Take one frame that was read where commands may come, or not."""
        subscription = self.topics.get(raw[: raw.find(b"\0")])
        if subscription is None:
            self.reader.check(raw)
            return
        if not commands and subscription.is_command:
            self._faults.count("forged number", f"{subscription.definition.name} came as a state")
            return
        at_once = subscription.limit is None and subscription.priority == 0 and not self._waits
        if at_once and subscription.flat is not None and (found := subscription.flat.unpack(raw)):
            _, publisher, _, sequence, stamp_ns, _ = found[:6]
            source = subscription.source(publisher)
            value = self._decoded(subscription, frames.INLINE, found[6:])
            if value is not None and self.arrived(subscription, source, sequence):
                self._deliver(subscription, source, publisher, sequence, stamp_ns, value)
            return
        received = self.reader.read(subscription, raw)
        if received is None:
            return
        if at_once:
            self._opened.append(_Opened(subscription, received))
            self._hand_out(self._opened[-1])
        else:
            self._put(subscription, received)

    def _put(self, subscription: Subscription, received: ReceivedFrame) -> None:
        """Add waiting messages; beyond the limit, drop the oldest of their publisher."""
        publisher, sequence, kind, messages = received
        source = subscription.source(publisher)
        for number, (stamp_ns, message) in enumerate(messages, sequence):
            read: Any = message
            if kind == frames.INLINE:
                read = self._decoded(subscription, kind, message)
            if read is None or not self.arrived(subscription, source, number):
                continue
            one = ReceivedFrame(publisher, number, kind, [(stamp_ns, read)])
            waiting = _Opened(subscription, one, accepted=True)
            if subscription.limit is not None:
                if len(source.waiting) >= subscription.limit:
                    source.waiting.popleft().subscription = None
                source.waiting.append(waiting)
            self._queues[subscription.priority].append(waiting)
            self._waits += 1

    def arrived(self, subscription: Subscription, source: Source, sequence: int) -> bool:
        """Whether a message of this number may be handed on; counts a gap before it.

        Only for a message that was decoded, or that lies in a ring of this machine. The number of a
        damaged message is ignored.
        """
        last = source.arrived
        if subscription.unordered:
            return True
        if sequence == last + 1 and last:
            source.arrived = sequence
            return True
        if not source.accepts(sequence):
            detail = f"{subscription.definition.name} {sequence} after {last}"
            self._faults.count("out of order", detail)
            return False
        if source.arrived:
            subscription.lost += sequence - source.arrived - 1
        source.arrived = sequence
        return True

    def _deliver_waiting(self) -> None:
        """Deliver waiting messages, most urgent first; read the sockets every `SLICE_S`."""
        end = self._clock() + SLICE_S
        for queue in self._queues.values():
            while queue:
                waiting = queue.popleft()
                self._waits -= 1
                if waiting.subscription is None:
                    continue  # a newer one arrived
                if waiting.source.waiting and waiting.source.waiting[0] is waiting:
                    waiting.source.waiting.popleft()
                self._opened.append(waiting)
                self._hand_out(waiting)
                if self._clock() > end:
                    return

    def _hand_out(self, opened: _Opened) -> None:
        """Pass messages to their handlers; after an exception, `_finish` delivers the rest."""
        subscription, source, publisher = opened.subscription, opened.source, opened.publisher
        if subscription is None:
            return
        for stamp_ns, message in opened.messages:
            sequence = opened.sequence
            opened.sequence = sequence + 1
            value = self._accepted(opened, subscription, sequence, message)
            if value is not None:
                self._deliver(subscription, source, publisher, sequence, stamp_ns, value)
        if opened in self._opened:  # not if a handler listened, and so delivered the rest
            self._opened.remove(opened)

    def _accepted(
        self, opened: _Opened, subscription: Subscription, sequence: int, message: Any
    ) -> Any:
        """The value to deliver; None if it cannot be read, or came before."""
        if opened.kind != frames.INLINE:
            if opened.accepted or self.arrived(subscription, opened.source, sequence):
                return self._decoded(subscription, opened.kind, message)
            return None
        if opened.accepted:
            return message
        value = self._decoded(subscription, frames.INLINE, message)
        if value is not None and self.arrived(subscription, opened.source, sequence):
            return value
        return None

    def _age_ahead(self, subscription: Subscription, ahead: float) -> float | None:
        """The age of a message that is `ahead` of the clock [s]; None: it is not delivered."""
        limited = subscription.lifespan_s < math.inf
        if ahead <= _AHEAD_S or not (limited or subscription.is_command):
            return 0.0
        text = f"{subscription.definition.name} is {ahead:.2f} s ahead of the hub's clock"
        self._faults.count("stamp ahead of the clock", text)
        if limited:
            subscription.expired += 1
            return None
        return 0.0 if subscription.raw else math.inf

    def _deliver(
        self,
        subscription: Subscription,
        source: Source,
        publisher: int,
        sequence: int,
        stamp_ns: int,
        value: Any,
    ) -> None:
        """Hand one message to its handlers, unless it is too old."""
        now = self._clock()
        measured = stamp_ns * 1e-9 - self._hub_time.most
        age = now - measured
        # Another machine's stamps of the time of the sleep are ahead of the clock that stood still.
        if measured < self._woke or (age < 0.0 and measured < self._woke + self._slept):
            age, measured = age + self._slept, measured - self._slept
        if age < 0.0:
            known = self._age_ahead(subscription, -age)
            if known is None:
                return
            age, measured = known, now
        if subscription.oldest < age < math.inf:
            subscription.oldest = age
        if age > subscription.lifespan_s:
            subscription.expired += 1
            self._faults.count("too old", f"{subscription.definition.name} is {age:.2f} s old")
            if subscription.late is not None:
                subscription.late(value, MessageInfo(publisher, sequence, 0, age, measured))
            return
        missed = 0
        if not subscription.unordered:
            missed = sequence - source.handed_on - 1 if source.handed_on else 0
            source.handed_on = sequence
        subscription.received += 1
        info = _new(MessageInfo, (publisher, sequence, missed, age, measured))
        handlers = subscription.handlers
        for each in handlers:
            if (
                handlers is subscription.handlers or each in subscription.handlers
            ):  # one may unsubscribe another
                each(value, info)
