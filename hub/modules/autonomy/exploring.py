"""The task of exploring: goes where the map ends, until there is nothing new to see; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hub.gcm.navigation import Point
from hub.grids.frontiers import Frontier, edge_cells, frontiers
from hub.grids.grid import Grid
from hub.grids.reach import standing_ground, ways
from hub.modules.autonomy import base_line
from hub.modules.autonomy.autonomy_task import End, Pause, Sight, Target
from hub.modules.autonomy.novelty import Limits, Novelty

SHORTEST = 0.3
"""Shorter frontiers are gaps between the cones of sensors, no ground to explore [m]."""
LEAST_GAIN = 0.5
"""Frontiers with less ground behind them, for the robot to stand on, are left out [m^2]."""
MOST_GAIN = 12.0
"""More ground behind a frontier is not worth more: the robot sees no more at once [m^2]."""
LOOK = 0.3
"""From so far off, beyond the robot's radius, a frontier is looked into [m]."""
FAR_LOOK = 1.5
"""Likewise in the end, and through walls: what closes the way may turn out to be none near by."""
ARRIVED = 0.4
"""From so far off a place is reached, and what is unknown there is looked at [m]."""
NEAR = 0.5
"""Places nearer to each other than this are one and the same [m]."""
HOME = Point(x=0.0, y=0.0)
"""Where the robot started: the origin of `map`."""
AT_HOME = 0.5
"""So near to it the robot is at home [m]."""
DETOUR, DETOUR_M = 1.5, 4.0
"""Something is in the way where navigation has so many times the way left, and so much more [m]."""
SAME = 1.0
"""A frontier that is looked into from so near to the target is the one it leads to [m]."""
SWITCH = 2.0
"""Another frontier is gone to instead if it is worth so many times as much."""
VAIN_WORTH = 0.2
"""Each visit in vain leaves this share of what a frontier was worth."""
TRIES = 3
"""After so many visits in vain a place is given up."""
SPEED = 0.35
"""So fast the robot gets about, turns included [m/s]."""
HOMEWARD_SPEED = 0.2
"""The way back to the start is made at least so fast on average [m/s]."""
HOMEWARD_SPARE_S = 20.0
"""The robot turns back so much earlier than the way takes [s]."""
STOP_S = 6.0
"""So much longer each target takes: to look, and to turn away [s]."""
CLOSED_S = 12.0
"""So long a target stays to which the map shows no way any more [s]."""
PATIENCE_S = 6.0
"""Where the map shows no way any more another place is explored after this time [s]."""

_NOTHING = "nothing is left"


@dataclass(slots=True)
class _Vain:
    """A place where the robot was, or could not get to, and where the frontier stays."""

    x: float
    y: float
    visits: int


