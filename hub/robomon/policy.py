"""Whether and when a module that ended is started again; pure."""

from __future__ import annotations

from collections import deque

FIRST_DELAY_S = 0.1
LONGEST_DELAY_S = 5.0


class RestartPolicy:
    """The restarts of one module: at once, then after ever longer pauses, then no more."""

    def __init__(self, limit: int, window_s: float) -> None:
        self._limit = limit
        self._window_s = window_s
        self._ends: deque[float] = deque()

    def ended(self, now: float) -> float | None:
        """The module ended at `now` [s]; when to start it again, None for never."""
        while self._ends and self._ends[0] <= now - self._window_s:
            self._ends.popleft()
        if len(self._ends) >= self._limit:
            return None
        delay = min(FIRST_DELAY_S * 2.0 ** len(self._ends), LONGEST_DELAY_S)
        self._ends.append(now)
        return now + delay
