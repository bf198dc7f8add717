"""How well a map shows the true surfaces: precision, recall and F1."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.metrics.coverage import TrueGrid
from rune_study.statistics.arrays import Flags, Floats

TOLERANCE_M = 0.10
"""A marked cell belongs to a surface up to this distance of their middles [m], inclusive."""
_EQUAL = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class MapQuality:
    """A map beside the truth.

    Attributes:
        precision: Share of the marked cells near a true surface; NaN: nothing is marked.
        recall: Share of the true surface near a marked cell.
        f1: Harmonic mean of both; 0: nothing is marked, or nothing fits.
    """

    precision: float
    recall: float
    f1: float


def surface(grid: TrueGrid, within: npt.ArrayLike) -> Flags:
    """Blocked cells that face, with a side, the space in which a robot sees.

    Args:
        grid: The arena.
        within: That space, such as `reachable(grid, start, 0.0)`, shape (height, width).
    """
    space = np.pad(np.asarray(within, bool), 1)
    beside = space[:-2, 1:-1] | space[2:, 1:-1] | space[1:-1, :-2] | space[1:-1, 2:]
    facing: Flags = grid.blocked & beside
    return facing


def middles(cells: npt.ArrayLike, resolution: float, origin_x: float, origin_y: float) -> Floats:
    """Middles of cells [m], shape (cells, 2).

    Args:
        cells: Which cells, shape (height, width).
        resolution: Edge of a cell [m].
        origin_x: Least x of the grid [m].
        origin_y: Least y of the grid [m].
    """
    rows, columns = np.nonzero(np.asarray(cells, bool))
    return np.column_stack(
        (origin_x + (columns + 0.5) * resolution, origin_y + (rows + 0.5) * resolution)
    )


def map_quality(
    marked: npt.ArrayLike, true: npt.ArrayLike, tolerance: float = TOLERANCE_M
) -> MapQuality:
    """Compare the cells of a map with the true surface.

    Args:
        marked: Middles of occupied cells of the map [m], shape (marked, 2), in the true frame.
        true: Middles of the true surface [m], shape (true, 2).
        tolerance: Farthest distance that fits [m].

    Raises:
        DataError: There is no true surface, or a place is not finite.
    """
    first, second = _points(marked), _points(true)
    if not len(second):
        text = "the arena has no surface to compare a map with"
        raise DataError(text)
    if not len(first):
        return MapQuality(precision=math.nan, recall=0.0, f1=0.0)
    precision = float(_near(first, second, tolerance).mean())
    recall = float(_near(second, first, tolerance).mean())
    both = precision + recall
    f1 = 2.0 * precision * recall / both if both else 0.0
    return MapQuality(precision=precision, recall=recall, f1=f1)


def _points(places: npt.ArrayLike) -> Floats:
    array = np.asarray(places, np.float64)
    array = array.reshape(-1, 2) if array.size == 0 else array
    if array.ndim != 2 or array.shape[1] != 2 or not np.isfinite(array).all():
        text = f"places need a finite x and y each, but their shape is {array.shape}"
        raise DataError(text)
    return array


def _near(points: Floats, others: Floats, tolerance: float) -> Flags:
    """Whether each point has one of the others within the tolerance."""
    bound = tolerance + _EQUAL
    order = np.argsort(others[:, 0], kind="stable")
    ordered = others[order]
    first = np.searchsorted(ordered[:, 0], points[:, 0] - bound, side="left")
    last = np.searchsorted(ordered[:, 0], points[:, 0] + bound, side="right")
    near = np.zeros(len(points), np.bool_)
    for place in np.flatnonzero(last > first).tolist():
        beside = ordered[first[place] : last[place]] - points[place]
        near[place] = (np.hypot(beside[:, 0], beside[:, 1]) <= bound).any()
    return near
