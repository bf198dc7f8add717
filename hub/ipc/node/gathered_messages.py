"""Reads what an inbox has gathered: many messages in one go, undecoded, in the order they came."""

from __future__ import annotations

from collections.abc import Callable
from operator import itemgetter
from typing import Any

from hub.ipc.message_info import Gathered, MessageInfo
from hub.ipc.node.receive_queue import ReceiveQueue
from hub.ipc.node.subscription import Source, Subscription
from hub.ipc.transport.clock_sync import ClockSync
from hub.ipc.wire import frames

_BUNDLE = ord("*")
_CAME = itemgetter(2)
_LONGEST = frames.MAX_TOPIC + 1
_NUMBERS_SIZE = frames.NUMBERS.size
_NUMBERS_AT = 8 + frames.HEADER_SIZE - _NUMBERS_SIZE
_MAX_ROUTES = 1 << 14


class GatheredMessages:
    """Reads gathered messages, and hands them on together.

    The moment when a message came is not known. It came after the last look, after the message
    before it, and after its measurement. The latest of these three counts as its moment.
    """

    def __init__(
        self,
        queue: ReceiveQueue,
        hub_time: ClockSync,
        clock: Callable[[], float],
        take: Callable[[list[Gathered]], None],
    ) -> None:
        """Begin.

        Args:
            queue: Has the subscriptions.
            hub_time: The clock of stamps.
            clock: Monotonic time [s].
            take: Gets what was gathered, if that is anything.
        """
        self._queue, self._hub_time, self._clock, self._take = queue, hub_time, clock, take
        self._found: list[Gathered] = []
        self._routes: dict[bytes, tuple[Subscription, Source, Any]] = {}
        self._since = self._now = 0.0

    def one(self, label: Any, payload: Any, info: MessageInfo) -> None:
        """Deliver a message that came another way."""
        whole, measured = bytes(payload), info.measured
        # As if the last look had found it: what the next one finds came later.
        came = max(self._now, measured) if self._now else self._clock()
        self._take([(label, whole, came, measured, info.sequence, len(whole))])

    def begin(self, since: float, now: float) -> None:
        """What follows came between these times [s]."""
        self._since, self._now = since, now

    def end(self) -> None:
        """Deliver what was found."""
        found, self._found = self._found, []
        if found:
            found.sort(key=_CAME)
            self._take(found)

    def take(self, data: bytes, places: list[int]) -> None:
        """Read the messages of one connection: begin and end of each in `data`, in turn."""
        now, offset, since, came = self._now, self._hub_time.most, self._since, self._since
        find, read, arrived = data.find, frames.NUMBERS.unpack_from, self._queue.arrived
        routes, add = self._routes, self._found.append
        each = iter(self._unbundled(data, places))
        for start, end in zip(each, each, strict=False):
            stop = find(b"\0", start, start + _LONGEST)
            numbers = stop + _NUMBERS_AT - (stop - start) % 8
            route = routes.get(data[start:numbers])
            body = numbers + _NUMBERS_SIZE
            if route is None or body > end:
                came = self._take_other(data[start:end], came)
                continue
            subscription, source, label = route
            number, stamp, length = read(data, numbers)
            if length != end - body:
                came = self._take_other(data[start:end], came)
                continue
            if number == source.arrived + 1 and number > 1:
                source.arrived = number
            elif not arrived(subscription, source, number):
                continue
            measured = stamp * 1e-9 - offset
            if measured > came:
                came = measured = measured if measured < now else now
            elif since - measured > subscription.oldest:
                subscription.oldest = since - measured
            subscription.received += 1
            add((label, data[body:end], came, measured, number, length))

    def forget(self) -> None:
        """Forget publishers and subscriptions."""
        self._routes.clear()

    def _take_other(self, raw: bytes, came: float) -> float:
        """Read any frame; returns when its last message came [s]."""
        subscription = self._queue.topics.get(raw[: raw.find(b"\0")])
        if subscription is None or subscription.label is None:
            self._queue.take_frame(raw, commands=False)  # no sender shows a ticket here
            return came
        received = self._queue.reader.read(subscription, raw)
        if received is None:
            return came
        publisher, first, kind, messages = received
        source, count = subscription.source(publisher), 0
        for number, (stamp, message) in enumerate(messages, first):
            # A number counts if its payload can be read; one that lies in a ring counts at once.
            if kind != frames.INLINE and not self._queue.arrived(subscription, source, number):
                continue
            payload = self._queue.reader.decoded(subscription, kind, message)
            if payload is None or (
                kind == frames.INLINE and not self._queue.arrived(subscription, source, number)
            ):
                continue
            measured = min(stamp * 1e-9 - self._hub_time.most, self._now)
            came = max(came, measured)
            subscription.oldest = max(subscription.oldest, self._since - measured)
            whole = bytes(payload)
            self._found.append((subscription.label, whole, came, measured, number, len(whole)))
            count += 1
        subscription.received += count
        if count and kind == frames.INLINE:
            self._learn(raw, subscription, source)
        return came

    def _learn(self, raw: bytes, subscription: Subscription, source: Source) -> None:
        """Know the next frames of a publisher by what each of them begins with."""
        frame = frames.unpack(raw)
        if frame.kind == frames.INLINE:
            if len(self._routes) >= _MAX_ROUTES:
                self._routes.clear()
            begin = raw[: len(raw) - len(frame.payload) - _NUMBERS_SIZE]
            self._routes[begin] = subscription, source, subscription.label

    def _unbundled(self, data: bytes, places: list[int]) -> list[int]:
        """Begin and end of each frame, in turn: those of bundles too."""
        if not any(data[start] == _BUNDLE for start in places[::2]):
            return places
        found: list[int] = []
        each = iter(places)
        for start, end in zip(each, each, strict=False):
            if data[start] == _BUNDLE:
                found += self._queue.reader.places(data, start, end)
            else:
                found += (start, end)
        return found
