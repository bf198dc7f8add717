"""The least of recent values: of differences of two clocks, the one with the shortest way; pure."""

from __future__ import annotations

import math
from typing import Final

_SPAN_S: Final = 15.0
"""The least of one to two such spans counts [s]."""


class RecentLeast:
    """The least of recent values."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all values."""
        self._since = -math.inf
        self._now = self._before = math.inf

    def add(self, value: float, now: float) -> float:
        """Take a value; returns the least of the recent ones.

        Args:
            value: In any unit.
            now: Monotonic time [s].
        """
        if now - self._since > _SPAN_S:
            self._before = self._now if now - self._since <= 2.0 * _SPAN_S else math.inf
            self._now, self._since = math.inf, now
        self._now = min(self._now, value)
        return self.least

    @property
    def least(self) -> float:
        """The least of them; infinite: there is none."""
        return min(self._now, self._before)
