"""The task of wandering: drives to random places with room; pure."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.navigation import Point
from hub.grids.costs import Caution, crossing
from hub.grids.wavefront import spread
from hub.modules.autonomy.autonomy_task import NOWHERE, End, Pause, Sight, Target

NEAREST = 1.0
FARTHEST = 4.0
"""Least and largest length of the path to a place [m]."""
REPLACE_S = 1.0
"""A place without a path on the map is replaced after this time [s]."""
TRIES = 8
"""Largest number of blocked places in a row."""


class Wander:
    """Goes to random places nearby; the same seed and maps give the same places.

    Attributes:
        needs_map: True.
        frontier_m: NaN.
        explored: NaN.
    """

    def __init__(self, radius: float, seed: int) -> None:
        """Start.

        Args:
            radius: The robot's, with the margin it must keep [m].
            seed: Of the random choices.
        """
        self.needs_map = True
        self.frontier_m = self.explored = NOWHERE
        self._radius = radius
        self._random = np.random.default_rng(seed)
        self._blocked = 0

    def choose(self, sight: Sight) -> Target | Pause | End:
        """Choose a free place that can be reached over known ground."""
        if self._blocked >= TRIES:
            return End(why=f"there is no way, tried {TRIES} places", done=False)
        here = (sight.x, sight.y)
        wide = sight.grid and sight.grid.covering((here,), self._radius)
        if not wide:
            return Pause(why="there is no map yet", waits=True)
        caution = Caution(radius=self._radius, comfort=0.0, unknown=math.inf)
        start = wide.cell(*here)
        factors = crossing(wide, start, caution)
        ways = spread(factors, start) * wide.resolution
        ways[factors > 1.0] = math.inf  # only the robot's way out of a tight place
        # A near place is better than none: a small room has no distant places.
        for nearest in (NEAREST, self._radius):
            places = np.argwhere((ways >= nearest) & (ways <= FARTHEST))
            if len(places):
                row, column = places[self._random.integers(len(places))]
                x, y = wide.centre(int(row), int(column))
                return Target(points=(Point(x=x, y=y),), why="wanders", patience=REPLACE_S)
        return Pause(why="there is no room to wander", waits=True)

    def keeps(self, _target: Target, _sight: Sight) -> bool:
        """Always."""
        return True

    def reached(self, _target: Target, _now: float) -> None:
        """Reset the number of blocked places."""
        self._blocked = 0

    def blocked(self, _target: Target, _left: int, _now: float, _why: str) -> None:
        """Count a blocked place."""
        self._blocked += 1
