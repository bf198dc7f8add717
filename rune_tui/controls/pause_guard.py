"""Keys that were typed while the console paused; pure.

After a pause of the console or a sleep of its machine, old keys wait to be read. The times at which
they were typed are not known, so they must not drive.

| event | action |
| --- | --- |
| more than 0.3 s between two ticks or keys | the console paused: release all input |
| a key within 0.2 s after that | it is stale: it does not drive until it is pressed again |
"""

from __future__ import annotations

PAUSE_S = 0.3
"""A longer time between two ticks is a pause [s]."""
STALE_S = 0.2
"""Keys are stale for this time after a pause [s]."""


class PauseGuard:
    """Detects pauses of the console itself."""

    def __init__(self, *, pause_s: float = PAUSE_S, stale_s: float = STALE_S) -> None:
        self._pause_s = pause_s
        self._stale_s = stale_s
        self._seen: float | None = None
        self._stale_until = float("-inf")

    def paused(self, now: float) -> bool:
        """Whether the console paused just before `now`; call it at every tick and every key."""
        away = self._seen is not None and now - self._seen > self._pause_s
        self._seen = now
        if away:
            self._stale_until = now + self._stale_s
        return away

    def is_stale(self, now: float) -> bool:
        """Whether a key at `now` may have been typed during a pause."""
        return now < self._stale_until