class Explore:
    """Goes to the frontier that brings most new ground for its time, as long as there are any.

    What counts is ground where the robot may be able to stand: gaps between two sonars' cones, and
    what is behind furniture, are no reason to go there. A frontier that stays although the robot
    was there, or that it cannot get to, is worth less and less, and is given up: sonars do not see
    walls that they look at sideways. Noise closes doors on the map until the robot is near, so
    frontiers that the map shows no way to are looked at from as near as the robot gets.

    A robot that has not moved yet drives its base line first, which makes all later poses truer.

    Drift makes places anew that are known already, so exploring does not go on when nothing new
    comes. Nor does it go on for longer than the limits say: a robot that has lost its place sees
    new ground all the time. Then the robot goes back to its start.

    Attributes:
        needs_map: True.
        frontier_m: Length of all frontiers that are left and not given up [m].
        explored: Share of the known ground's edge that is none of them, 0 to 1.
    """

    def __init__(self, radius: float, limits: Limits) -> None:
        """Get ready.

        Args:
            radius: The robot's, with the margin it must keep [m].
            limits: When it ends although frontiers are left.
        """
        self.needs_map = True
        self.frontier_m = self.explored = math.nan
        self._radius = radius
        self._novelty = Novelty(limits)
        self._seen: Grid | None = None
        self._began = math.inf
        self._ground = self._way_home = 0.0
        self._reach = LOOK
        self._vain: list[_Vain] = []
        self._open_at = -math.inf
        self._end: str | None = None
        self._home = ""
        self._last_looks = False
        self._base_line: bool | None = None

    def choose(self, sight: Sight) -> Target | Pause | End:
        """The frontier to go to."""
        if self._end is not None:
            return self._go_home(self._end, sight)
        if sight.grid is not None:
            self._look(sight, sight.grid)
        late = self._late(sight.now)
        if sight.grid is None or not (sight.fresh or late):
            return Pause(why="looks around")
        near = self._frontiers(sight, sight.grid, LOOK)
        reachable = [place for place in near if math.isfinite(place.distance)]
        left = self._left(near)
        self.frontier_m = sum(place.length for place in left)
        self.explored = explored_share(sight.grid, self.frontier_m)
        counts = len(left), len(near) - len(reachable), len(reachable) - len(left)
        if late:
            reason = f"{self._novelty.limits.longest:g} s are over with the way back"
            return self._go_home(summary(reason, *counts), sight)
        base = self._straight(sight, sight.grid)
        if base is not None:
            return base
        beyond: list[Frontier] = []
        if self._novelty.over(sight.now) and not self._last_looks:
            self._last_looks = True
            self._novelty.restart(sight.now)
        if self._last_looks or not left:
            beyond = self._beyond(sight, sight.grid, near)
        if (not beyond and (self._last_looks or not left)) or self._novelty.over(sight.now):
            reason = f"nothing new for {self._novelty.limits.seconds:g} s" if left else _NOTHING
            return self._go_home(summary(reason, *counts), sight)
        return self._target(beyond or left, FAR_LOOK if beyond else LOOK, sight.now)

    def keeps(self, target: Target, sight: Sight) -> bool:
        """Whether the map still ends there, and the robot is not there yet."""
        if sight.grid is None or self._end is not None:
            return True
        self._look(sight, sight.grid)
        if self._late(sight.now):
            return False
        goal = target.points[-1]
        there = math.dist((goal.x, goal.y), (sight.x, sight.y)) < ARRIVED
        if self._base_line:
            return not there
        if there:
            self._note(target)
            return False
        if self._reach != LOOK:
            return _ends_near(sight.grid, goal.x, goal.y, self._radius + self._reach + ARRIVED)
        left = self._left(self._frontiers(sight, sight.grid, LOOK))
        here = [place for place in left if math.dist((goal.x, goal.y), (place.x, place.y)) < SAME]
        ends = _ends_near(sight.grid, goal.x, goal.y, self._radius + self._reach + ARRIVED)
        if not here:
            # Noise closes a door on one map and opens it on the next.
            return ends and sight.now - self._open_at < CLOSED_S
        self._open_at = sight.now
        if sight.left > DETOUR * min(place.distance for place in here) + DETOUR_M:
            self._note(target)
            return False
        return SWITCH * max(map(self._worth, here)) >= max(map(self._worth, left))

    def reached(self, target: Target, _now: float) -> None:
        """What is still unknown there will stay so for now."""
        if self._end is not None:
            self._home = "it is back at its start"
        self._note(target)

    def blocked(self, target: Target, _left: int, _now: float, why: str) -> None:
        """It cannot be reached for now."""
        if self._end is not None:
            self._home = f"it did not get back to its start: {why}"
        self._note(target)
        self._base_line = False

    def _go_home(self, end: str, sight: Sight) -> Target | End:
        """Go back to the start, where people expect the robot, and then end."""
        self._end, self.frontier_m = end, 0.0
        if math.dist((sight.x, sight.y), (HOME.x, HOME.y)) < AT_HOME:
            self._home = self._home or "it is back at its start"
        if self._home:
            return End(why=f"{end}; {self._home}")
        return Target(points=(HOME,), why=f"returns to its start; {end}")

    def _target(self, left: list[Frontier], look: float, now: float) -> Target:
        """The best of the frontiers that are left."""
        best = max(left, key=self._worth)
        self._reach = look
        self._novelty.set_out()
        self._open_at = now
        why = f"explores: {best.gain:.1f} m² of new ground, {best.distance:.1f} m away"
        return Target(points=(Point(x=best.x, y=best.y),), why=why, patience=PATIENCE_S)

    def _frontiers(
        self, sight: Sight, grid: Grid, look: float, *, in_sight: bool = True
    ) -> tuple[Frontier, ...]:
        """All frontiers with ground behind them."""
        here = (sight.x, sight.y)
        wide = grid.covering((here,), self._radius)
        if wide is None:
            return ()
        found = frontiers(
            wide, here, radius=self._radius, reach=look, shortest=SHORTEST, in_sight=in_sight
        )
        return tuple(place for place in found if place.gain >= LEAST_GAIN)

    def _beyond(self, sight: Sight, grid: Grid, near: tuple[Frontier, ...]) -> list[Frontier]:
        """Where to look from afar into frontiers that the map shows no way to, each once."""
        far = self._frontiers(sight, grid, FAR_LOOK, in_sight=False)
        # Both are of the same edges, in the same order.
        hidden = [
            there
            for here, there in zip(near, far, strict=True)
            if math.isinf(here.distance) and math.isfinite(there.distance)
        ]
        return [place for place in hidden if not self._visits(place)]

    def _straight(self, sight: Sight, grid: Grid) -> Target | None:
        """The base line, or what is left of it; None: it is driven, or the robot moved before."""
        if self._base_line is None:
            self._base_line = base_line.stands_as_it_began(sight.x, sight.y, sight.theta)
        if not self._base_line:
            return None
        left = base_line.LONGEST - math.dist((sight.x, sight.y), (HOME.x, HOME.y))
        ahead = base_line.straight_ahead(
            grid, sight.x, sight.y, sight.theta, radius=self._radius, longest=left
        )
        if ahead is None:
            self._base_line = False
            return None
        return Target(points=(ahead,), why="explores: straight ahead first", patience=PATIENCE_S)

    def _note(self, target: Target) -> None:
        """The robot was at a target in vain, unless it was only the base line's."""
        if self._base_line:
            return
        goal = target.points[-1]
        known = self._at(goal.x, goal.y)
        if known is None:
            self._vain.append(_Vain(goal.x, goal.y, 1))
        else:
            known.visits += 1

    def _at(self, x: float, y: float) -> _Vain | None:
        near = [vain for vain in self._vain if math.hypot(vain.x - x, vain.y - y) < NEAR]
        return max(near, key=lambda vain: vain.visits, default=None)

    def _left(self, found: tuple[Frontier, ...]) -> list[Frontier]:
        """Those that can be reached and are not given up."""
        return [
            place
            for place in found
            if math.isfinite(place.distance) and self._visits(place) < TRIES
        ]

    def _worth(self, place: Frontier) -> float:
        """What a frontier is worth, less for each visit in vain."""
        return worth(place) * VAIN_WORTH ** self._visits(place)

    def _visits(self, place: Frontier) -> int:
        """How often the robot was in vain where it looks into a frontier."""
        vain = self._at(place.x, place.y)
        return 0 if vain is None else vain.visits

    def _look(self, sight: Sight, grid: Grid) -> None:
        """See how much ground is in reach, and how far it is home."""
        self._began = min(self._began, sight.now)
        if grid is not self._seen:
            self._seen = grid
            self._measure(sight, grid)
        if self._novelty.look(self._ground, _free_ground(grid), sight.x, sight.y, sight.now):
            self._last_looks = False

    def _measure(self, sight: Sight, grid: Grid) -> None:
        here, home = (sight.x, sight.y), (HOME.x, HOME.y)
        wide = grid.covering((here, home), self._radius)
        if wide is None:
            return
        lengths = ways(wide, here, radius=self._radius)
        self._ground = standing_ground(wide, lengths, self._radius)
        way = float(lengths[wide.cell(*home)]) * wide.resolution
        self._way_home = way if math.isfinite(way) else DETOUR * math.dist(here, home)

    def _late(self, now: float) -> bool:
        """Whether it is time to go home."""
        back = self._way_home / HOMEWARD_SPEED + HOMEWARD_SPARE_S
        return now - self._began + back >= self._novelty.limits.longest


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


def _free_ground(grid: Grid) -> float:
    """How much is free in a map, wherever it is [m^2]."""
    return float(np.count_nonzero(grid.free)) * grid.resolution**2


def worth(frontier: Frontier) -> float:
    """New ground for the time it takes [m^2/s]; much at once counts for more than its size."""
    return min(frontier.gain, MOST_GAIN) ** 2 / (STOP_S + frontier.distance / SPEED)


def _ends_near(grid: Grid, x: float, y: float, reach: float) -> bool:
    """Whether free ground borders on the unknown within `reach` [m] of a point."""
    rows, columns = np.nonzero(edge_cells(grid))
    row, column = grid.cell(x, y)
    return bool((np.hypot(rows - row, columns - column) <= reach / grid.resolution).any())
