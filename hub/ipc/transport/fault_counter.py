"""Counts dropped messages, and logs them without flooding the log."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable


class FaultCounter:
    """Counts by reason; logs the first of each reason, then at most one a minute.

    Attributes:
        counts: Number by reason.
    """

    def __init__(
        self, logger: logging.Logger, clock: Callable[[], float], *, interval_s: float = 60.0
    ) -> None:
        self.counts: Counter[str] = Counter()
        self._logger = logger
        self._clock = clock
        self._interval_s = interval_s
        self._next: dict[str, float] = {}

    def count(self, reason: str, detail: str, *, level: int = logging.WARNING) -> None:
        """Count one more of `reason`; `detail` is its text in the log, if it is due."""
        self.counts[reason] += 1
        now = self._clock()
        if now >= self._next.get(reason, now):
            self._next[reason] = now + self._interval_s
            self._logger.log(level, "%s (%d so far): %s", reason, self.counts[reason], detail)
