"""Pairs of marks and true places: as many as possible, and then as near as possible; pure.

The assignment problem by H. W. Kuhn's Hungarian method (Naval Res. Logist. 2, 1955), with shortest
augmenting paths (R. Jonker, A. Volgenant, Computing 38, 1987): O(rows^2 columns).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.values import dataclass

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class MarkedPlace:
    """A mark and the place that it belongs to.

    Attributes:
        mark: Index of the mark.
        place: Index of the place.
        distance: Between both [m].
    """

    mark: int
    place: int
    distance: float


def match(marks: npt.ArrayLike, places: npt.ArrayLike, radius: float) -> tuple[MarkedPlace, ...]:
    """Pair marks with places, each at most once.

    Among all ways with the most pairs, the sum of distances is the least.

    Args:
        marks: x and y [m], shape (marks, 2); marks that are not finite have no pair.
        places: x and y [m], shape (places, 2).
        radius: Farthest distance of a pair, inclusive [m].

    Returns:
        Pairs by the index of their place.
    """
    first = np.asarray(marks, np.float64).reshape(-1, 2)
    second = np.asarray(places, np.float64).reshape(-1, 2)
    apart = np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1))
    with np.errstate(invalid="ignore"):
        near = apart <= radius + 1e-9
    # One pair more is worth any distance.
    none = radius * (min(apart.shape) + 1.0) + 1.0
    pairs = [
        MarkedPlace(mark=row, place=column, distance=float(apart[row, column]))
        for row, column in assignment(np.where(near, apart, none))
        if near[row, column]
    ]
    return tuple(sorted(pairs, key=lambda each: each.place))


def assignment(costs: Floats) -> list[tuple[int, int]]:
    """Pairs of rows and columns with the least sum of costs; every row or every column has one.

    Args:
        costs: Finite costs, shape (rows, columns).
    """
    if costs.shape[0] > costs.shape[1]:
        return [(row, column) for column, row in assignment(costs.T)]
    rows, columns = costs.shape
    # Row 0 and column 0 are none: a column whose row is 0 is free.
    of_row, of_column = np.zeros(rows + 1), np.zeros(columns + 1)  # potentials
    row_at, before = np.zeros(columns + 1, np.intp), np.zeros(columns + 1, np.intp)
    for new in range(1, rows + 1):
        row_at[0], column = new, 0
        least, done = np.full(columns + 1, np.inf), np.zeros(columns + 1, np.bool_)
        while column == 0 or row_at[column]:
            done[column] = True
            row = row_at[column]
            left = np.append(np.inf, costs[row - 1] - of_row[row] - of_column[1:])
            better = ~done & (left < least)
            least[better], before[better] = left[better], column
            column = int(np.argmin(np.where(done, np.inf, least)))
            step = least[column]
            of_row[row_at[done]] += step
            of_column[done] -= step
            least[~done] -= step
        while column:  # shift the pairs along the path
            row_at[column] = row_at[before[column]]
            column = int(before[column])
    return [(int(row) - 1, column) for column, row in enumerate(row_at[1:]) if row]
