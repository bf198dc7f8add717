"""How long something took between two clocks that need not agree; pure."""

from __future__ import annotations

from typing import Final

from hub.ros.recent_least import RecentLeast

_SET_BACK_NS: Final = 1_000_000_000
"""A time that is less than the one before by this shows that the clock was set back [ns]."""


class ClockDelay:
    """The time between two events, each by its own clock, less the least of the recent ones."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget both clocks: one may be another one now."""
        self._differences = RecentLeast()
        self._begun = -_SET_BACK_NS

    def of(self, begun: int, ended: int, now: float) -> float:
        """How much longer than the fastest of the last half minute it took [s].

        After the first clock was set back, the fastest from then on counts.

        Args:
            begun: When it began, by the first clock [ns]; a float has too few digits.
            ended: When it ended, by the second clock [ns].
            now: Monotonic time [s].
        """
        if begun <= self._begun - _SET_BACK_NS:
            self._differences.clear()
        self._begun = begun
        difference = ended - begun
        return (difference - self._differences.add(difference, now)) / 1e9
