"""Sleeps of this machine, while its monotonic clock stands still.

Linux has a second clock, which goes on in a sleep (CLOCK_BOOTTIME). The difference of the two grows
by each sleep and is constant otherwise. Both are read one after the other, so each look bounds it.
On systems without that clock no sleep is found.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

SHORTEST_S = 0.01
"""Shortest sleep that is found [s]."""


def _with_sleeps() -> float:
    """Time since the boot with all sleeps [s]; where the system has no such clock: without."""
    kind = getattr(time, "CLOCK_BOOTTIME", None)
    return time.monotonic() if kind is None else time.clock_gettime(kind)


class MachineSleep:
    """Finds sleeps of this machine; a busy machine is not taken for one that slept."""

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        with_sleeps: Callable[[], float] = _with_sleeps,
    ) -> None:
        """Begin.

        Args:
            clock: The monotonic clock [s].
            with_sleeps: A clock of the same rate that goes on in a sleep [s].
        """
        self._clock, self._with_sleeps = clock, with_sleeps
        self._most = math.inf

    def look(self) -> float:
        """How long the machine slept since the last look [s]; 0: it did not."""
        before, full, after = self._clock(), self._with_sleeps(), self._clock()
        least, most = full - after, full - before
        slept = least - self._most
        if slept < SHORTEST_S:
            self._most = min(self._most, most)
            return 0.0
        self._most = most
        return slept
