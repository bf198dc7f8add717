"""Counting what is dropped, and logging it without flooding the log."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable


class FaultCounter:
    """Counts by reason; logs the first of each reason and then at most one a minute.

    Attributes:
        counts: How often, by reason.
    """

    def __init__(
        self, logger: logging.Logger, clock: Callable[[], float], *, interval_s: float = 60.0
    ) -> None:
        self.counts: Counter[str] = Counter()
        self._logger = logger
        self._clock = clock
        self._interval_s = interval_s
        self._next: dict[str, float] = {}

    def count(self, reason: str, detail: str) -> None:
        """One more of `reason`; `detail` is what the log says of it if it is its turn."""
        self.counts[reason] += 1
        now = self._clock()
        if now >= self._next.get(reason, now):
            self._next[reason] = now + self._interval_s
            self._logger.warning("%s (%d so far): %s", reason, self.counts[reason], detail)
