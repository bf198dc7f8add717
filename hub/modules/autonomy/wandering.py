"""The errand of wandering: drives about where there is room; pure."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.navigation import Point
from hub.grids.costs import Caution, crossing
from hub.grids.wavefront import spread
from hub.modules.autonomy.errands import NOWHERE, End, Pause, Sight, Target

NEAREST = 1.0
FARTHEST = 4.0
"""Ways to the places it goes to are between these two long [m]."""
PATIENCE_S = 1.0
"""Where the map shows no way any more another place will do after this time [s]."""
TRIES = 8
"""So often in turn it may be blocked."""


class Wander:
    """Goes to places near by that it draws by lot; the same seed and maps give the same places.

    Attributes:
        needs_map: True.
        frontier_m: NaN.
        explored: NaN.
    """

    def __init__(self, radius: float, seed: int) -> None:
        """Get ready.

        Args:
            radius: The robot's, with the margin it must keep [m].
            seed: Of the lots.
        """
        self.needs_map = True
        self.frontier_m = self.explored = NOWHERE
        self._radius = radius
        self._random = np.random.default_rng(seed)
        self._blocked = 0

    def choose(self, sight: Sight) -> Target | Pause | End:
        """A free place that can be reached over known ground."""
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
        # Rather near than nowhere: a small room has no places that are far off.
        for nearest in (NEAREST, self._radius):
            places = np.argwhere((ways >= nearest) & (ways <= FARTHEST))
            if len(places):
                row, column = places[self._random.integers(len(places))]
                x, y = wide.centre(int(row), int(column))
                return Target(points=(Point(x=x, y=y),), why="wanders", patience=PATIENCE_S)
        return Pause(why="there is no room to wander", waits=True)

    def keeps(self, target: Target, sight: Sight) -> bool:
        """Always."""
        del target, sight
        return True

    def reached(self, target: Target, now: float) -> None:
        """It gets about."""
        del target, now
        self._blocked = 0

    def blocked(self, target: Target, left: int, now: float, why: str) -> None:
        """Another place may do."""
        del target, left, now, why
        self._blocked += 1
