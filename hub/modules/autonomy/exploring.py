"""The task of exploring: goes to the map's edges until they bring no new ground; pure."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.navigation import Point
from hub.grids.frontiers import Frontier, edge_cells, frontiers
from hub.grids.grid import Grid
from hub.grids.reach import standing_ground, ways
from hub.modules.autonomy import base_line
from hub.modules.autonomy.autonomy_task import End, Pause, Sight, Target
from hub.modules.autonomy.novelty import Limits, Novelty
from hub.values import dataclass

SHORTEST = 0.3
"""Shortest frontier; a shorter one is a gap between the cones of sensors [m]."""
LEAST_GAIN = 0.5
"""Least ground behind a frontier that the robot may stand on [m^2]."""
MOST_GAIN = 12.0
"""Most ground behind a frontier that counts: the robot sees no more at once [m^2]."""
VIEW_DISTANCE = 0.3
"""Distance of a view point from its frontier, beyond the robot's radius [m]."""
FAR_VIEW_DISTANCE = 1.5
"""The same for the last frontiers, even through walls: a wall may be noise that vanishes nearby."""
ARRIVED = 0.4
"""Distance at which a place is reached and its unknown ground seen [m]."""
NEAR = 0.5
"""Places nearer to each other than this are the same [m]."""
HOME = Point(x=0.0, y=0.0)
"""The robot's start: the origin of `map`."""
AT_HOME = 0.5
"""Largest distance at which the robot is at its start [m]."""
DETOUR, DETOUR_M = 1.5, 4.0
"""A path that is longer than planned by this factor and this length [m] has an obstacle."""
SAME = 1.0
"""Largest distance between the target and the view point of its frontier [m]."""
SWITCH = 2.0
"""Factor by which another frontier's value must exceed the target's to replace it."""
FAILED_VISIT_FACTOR = 0.2
"""Share of a frontier's value that each failed visit leaves."""
TRIES = 3
"""Number of failed visits after which a place is given up."""
SPEED = 0.35
"""Average speed of the robot, with turns [m/s]."""
RETURN_SPEED = 0.2
"""Least average speed on the path back to the start [m/s]."""
RETURN_RESERVE_S = 20.0
"""Reserve of time for the path back to the start [s]."""
STOP_S = 6.0
"""Extra time of each target: to look, and to turn away [s]."""
CLOSED_S = 12.0
"""Time after which a target without a path on the map is dropped [s]."""
CLOSED_WAIT_S = 6.0
"""Longest wait of navigation at a closed path [s]."""

LOOK_S = 3.0
"""Time with a map before exploring may end: the first maps lack most of what sensors see [s]."""

_NOTHING = "nothing is left"
_LOOKS = "looks around"


@dataclass(slots=True)
class _FailedVisits:
    """A place with a failed visit: the robot could not reach it, or its frontier stayed."""

    x: float
    y: float
    visits: int


