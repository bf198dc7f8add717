"""Whether a robot works, by how far it comes: as task effectiveness shows it, while it happens."""

from __future__ import annotations

import bisect
import math
from collections import deque

WINDOW_S = 1.0
"""Width of the window of the speed [s], as that of task effectiveness."""
_SAMPLE_S = 0.1
_LEAST = 0.02
"""Speed from which on a robot moves [m/s]."""


class WorkWatch:
    """Follows a robot's way; times never decrease."""

    def __init__(self, share: float) -> None:
        """Begin.

        Args:
            share: Of the median speed of a moving robot; one that is slower does not work.
        """
        self._share = share
        self._way: deque[tuple[float, float]] = deque()
        self._moving: list[float] = []
        self._sampled = -math.inf
        self._low_since = math.inf

    def follow(self, time: float, distance: float) -> None:
        """Take the length of the way until now.

        Args:
            time: [s]
            distance: Since any moment before the first call [m].
        """
        self._way.append((time, distance))
        while self._way[0][0] < time - WINDOW_S:
            self._way.popleft()
        if time - self._sampled < _SAMPLE_S:
            return
        self._sampled = time
        speed = (distance - self._way[0][1]) / WINDOW_S
        if speed > _LEAST:
            bisect.insort(self._moving, speed)
        if speed >= self._threshold:
            self._low_since = math.inf
        else:
            self._low_since = min(self._low_since, time)

    def low_for(self, now: float) -> float:
        """How long it has not been working [s]; 0 while it works."""
        return max(0.0, now - self._low_since)

    @property
    def _threshold(self) -> float:
        middle = self._moving[len(self._moving) // 2] if self._moving else 0.0
        return max(_LEAST, self._share * middle)
