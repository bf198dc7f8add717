"""How long messages were on their way, although the robot's clock may show another time; pure.

A message has the time of the robot's clock at which the bridge received it. Its arrival less that
time is the difference of the clocks and its way. The least of the last half minute is the
difference and the shortest way, and half of the shortest ping is about that way.
"""

from __future__ import annotations

import math

from hub.ros.clock_delay import ClockDelay
from hub.ros.recent_least import RecentLeast


class LineAges:
    """The ages of the messages of a line."""

    def __init__(self) -> None:
        self._delay, self._pings = ClockDelay(), RecentLeast()

    def clear(self) -> None:
        """Forget the robot's clock: it may be another one."""
        self._delay.clear()
        self._pings.clear()

    def answered(self, duration: float, now: float) -> None:
        """Note the time from a ping to its answer [s]."""
        self._pings.add(duration, now)

    def age(self, time_ns: int, now: float) -> float:
        """How long a message was on its way [s]; NaN: not known.

        Args:
            time_ns: The robot's time of the message [ns]; 0: not known.
            now: Monotonic time of its arrival [s].
        """
        if time_ns == 0:
            return math.nan
        way = self._pings.least / 2.0
        delay = self._delay.of(time_ns, int(now * 1e9), now)
        return delay + (way if math.isfinite(way) else 0.0)
