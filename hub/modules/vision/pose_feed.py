"""Subscribes to the robot's poses only while a client needs pictures; pure.

| state | event | action | next state |
| --- | --- | --- | --- |
| ASLEEP | a need | subscribe | WAKING |
| WAKING | a pose of each awaited kind, or the end of 0.25 s | do the work that waits | AWAKE |
| AWAKE | a need | do its work | AWAKE |
| AWAKE | no need for 5 s | unsubscribe | ASLEEP |

It starts ASLEEP. A picture from before the first pose would show an old place, so its work waits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.values import dataclass

WAKE_S = 0.25
"""Longest wait for the first poses [s]; modules that publish none must not stop the pictures."""
LINGER_S = 5.0
"""The subscriptions stay for this time after the last need [s]."""

Handler = Callable[[Any, MessageInfo], None]
Work = Callable[[], None]


class PoseClient(Protocol):
    """What it needs of a client."""

    def subscribe(self, definition: MessageDefinition[Any], handler: Handler) -> None:
        """Call `handler` for every message."""

    def unsubscribe(self, definition: MessageDefinition[Any]) -> None:
        """Remove the handlers of a message."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseSource:
    """A message with poses.

    Attributes:
        definition: The message.
        handler: Takes each of them.
        awaited: Whether pictures wait for the first.
    """

    definition: MessageDefinition[Any]
    handler: Handler
    awaited: bool = True


class PoseFeed:
    """Keeps the state; every method gets the present monotonic time [s]."""

    def __init__(self, client: PoseClient, sources: Sequence[PoseSource]) -> None:
        """Start ASLEEP.

        Args:
            client: Subscribes and unsubscribes.
            sources: The messages.
        """
        self._client = client
        self._sources = tuple(sources)
        self._missing: set[str] = set()
        self._waiting: list[Work] = []
        self._asleep = True
        self._wake_by = math.inf
        self._needed_until = -math.inf

    @property
    def asleep(self) -> bool:
        """Whether no client needs poses."""
        return self._asleep

    @property
    def due(self) -> float:
        """Time at which the work waits no longer [s]; inf: none waits."""
        return self._wake_by

    def need(self, now: float, work: Work | None = None) -> None:
        """A client needs poses; do the work at once, or after the first ones."""
        self._needed_until = now + LINGER_S
        if self._asleep:
            self._wake(now)
        if work is None:
            return
        if self._wake_by == math.inf:
            work()
        else:
            self._waiting.append(work)

    def look(self, now: float) -> None:
        """Do what is due."""
        if now >= self._wake_by:
            self._work()
        elif not self._asleep and now >= self._needed_until:
            self._asleep = True
            for source in self._sources:
                self._client.unsubscribe(source.definition)

    def _wake(self, now: float) -> None:
        self._asleep = False
        self._wake_by = now + WAKE_S
        self._missing = {each.definition.name for each in self._sources if each.awaited}
        for source in self._sources:
            self._client.subscribe(source.definition, self._handler(source))

    def _handler(self, source: PoseSource) -> Handler:
        def take(value: object, reception: MessageInfo) -> None:
            source.handler(value, reception)
            if self._missing:
                self._missing.discard(source.definition.name)
                if not self._missing:
                    self._work()

        return take

    def _work(self) -> None:
        """Do all the work that waits."""
        self._missing.clear()
        while self._waiting:
            self._waiting.pop(0)()
        self._wake_by = math.inf