class Explore:
    """Goes to the frontier with most new ground for its time, until none is left.

    Only ground where the robot may stand counts: gaps between two sonars' cones, and ground behind
    furniture, do not. Sonars miss walls at a flat angle, so some frontiers stay after a visit. Each
    failed visit lowers a frontier's value, until it is given up. Noise closes doors on the map
    until the robot is near. So the robot also approaches frontiers without a path, as near as it
    can.

    A robot at its start drives its base line first, which makes all later poses more exact.

    Drift shows known places again as new ones, so exploring ends when the ground in reach grows no
    more. It also ends at a time limit: a robot that has lost its place sees new ground all the
    time. At the end the robot goes back to its start.

    Attributes:
        needs_map: True.
        frontier_m: Length of all frontiers that are left and not given up [m].
        explored: Share of the known ground's edge without these frontiers, 0 to 1.
    """

    def __init__(self, radius: float, limits: Limits) -> None:
        """Start without a map.

        Args:
            radius: The robot's, with the margin it must keep [m].
            limits: Limits at which it ends although frontiers are left.
        """
        self.needs_map = True
        self.frontier_m = self.explored = math.nan
        self._radius = radius
        self._novelty = Novelty(limits)
        self._seen: Grid | None = None
        self._began = math.inf
        self._ground = self._path_home = 0.0
        self._reach = VIEW_DISTANCE
        self._failed: list[_FailedVisits] = []
        self._open_at = -math.inf
        self._end: str | None = None
        self._home = ""
        self._last_frontiers = False
        self._base_line: bool | None = None

    def choose(self, sight: Sight) -> Target | Pause | End:
        """The next frontier, or the end."""
        if self._end is not None:
            return self._go_home(self._end, sight)
        if sight.grid is not None:
            self._measure_ground(sight, sight.grid)
        late = self._late(sight.now)
        if sight.grid is None or not (sight.fresh or late):
            return Pause(why=_LOOKS)
        near = self._frontiers(sight, sight.grid, VIEW_DISTANCE)
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
        if self._novelty.over(sight.now) and not self._last_frontiers:
            self._last_frontiers = True
            self._novelty.restart(sight.now)
        if self._last_frontiers or not left:
            beyond = self._beyond(sight, sight.grid, near)
        if (not beyond and (self._last_frontiers or not left)) or self._novelty.over(sight.now):
            if not sight.grid.free.any() or sight.now - self._began < LOOK_S:
                return Pause(why=_LOOKS)
            reason = f"nothing new for {self._novelty.limits.seconds:g} s" if left else _NOTHING
            return self._go_home(summary(reason, *counts), sight)
        return self._target(
            beyond or left, FAR_VIEW_DISTANCE if beyond else VIEW_DISTANCE, sight.now
        )

    def keeps(self, target: Target, sight: Sight) -> bool:
        """Whether the map still ends there, and the robot is not yet there."""
        if sight.grid is None or self._end is not None:
            return True
        self._measure_ground(sight, sight.grid)
        if self._late(sight.now):
            return False
        goal = target.points[-1]
        there = math.dist((goal.x, goal.y), (sight.x, sight.y)) < ARRIVED
        if self._base_line:
            return not there
        if there:
            self._note(target)
            return False
        if self._reach != VIEW_DISTANCE:
            return _ends_near(sight.grid, goal.x, goal.y, self._radius + self._reach + ARRIVED)
        left = self._left(self._frontiers(sight, sight.grid, VIEW_DISTANCE))
        here = [place for place in left if math.dist((goal.x, goal.y), (place.x, place.y)) < SAME]
        ends = _ends_near(sight.grid, goal.x, goal.y, self._radius + self._reach + ARRIVED)
        if not here:
            # Noise closes a door on one map and opens it on the next.
            return ends and sight.now - self._open_at < CLOSED_S
        self._open_at = sight.now
        if sight.left > DETOUR * min(place.distance for place in here) + DETOUR_M:
            self._note(target)
            return False
        return SWITCH * max(map(self._value, here)) >= max(map(self._value, left))

    def reached(self, target: Target, _now: float) -> None:
        """Note a visit: ground that is still unknown there stays so for now."""
        if self._end is not None:
            self._home = "it is back at its start"
        self._note(target)

    def blocked(self, target: Target, _left: int, _now: float, why: str) -> None:
        """Note a failed visit."""
        if self._end is not None:
            self._home = f"it did not get back to its start: {why}"
        self._note(target)
        self._base_line = False

    def _go_home(self, end: str, sight: Sight) -> Target | End:
        """Go back to the start, and then end."""
        self._end, self.frontier_m = end, 0.0
        if math.dist((sight.x, sight.y), (HOME.x, HOME.y)) < AT_HOME:
            self._home = self._home or "it is back at its start"
        if self._home:
            return End(why=f"{end}; {self._home}")
        return Target(points=(HOME,), why=f"returns to its start; {end}")

    def _target(self, left: list[Frontier], look: float, now: float) -> Target:
        """The best of the remaining frontiers."""
        best = max(left, key=self._value)
        self._reach = look
        self._novelty.set_out()
        self._open_at = now
        why = f"explores: {best.gain:.1f} m² of new ground, {best.distance:.1f} m away"
        return Target(points=(Point(x=best.x, y=best.y),), why=why, patience=CLOSED_WAIT_S)

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
        """View points of frontiers without a path on the map, each once."""
        far = self._frontiers(sight, grid, FAR_VIEW_DISTANCE, in_sight=False)
        # Both have the same edges, in the same order.
        hidden = [
            there
            for here, there in zip(near, far, strict=True)
            if math.isinf(here.distance) and math.isfinite(there.distance)
        ]
        return [place for place in hidden if not self._visits(place)]

    def _straight(self, sight: Sight, grid: Grid) -> Target | None:
        """The base line, or its rest; None: it is driven, or the robot moved before."""
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
        return Target(points=(ahead,), why="explores: straight ahead first", patience=CLOSED_WAIT_S)

    def _note(self, target: Target) -> None:
        """Count a failed visit, unless the target was the base line's."""
        if self._base_line:
            return
        goal = target.points[-1]
        known = self._at(goal.x, goal.y)
        if known is None:
            self._failed.append(_FailedVisits(goal.x, goal.y, 1))
        else:
            known.visits += 1

    def _at(self, x: float, y: float) -> _FailedVisits | None:
        near = [failed for failed in self._failed if math.hypot(failed.x - x, failed.y - y) < NEAR]
        return max(near, key=lambda failed: failed.visits, default=None)

    def _left(self, found: tuple[Frontier, ...]) -> list[Frontier]:
        """The frontiers that can be reached and are not given up."""
        return [
            place
            for place in found
            if math.isfinite(place.distance) and self._visits(place) < TRIES
        ]

    def _value(self, place: Frontier) -> float:
        """The value of a frontier, less for each failed visit."""
        return value(place) * FAILED_VISIT_FACTOR ** self._visits(place)

    def _visits(self, place: Frontier) -> int:
        """The number of failed visits at a view point."""
        failed = self._at(place.x, place.y)
        return 0 if failed is None else failed.visits

    def _measure_ground(self, sight: Sight, grid: Grid) -> None:
        """Measure the ground in reach, and the path home."""
        self._began = min(self._began, sight.now)
        if grid is not self._seen:
            self._seen = grid
            self._measure(sight, grid)
        if self._novelty.see_map(self._ground, _free_ground(grid), sight.x, sight.y, sight.now):
            self._last_frontiers = False

    def _measure(self, sight: Sight, grid: Grid) -> None:
        here, home = (sight.x, sight.y), (HOME.x, HOME.y)
        wide = grid.covering((here, home), self._radius)
        if wide is None:
            return
        lengths = ways(wide, here, radius=self._radius)
        self._ground = standing_ground(wide, lengths, self._radius)
        way = float(lengths[wide.cell(*home)]) * wide.resolution
        self._path_home = way if math.isfinite(way) else DETOUR * math.dist(here, home)

    def _late(self, now: float) -> bool:
        """Whether it is time to go home."""
        back = self._path_home / RETURN_SPEED + RETURN_RESERVE_S
        return now - self._began + back >= self._novelty.limits.longest


