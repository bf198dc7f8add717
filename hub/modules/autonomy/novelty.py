"""Detects that exploring finds no new ground any more; pure."""

from __future__ import annotations

import math

from hub.robots.description import (
    LONGEST_EXPLORING_S,
    NOTHING_NEW_S,
    NOTHING_NEW_SHARE,
)
from hub.values import dataclass

LEAST_DISTANCE = 2.0
"""Least distance driven without new ground [m]."""
LEAST_PLACES = 2
"""Least number of targets without new ground: the path to the first may be long and known."""
LOST = 0.5
"""A map with less than this share of the earlier free ground was cleared."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Limits at which exploring ends although frontiers are left.

    Attributes:
        seconds: Time without new ground [s].
        share: New ground: the ground that the robot can reach grew by at least this share.
        longest: Time after which the robot is back at its start, if the path back allows it [s].
    """

    seconds: float = NOTHING_NEW_S
    share: float = NOTHING_NEW_SHARE
    longest: float = LONGEST_EXPLORING_S


class Novelty:
    """Tracks the area that the robot can reach and fits on.

    The time restarts each time the area has grown by the share. Drift can make it shrink and grow
    back, so only a new maximum counts. Other free ground does not count: sensors that see through
    walls make more and more of it.
    """

    def __init__(self, limits: Limits) -> None:
        """Start with the first map.

        Args:
            limits: Limits of exploring.
        """
        self.limits = limits
        self._ground = self._free = 0.0
        self._since = math.inf
        self._place: tuple[float, float] | None = None
        self._distance = 0.0
        self._places = 0

    def see_map(self, ground: float, free: float, x: float, y: float, now: float) -> bool:
        """Take a map; returns whether it has new ground.

        Args:
            ground: Area that the robot can reach and fits on [m^2].
            free: All free ground, which shows whether the map was cleared [m^2].
            x: The robot's position in `map` [m].
            y: The same [m].
            now: Monotonic time [s].
        """
        if self._place is not None:
            self._distance += math.dist(self._place, (x, y))
        self._place = (x, y)
        first = math.isinf(self._since)
        cleared = free < self._free * LOST
        self._free = free if cleared else max(free, self._free)
        if first or cleared or ground > self._ground * (1.0 + self.limits.share):
            self._ground = ground
            self.restart(now)
            return True
        return False

    def restart(self, now: float) -> None:
        """Restart the time."""
        self._since, self._distance, self._places = now, 0.0, 0

    def set_out(self) -> None:
        """Note that the robot is sent to a place."""
        self._places += 1

    def over(self, now: float) -> bool:
        """Whether the robot drove long enough without new ground."""
        drove = self._distance >= LEAST_DISTANCE and self._places >= LEAST_PLACES
        return drove and now - self._since >= self.limits.seconds
