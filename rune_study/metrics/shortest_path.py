"""The shortest path over true ground, in any direction.

It bends at corners of blocked cells only. So it is the shortest path over the lines of sight
between start, goal and corners (T. Lozano-Perez, M. A. Wesley, Commun. ACM 22, 1979). Paths over
the sides and corners of cells bound it from both sides, which leaves few corners to look at.
"""

from __future__ import annotations

import math

import numpy as np

from hub.grids.wavefront import Costs, spread
from rune_study.errors import DataError
from rune_study.metrics.coverage import TrueGrid, standing
from rune_study.statistics.arrays import Flags, Floats

_OCTILE = math.sqrt(4.0 - 2.0 * math.sqrt(2.0))
"""A path in eight directions is at most this much longer than one in any: 8.2 %."""
_SLACK = 3.0
"""More that a path over the middles of cells may be longer [cells]."""


def shortest_path(
    grid: TrueGrid, start: tuple[float, float], goal: tuple[float, float], radius: float = 0.0
) -> float:
    """Length of the shortest path of a round robot [m].

    Args:
        grid: The true arena; its outside cannot be entered.
        start: First place [m].
        goal: Last place [m].
        radius: Of the robot [m]: it does not enter cells with a blocked middle nearer than this.

    Returns:
        NaN if there is no path.

    Raises:
        DataError: Start or goal lie outside the grid.
    """
    points = []
    for name, place in (("start", start), ("goal", goal)):
        row, column = (float(each) for each in grid.cells(*place))
        if not grid.holds(row, column):
            text = f"the {name} ({place[0]:g}, {place[1]:g}) lies outside the arena"
            raise DataError(text)
        points.append((row, column))
    closed = np.pad(~standing(grid, radius), 1, constant_values=True)
    ends = np.array(points) + 1.0
    if in_sight(closed, ends[0], ends[1]):
        return float(np.hypot(*(ends[1] - ends[0]))) * grid.resolution
    begin, end = _cell(ends[0]), _cell(ends[1])
    factors = np.where(closed, np.inf, 1.0)
    if closed[begin] or closed[end]:
        return math.nan
    forth, back = spread(factors, begin), spread(factors, end)
    if not math.isfinite(forth[end]):
        return math.nan
    bound = float(forth[end]) + _SLACK
    nodes = np.vstack((ends, _corners(closed, forth + back, _OCTILE * bound + 2.0 * _SLACK)))
    return _over_corners(closed, nodes) * grid.resolution


def _corners(closed: Flags, lengths: Costs, bound: float) -> Floats:
    """Corners of closed cells where a shortest path may bend, shape (corners, 2).

    Args:
        closed: Cells that cannot be entered.
        lengths: Length of the path over each cell [cells].
        bound: Cells with longer ones are not on the shortest path [cells].
    """
    a, b, c, d = closed[:-1, :-1], closed[:-1, 1:], closed[1:, :-1], closed[1:, 1:]
    count = a.astype(np.int8) + b + c + d
    convex = (count == 1) | ((count == 2) & (a == d))
    near = np.minimum(
        np.minimum(lengths[:-1, :-1], lengths[:-1, 1:]),
        np.minimum(lengths[1:, :-1], lengths[1:, 1:]),
    )
    corners: Floats = np.argwhere(convex & (near <= bound)).astype(np.float64) + 1.0
    return corners


def _cell(place: Floats) -> tuple[int, int]:
    return math.floor(place[0]), math.floor(place[1])


def _over_corners(closed: Flags, nodes: Floats) -> float:
    """Length of the shortest path from node 0 to node 1 over lines of sight, by A* [cells]."""
    direct = np.hypot(*(nodes - nodes[1]).T)
    best = np.full(len(nodes), np.inf)
    best[0] = 0.0
    left = np.ones(len(nodes), np.bool_)
    while True:
        here = int(np.argmin(np.where(left, best + direct, np.inf)))
        if not left[here] or not math.isfinite(best[here]):
            return math.nan
        if here == 1:
            return float(best[1])
        left[here] = False
        away = best[here] + np.hypot(*(nodes - nodes[here]).T)
        better = left & (away < best) & (away + direct < best[1] + 1e-9)
        for other in np.flatnonzero(better).tolist():
            if in_sight(closed, nodes[here], nodes[other]):
                best[other] = away[other]


def in_sight(closed: Flags, start: Floats, end: Floats) -> bool:
    """Whether a straight line enters no closed cell; along their sides and corners it may pass.

    Args:
        closed: Cells that cannot be entered, with a closed border, shape (height, width).
        start: Row and column [cells]; whole numbers are the lower edges of cells.
        end: The same.
    """
    cuts = np.sort(np.concatenate(([0.0, 1.0], *(_cuts(start[k], end[k]) for k in (0, 1)))))
    parts = np.diff(cuts)
    middles = (cuts[:-1] + 0.5 * parts)[parts > 1e-9]
    places = start + middles[:, None] * (end - start)
    # A place on the side of two cells is closed if both are.
    low = np.floor(places - 1e-7).astype(np.intp)
    high = np.floor(places + 1e-7).astype(np.intp)
    shut = closed[low[:, 0], low[:, 1]] & closed[high[:, 0], high[:, 1]]
    return not bool(shut.any())


def _cuts(start: float, end: float) -> Floats:
    """Where a line crosses whole numbers of one coordinate, as shares of its length."""
    low, high = sorted((start, end))
    whole = np.arange(math.ceil(low), math.floor(high) + 1, dtype=np.float64)
    return np.empty(0) if high - low < 1e-9 else (whole - start) / (end - start)
