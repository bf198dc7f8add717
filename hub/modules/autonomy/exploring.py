"""The errand of exploring: goes where the map ends, until there is nothing new to see; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hub.gcm.navigation import Point
from hub.grids.frontiers import Frontier, edge_cells, frontiers
from hub.grids.grid import Grid
from hub.modules.autonomy.errands import End, Pause, Sight, Target
from hub.modules.autonomy.novelty import Limits, Novelty

SHORTEST = 0.4
"""Shorter frontiers are gaps between the cones of sensors, no ground to explore [m]."""
LOOK = 0.3
"""From so far off, beyond the robot's radius, a frontier is looked into [m]."""
FAR_LOOK = 1.5
"""Likewise in the end, and through walls: what closes the way may turn out to be none near by."""
NEAR = 0.35
"""Places nearer to each other than this are one and the same [m]."""
REST_S = 30.0
"""A place where the robot was in vain is left alone for this time, if there are others [s]."""
TRIES = 2
"""After so many visits in vain a place is given up."""

PATIENCE_S = 1.0
"""Where the map shows no way any more another place is explored after this time [s]."""

_NOTHING = "nothing is left"
_LONG = 2.0
"""A frontier that is longer is not worth more: the robot sees no more of it at once [m]."""
_NEAR_WAY = 1.0
"""So much longer every way counts [m]: the nearest frontier is not everything."""


@dataclass(slots=True)
class _Vain:
    """A place where the robot was, or could not get to, and where the frontier stays."""

    x: float
    y: float
    visits: int
    until: float


class Explore:
    """Goes to the frontier that is worth most for its way, as long as there are any.

    Worth and way are weighed as the square of the length over the way: a room behind a door that
    the map shows narrower than it is, for which a way counts ten times, must not come after every
    gap between two sonars' cones. A frontier that stays although the robot was there, or that it
    cannot get to, is left alone until all others are done, and given up in the end: sonars do not
    see walls that they look at sideways.

    Drift makes places anew that are known already, so exploring does not go on when nothing new
    comes. Before it ends, the robot goes as near as it can to those frontiers that the map shows no
    way to: noise closes doors until the robot is near.

    Attributes:
        needs_map: True.
        frontier_m: Length of all frontiers that can be reached and are not given up [m].
        explored: Share of the known ground's edge that is none of them, 0 to 1.
    """

    def __init__(self, radius: float, limits: Limits) -> None:
        """Get ready.

        Args:
            radius: The robot's, with the margin it must keep [m].
            limits: When nothing new has come for long enough.
        """
        self.needs_map = True
        self.frontier_m = self.explored = math.nan
        self._radius = radius
        self._novelty = Novelty(limits)
        self._reach = LOOK
        self._last_looks = False
        self._vain: list[_Vain] = []

    def choose(self, sight: Sight) -> Target | Pause | End:
        """The frontier to go to."""
        if sight.grid is None or not sight.fresh:
            return Pause(why="looks around")
        self._look(sight, sight.grid)
        near = self._frontiers(sight, sight.grid, LOOK)
        far = self._frontiers(sight, sight.grid, FAR_LOOK, in_sight=False)
        reachable = [place for place in near if math.isfinite(place.distance)]
        left = [place for place in reachable if not self._given_up(place)]
        # Both are of the same edges, in the same order.
        beyond = [
            there
            for here, there in zip(near, far, strict=True)
            if math.isinf(here.distance)
            and math.isfinite(there.distance)
            and not self._given_up(there)
        ]
        self.frontier_m = sum(place.length for place in left)
        self.explored = explored_share(sight.grid, self.frontier_m)
        counts = len(left), len(near) - len(reachable), len(reachable) - len(left)
        if self._novelty.over(sight.now):
            if self._last_looks:
                beyond = []
            self._last_looks = True
            self._novelty.begin_anew(sight.now)
        if not beyond and (self._last_looks or not left):
            reason = f"nothing new for {self._novelty.limits.seconds:g} s" if left else _NOTHING
            return End(why=summary(reason, *counts))
        if self._last_looks or not left:
            return self._target(beyond, sight.now, FAR_LOOK)
        return self._target(left, sight.now, LOOK)

    def _target(self, left: list[Frontier], now: float, look: float) -> Target:
        """The best of the frontiers that are left."""
        # Places where it was in vain come last, and those that rest are better than none.
        untried = [place for place in left if self._at(place.x, place.y) is None]
        rested = [place for place in left if not self._rests(place, now)]
        best = max(untried or rested or left, key=worth)
        self._reach = look
        self._novelty.set_out()
        why = f"explores: a frontier of {best.length:.1f} m, {best.distance:.1f} m away"
        return Target(points=(Point(x=best.x, y=best.y),), why=why, patience=PATIENCE_S)

    def keeps(self, target: Target, sight: Sight) -> bool:
        """Whether the map still ends there."""
        if sight.grid is None:
            return True
        self._look(sight, sight.grid)
        goal = target.points[-1]
        return _ends_near(sight.grid, goal.x, goal.y, self._radius + self._reach + NEAR)

    def reached(self, target: Target, now: float) -> None:
        """What is still unknown there will stay so for now."""
        self._note(target, now)

    def blocked(self, target: Target, left: int, now: float, why: str) -> None:
        """It cannot be reached for now."""
        del left, why
        self._note(target, now)

    def _frontiers(
        self, sight: Sight, grid: Grid, look: float, *, in_sight: bool = True
    ) -> tuple[Frontier, ...]:
        here = (sight.x, sight.y)
        wide = grid.covering((here,), self._radius)
        if wide is None:
            return ()
        return frontiers(
            wide, here, radius=self._radius, reach=look, shortest=SHORTEST, in_sight=in_sight
        )

    def _note(self, target: Target, now: float) -> None:
        goal = target.points[-1]
        known = self._at(goal.x, goal.y)
        if known is None:
            self._vain.append(_Vain(goal.x, goal.y, 1, now + REST_S))
        else:
            known.visits += 1
            known.until = now + REST_S

    def _at(self, x: float, y: float) -> _Vain | None:
        near = [vain for vain in self._vain if math.hypot(vain.x - x, vain.y - y) < NEAR]
        return max(near, key=lambda vain: vain.visits, default=None)

    def _given_up(self, place: Frontier) -> bool:
        vain = self._at(place.x, place.y)
        return vain is not None and vain.visits >= TRIES

    def _rests(self, place: Frontier, now: float) -> bool:
        vain = self._at(place.x, place.y)
        return vain is not None and now < vain.until

    def _look(self, sight: Sight, grid: Grid) -> None:
        free = float(np.count_nonzero(grid.free)) * grid.resolution**2
        if self._novelty.look(free, sight.x, sight.y, sight.now):
            self._last_looks = False


