"""Plans the path of a round robot on a grid map."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from hub.grids.costs import SQUEEZE, TIGHT, Caution, crossing
from hub.grids.grid import Grid
from hub.grids.wavefront import Cell, Costs, spread, way_back

Way = tuple[tuple[float, float], ...]

_BORDER = 1.0
"""Width of the unknown ground to add around start and goal [m]."""
_LARGER_COST = 1.02
"""A straight line may cost this much more than the cells it replaces."""


def plan(
    grid: Grid,
    start: tuple[float, float],
    goal: tuple[float, float],
    *,
    radius: float,
    comfort: float = 0.3,
    nearness: float = 3.0,
    unknown_cost: float = TIGHT - 1.0,
    squeeze: float = SQUEEZE,
    tolerance: float = 0.3,
) -> Way | None:
    """The cheapest path, with straight lines of almost the same cost.

    Args:
        grid: The map; ground outside it is unknown.
        start: The robot's place [m].
        goal: The place to reach [m].
        radius: The robot's, with the margin it must keep [m].
        comfort: Obstacles farther than this beyond the radius cost nothing [m].
        nearness: Additional cost of a path at the radius, against one in the open.
        unknown_cost: Additional cost of unknown ground; inf: it is not crossed. The default is the
            cost of a tight place: a door that noise makes narrow is better than a path round the
            map.
        squeeze: Without a path over known ground to the goal, the path may cross places with only
            this share of the radius free. They cost ten times as much.
        tolerance: If none does either, the path ends at the nearest reachable place, at most this
            far from the goal [m].

    Returns:
        Points in `map` [m] from the start to the goal, or to its substitute. None: there is no
        path, or a point is not finite or too far outside the map.
    """
    if not all(map(math.isfinite, (*start, *goal))):
        return None
    wide = grid.covering((start, goal), _BORDER)
    if wide is None:
        return None
    first, wanted = wide.cell(*start), wide.cell(*goal)
    caution = Caution(radius=radius, comfort=comfort, nearness=nearness, unknown=unknown_cost)
    factors, costs = _spread(wide, first, wanted, caution)
    if squeeze < 1.0 and not _on_known_ground(wide, factors, costs, wanted):
        caution = dataclasses.replace(caution, squeeze=squeeze * radius)
        factors, costs = _spread(wide, first, wanted, caution)
    last = wanted
    if not math.isfinite(costs[wanted]):
        nearest = _nearest(costs, wanted, tolerance / wide.resolution)
        if nearest is None:
            return None
        last = nearest
    cells = _straightened(factors, costs, way_back(factors, costs, last))
    end = goal if last == wanted else wide.centre(*last)
    return (start, *(wide.centre(*cell) for cell in cells[1:-1]), end)


def _spread(grid: Grid, start: Cell, goal: Cell, caution: Caution) -> tuple[Costs, Costs]:
    """The cost of crossing each cell, and of the paths from the start up to the goal."""
    factors = crossing(grid, start, caution)
    if not math.isfinite(factors[start]):
        return factors, factors
    return factors, spread(factors, start, until=goal)


def _on_known_ground(grid: Grid, factors: Costs, costs: Costs, goal: Cell) -> bool:
    """Whether a path over known free ground leads to the goal."""
    if not math.isfinite(costs[goal]):
        return False
    rows, columns = np.array(way_back(factors, costs, goal)).T
    return not grid.unknown[rows, columns].any()


def _nearest(costs: Costs, goal: Cell, reach_cells: float) -> Cell | None:
    """The reachable cell nearest to the goal."""
    reach = math.floor(reach_cells)
    rows = slice(max(goal[0] - reach, 0), goal[0] + reach + 1)
    columns = slice(max(goal[1] - reach, 0), goal[1] + reach + 1)
    here = np.argwhere(np.isfinite(costs[rows, columns])) + np.array([rows.start, columns.start])
    away = np.hypot(*(here - goal).T)
    if not away.size or away.min() > reach_cells:
        return None
    row, column = here[int(np.argmin(away))]
    return int(row), int(column)


def _straightened(factors: Costs, costs: Costs, way: list[Cell]) -> list[Cell]:
    """Fewer cells of a path: straight lines between them cost as little."""
    kept = [way[0]]
    index = 0
    while index < len(way) - 1:
        index = _farthest_straight(factors, costs, way, index)
        kept.append(way[index])
    return kept


def _farthest_straight(factors: Costs, costs: Costs, way: list[Cell], index: int) -> int:
    """The last cell of the path that a straight line from `index` reaches; found by bisection."""

    def straight(other: int) -> bool:
        spent = costs[way[other]] - costs[way[index]]
        return line_cost(factors, way[index], way[other]) <= _LARGER_COST * float(spent)

    good, step = index + 1, 2
    while index + step < len(way) and straight(index + step):
        good, step = index + step, 2 * step
    bad = min(index + step, len(way))
    while bad - good > 1:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if straight(middle) else (good, middle)
    return good


def line_cost(factors: Costs, start: Cell, end: Cell) -> float:
    """The cost of a straight line between the middles of two cells [cells]; inf: it is blocked.

    The length in each cell that is crossed counts with the cell's factor.
    """
    down, across = end[0] - start[0], end[1] - start[1]
    cuts = np.concatenate(([0.0], _cuts(down), _cuts(across), [1.0]))
    cuts.sort()
    parts = np.diff(cuts)
    middles = cuts[:-1] + 0.5 * parts
    real = parts > 1e-12
    rows = np.rint(start[0] + middles[real] * down).astype(np.intp)
    columns = np.rint(start[1] + middles[real] * across).astype(np.intp)
    return float(np.dot(parts[real], factors[rows, columns])) * math.hypot(down, across)


def _cuts(cells: int) -> npt.NDArray[np.float64]:
    """The crossings of a line over this many cells, as shares of its length."""
    return (np.arange(abs(cells)) + 0.5) / max(abs(cells), 1)
