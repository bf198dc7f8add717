"""Whether exploring still brings anything new; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hub.robots.description import (
    LONGEST_EXPLORING_S,
    NOTHING_NEW_S,
    NOTHING_NEW_SHARE,
)

LEAST_WAY = 2.0
"""Nothing new says nothing of a robot that drove less than this [m]."""
LEAST_PLACES = 2
"""Nor of one that set out for fewer places: the way to the first may be long and known."""
LOST = 0.5
"""A map with less than this share of the free ground before is another one: it was cleared."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """When exploring ends although frontiers are left.

    Attributes:
        seconds: Nothing new came for so long [s].
        share: Nothing new: the ground that the robot can reach grew by less than this share.
        longest: The robot is back at its start after this time, if the way back allows it [s].
    """

    seconds: float = NOTHING_NEW_S
    share: float = NOTHING_NEW_SHARE
    longest: float = LONGEST_EXPLORING_S


class Novelty:
    """Follows how the ground grows that the robot can reach and fits on.

    Each time it has grown by the share, counting begins anew. Drift can make it shrink and come
    back; only what is more than ever before is new. Other free ground does not count: sensors that
    look through walls make ever more of it.
    """

    def __init__(self, limits: Limits) -> None:
        """Begin with the first look.

        Args:
            limits: When it is enough.
        """
        self.limits = limits
        self._ground = self._free = 0.0
        self._since = math.inf
        self._place: tuple[float, float] | None = None
        self._way = 0.0
        self._places = 0

    def look(self, ground: float, free: float, x: float, y: float, now: float) -> bool:
        """See the map; whether there is something new in it.

        Args:
            ground: What the robot can reach and fits on [m^2].
            free: All free ground, which shows whether it is still the same map [m^2].
            x: Of the robot in `map` [m].
            y: Likewise [m].
            now: Monotonic time [s].
        """
        if self._place is not None:
            self._way += math.dist(self._place, (x, y))
        self._place = (x, y)
        first = math.isinf(self._since)
        cleared = free < self._free * LOST
        self._free = free if cleared else max(free, self._free)
        if first or cleared or ground > self._ground * (1.0 + self.limits.share):
            self._ground = ground
            self.begin_anew(now)
            return True
        return False

    def begin_anew(self, now: float) -> None:
        """Count from now on."""
        self._since, self._way, self._places = now, 0.0, 0

    def set_out(self) -> None:
        """The robot is sent to a place."""
        self._places += 1

    def over(self, now: float) -> bool:
        """Whether nothing new came for long enough, although the robot drove."""
        drove = self._way >= LEAST_WAY and self._places >= LEAST_PLACES
        return drove and now - self._since >= self.limits.seconds
