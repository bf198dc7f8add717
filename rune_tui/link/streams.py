"""A robot's broadcasts: subscribed to, or requested if a link cannot carry all of them.

Broadcasts have no flow control: too many wait in the link and grow old. Then
the streams that keep the newest are asked for instead, each again only when its answer is there.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Set
from typing import Any, Final

from hub.gcm.catalog import BY_NAME
from hub.ipc.client import Client
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.message_info import MessageInfo
from hub.values import dataclass

LATE_S: Final = 0.3
"""Age at arrival, beyond the round trip, that shows a wait in the link [s]."""
_LATE_FOR_S: Final = 0.5
_LATE_MESSAGES: Final = 5
_SHARE: Final = 0.8
"""Part of the link's time that streams may take from pictures."""
_POLL_TIME_S, _LONGEST_POLL_TIME_S = 10.0, 300.0
"""Time until broadcasts are tried again [s]; it doubles each time."""
_TIMEOUT_S: Final = 2.0
_NEW: Final = 0.2
_LONGEST_WAIT_S: Final = 1.0
"""A stream is asked for at least this often, however slow the last answer was [s]."""


@dataclass(slots=True)
class _Stream:
    """One message.

    Attributes:
        definition: Which.
        handler: Its receiver.
        waits: Whether it was asked for, and there is no answer yet.
        due: When it may be asked for again [s].
    """

    definition: MessageDefinition[Any]
    handler: Callable[[Any, MessageInfo], None]
    waits: bool = False
    due: float = -math.inf

    @property
    def can_be_asked_for(self) -> bool:
        definition = self.definition
        streams = definition.keep is Keep.NEWEST and definition.rate_hz > 1.0
        return streams and definition.plane is Plane.STATE


class Streams:
    """Used by the link's thread alone.

    Attributes:
        asking: Whether streams are asked for, because the link cannot carry all of them.
    """

    def __init__(
        self,
        client: Client,
        store: Callable[[str, Any, MessageInfo], None],
        clock: Callable[[], float],
    ) -> None:
        """Subscribe to nothing yet.

        Args:
            client: The client that subscribes and asks.
            store: Gets each message: its name, value and origin.
            clock: Monotonic time [s].
        """
        self.asking = False
        self._client = client
        self._store = store
        self._clock = clock
        self._streams: dict[str, _Stream] = {}
        self._late_since = math.inf
        self._late = 0
        self._busy = 0.0
        self._poll_time, self.asked_until = _POLL_TIME_S, -math.inf

    def follow(self, names: Set[str]) -> None:
        """Store only these messages from now on."""
        for name in self._streams.keys() - names:
            stream = self._streams.pop(name)
            self._client.unsubscribe(stream.definition, stream.handler)
        for name in sorted(names - self._streams.keys()):
            handler = functools.partial(self._arrivals, name)
            self._streams[name] = stream = _Stream(BY_NAME[name], handler)
            if not (self.asking and stream.can_be_asked_for):
                self._subscribe(stream)

    def step(self) -> None:
        """Send the requests that are due, or return to broadcasts."""
        now = self._clock()
        if not self.asking or not self._client.connected:
            return
        asked = self._asked_for()
        if (
            now > self.asked_until
            and self._busy * sum(s.definition.rate_hz for s in asked) < _SHARE
        ):
            self.asking = False
            for stream in asked:
                self._subscribe(stream)
            return
        for stream in asked:
            if not stream.waits and now >= stream.due:
                stream.waits = True
                self._client.last_notify(
                    stream.definition,
                    timeout=_TIMEOUT_S,
                    answered=functools.partial(self._answered, stream, now),
                    failed=functools.partial(self._failed, stream),
                )

    def _subscribe(self, stream: _Stream) -> None:
        self._client.subscribe(stream.definition, stream.handler, last=True)

    def _asked_for(self) -> list[_Stream]:
        return [stream for stream in self._streams.values() if stream.can_be_asked_for]

    def _arrivals(self, name: str, value: Any, reception: MessageInfo) -> None:  # noqa: ANN401 any message
        """A broadcast."""
        stream = self._streams.get(name)
        if stream is None:
            return
        self._store(name, value, reception)
        if self.asking or self._client.near or not stream.can_be_asked_for:
            return
        now, bare = self._clock(), self._client.round_trip
        if reception.age <= LATE_S + bare:
            self._late_since, self._late = math.inf, 0
            return
        self._late += 1
        self._late_since = min(self._late_since, now)
        if self._late >= _LATE_MESSAGES and now - self._late_since >= _LATE_FOR_S:
            self._ask_from_now_on(now)

    def _ask_from_now_on(self, now: float) -> None:
        self.asking = True
        self._late_since, self._late = math.inf, 0
        self._busy = 0.0
        self.asked_until, self._poll_time = (
            now + self._poll_time,
            min(_LONGEST_POLL_TIME_S, 2.0 * self._poll_time),
        )
        for stream in self._asked_for():
            self._client.unsubscribe(stream.definition, stream.handler)

    def _answered(self, stream: _Stream, asked: float, value: Any, reception: MessageInfo) -> None:  # noqa: ANN401 any message
        stream.waits = False
        now = self._clock()
        busy = max(0.0, now - asked - self._client.round_trip)
        # A fast answer shows that the link is free, so a slow one before it counts no more.
        self._busy = min(busy, self._busy + _NEW * (busy - self._busy)) if self._busy else busy
        period = 1.0 / stream.definition.rate_hz
        share = len(self._asked_for()) * self._busy / _SHARE
        stream.due = asked + max(period, min(share, _LONGEST_WAIT_S))
        if self._streams.get(stream.definition.name) is stream:
            self._store(stream.definition.name, value, reception)

    def _failed(self, stream: _Stream, _: object) -> None:
        stream.waits = False
        stream.due = self._clock() + 1.0
