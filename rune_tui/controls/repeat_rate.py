"""How fast the keyboard repeats a held key, and so how long silence may last; pure."""

from __future__ import annotations

import statistics
from collections import deque
from typing import Final

FIRST_HOLD_S: Final = 0.6
"""Duration of a hold after a press, and the longest after a repeat [s]."""
_LEAST_HOLD_S: Final = 0.15
"""Shortest hold after a repeat [s]."""
_REPEAT_FACTOR: Final = 2.5
"""Duration of a hold after a repeat [repeat intervals]."""
_REPEATS_MEASURED: Final = 6


class RepeatRate:
    """Measures the last few intervals between repeats of all keys.

    The longest of them counts, because a slow line delivers repeats in bursts.

    Attributes:
        intervals: The last few [s].
    """

    def __init__(self) -> None:
        self.intervals: deque[float] = deque(maxlen=_REPEATS_MEASURED)

    def __bool__(self) -> bool:
        """Whether anything was measured."""
        return bool(self.intervals)

    def add(self, interval: float) -> None:
        """Add the time between two repeats [s]."""
        self.intervals.append(interval)

    @property
    def usual(self) -> float:
        """The usual interval [s]; only where something was measured."""
        return statistics.median(self.intervals)

    @property
    def hold_s(self) -> float:
        """Duration of a hold after a repeat, where releases are not reported [s]."""
        return min(FIRST_HOLD_S, max(_LEAST_HOLD_S, self._longest_pause)) if self else FIRST_HOLD_S

    @property
    def silence_s(self) -> float:
        """How long a key that repeats may be silent, where its release is reported [s]."""
        return max(FIRST_HOLD_S, self._longest_pause)

    @property
    def _longest_pause(self) -> float:
        return _REPEAT_FACTOR * max(self.intervals)