def summary(reason: str, left: int, out_of_reach: int, given_up: int) -> str:
    """How exploring ended, for people.

    Args:
        reason: Why.
        left: Frontiers that could have been gone to.
        out_of_reach: Frontiers to which the map shows no way.
        given_up: Frontiers where it was in vain.
    """
    counts = {"left": left, "out of reach": out_of_reach, "given up": given_up}
    parts = [f"{count} {name}" for name, count in counts.items() if count]
    if not parts:
        return f"explored: {reason}"
    return f"explored: {reason}; frontiers: {', '.join(parts)}"


def explored_share(grid: Grid, frontier_m: float) -> float:
    """Share of the edge of the known free ground that is not left to explore, 0 to 1.

    Args:
        grid: The map.
        frontier_m: Length of the edge that is left to explore [m].
    """
    free = np.pad(grid.free, 1)
    inner = free[:-2, 1:-1] & free[2:, 1:-1] & free[1:-1, :-2] & free[1:-1, 2:]
    edge = float(np.count_nonzero(grid.free & ~inner)) * grid.resolution
    return max(0.0, 1.0 - frontier_m / edge) if edge else 0.0


def worth(frontier: Frontier) -> float:
    """What going to a frontier is worth [m], only to be compared."""
    return min(frontier.length, _LONG) ** 2 / (_NEAR_WAY + frontier.distance)


def _ends_near(grid: Grid, x: float, y: float, reach: float) -> bool:
    """Whether free ground borders on the unknown within `reach` [m] of a point."""
    cells = np.argwhere(edge_cells(grid))
    row, column = grid.cell(x, y)
    away = np.hypot(cells[:, 0] - row, cells[:, 1] - column)
    return bool((away <= reach / grid.resolution).any())
