"""The broadcasts of each message, as publishers and subscribers report them."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import field

from hub.ipc.wire import control
from hub.values import dataclass

_MAX_PUBLISHERS = 1024
_MAX_JUMP = 1 << 24
_MAX_BYTES = 1 << 40
_RECENT_REPORTS = 16
_LATELY_S = 3.0
"""Time for which a report counts; a publisher reports every second while it publishes [s]."""


@dataclass(frozen=True, slots=True)
class _Rate:
    until: float
    messages_per_s: float
    bytes_per_s: float


@dataclass(slots=True)
class Traffic:
    """The broadcasts of one message.

    Attributes:
        messages: Number of them.
        bytes: Of their payloads.
        lost: Missed by subscribers, by the sequence numbers.
        expired: Dropped by subscribers as too old.
        refused: Refused by subscribers because of a value out of its range.
    """

    messages: int = 0
    bytes: int = 0
    lost: int = 0
    expired: int = 0
    refused: int = 0
    _seen: float = -math.inf
    _rates: dict[int, _Rate] = field(default_factory=dict)
    _oldest: deque[float] = field(default_factory=lambda: deque(maxlen=_RECENT_REPORTS))

    def published(self, publisher: int, entry: control.Published, now: float) -> None:
        """Add a publisher's report, without impossible numbers."""
        if entry.messages > _MAX_JUMP or entry.bytes > _MAX_BYTES:
            return
        if not (0.0 < entry.over_s < math.inf and 0.0 <= entry.silent_s < math.inf):
            return
        self.messages += entry.messages
        self.bytes += entry.bytes
        self._seen = max(self._seen, now - entry.silent_s)
        if len(self._rates) >= _MAX_PUBLISHERS:
            self._rates.clear()
        self._rates[publisher] = _Rate(
            now + _LATELY_S, entry.messages / entry.over_s, entry.bytes / entry.over_s
        )

    def received(self, entry: control.Received) -> None:
        """Add a subscriber's report, without impossible numbers."""
        most = max(entry.lost, entry.expired, entry.refused)
        if most > _MAX_JUMP or not 0.0 <= entry.oldest_s < math.inf:
            return
        self.lost += entry.lost
        self.expired += entry.expired
        self.refused += entry.refused
        self._oldest.append(entry.oldest_s)

    def rate(self, now: float) -> tuple[float, float]:
        """Messages and bytes lately, of all publishers together [1/s]."""
        current = [rate for rate in self._rates.values() if rate.until > now]
        return sum(r.messages_per_s for r in current), sum(r.bytes_per_s for r in current)

    def silent(self, now: float) -> float:
        """Time since the last broadcast [s]; infinite if there was none."""
        return now - self._seen

    @property
    def oldest(self) -> float:
        """Largest age in the last reports of subscribers [s]."""
        return max(self._oldest, default=0.0)
