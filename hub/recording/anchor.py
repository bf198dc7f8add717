"""The clock of a recording: one anchor to the date, and from there the monotonic clock."""

from __future__ import annotations

import time
from typing import Self

from hub.values import dataclass

LATEST = 2**63 - 1
"""The last stamp that all tools read [ns since 1970]."""


@dataclass(frozen=True, slots=True)
class TimeAnchor:
    """One moment on two clocks; a step of the date after it moves no stamp.

    Attributes:
        wall_ns: The moment since 1970 [ns].
        monotonic: The same moment on the monotonic clock [s].
    """

    wall_ns: int
    monotonic: float

    @classmethod
    def now(cls) -> Self:
        """The anchor of a recording that begins."""
        return cls(time.time_ns(), time.monotonic())

    def stamp(self, moment: float) -> int:
        """The stamp [ns since 1970] of a moment of the monotonic clock [s]; 0 to `LATEST`.

        Raises:
            ValueError: It is no number.
            OverflowError: It is infinite.
        """
        stamp = self.wall_ns + round((moment - self.monotonic) * 1e9)
        return stamp if 0 <= stamp <= LATEST else min(max(0, stamp), LATEST)

    def moment(self, stamp: int) -> float:
        """The moment [s, monotonic clock] of a stamp [ns since 1970]."""
        return self.monotonic + (stamp - self.wall_ns) / 1e9