def summary(reason: str, left: int, out_of_reach: int, given_up: int) -> str:
    """The result of exploring, for people.

    Args:
        reason: The reason for the end.
        left: Frontiers that can be reached.
        out_of_reach: Frontiers without a path on the map.
        given_up: Frontiers with too many failed visits.
    """
    counts = {"left": left, "out of reach": out_of_reach, "given up": given_up}
    parts = [f"{count} {name}" for name, count in counts.items() if count]
    if not parts:
        return f"explored: {reason}"
    return f"explored: {reason}; frontiers: {', '.join(parts)}"


def explored_share(grid: Grid, frontier_m: float) -> float:
    """Share of the known free ground's edge that needs no exploring, 0 to 1.

    Args:
        grid: The map.
        frontier_m: Length of the edge that is left to explore [m].
    """
    free = np.pad(grid.free, 1)
    inner = free[:-2, 1:-1] & free[2:, 1:-1] & free[1:-1, :-2] & free[1:-1, 2:]
    edge = float(np.count_nonzero(grid.free & ~inner)) * grid.resolution
    return max(0.0, 1.0 - frontier_m / edge) if edge else 0.0


def _free_ground(grid: Grid) -> float:
    """The whole free ground of a map [m^2]."""
    return float(np.count_nonzero(grid.free)) * grid.resolution**2


def value(frontier: Frontier) -> float:
    """New ground for its time [m^2/s]; much ground at once counts more."""
    return min(frontier.gain, MOST_GAIN) ** 2 / (STOP_S + frontier.distance / SPEED)


def _ends_near(grid: Grid, x: float, y: float, reach: float) -> bool:
    """Whether free ground borders on the unknown within `reach` [m] of a point."""
    rows, columns = np.nonzero(edge_cells(grid))
    row, column = grid.cell(x, y)
    return bool((np.hypot(rows - row, columns - column) <= reach / grid.resolution).any())
