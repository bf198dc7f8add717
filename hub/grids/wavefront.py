"""The cost of the cheapest path from one cell to all others.

Dijkstra's algorithm, many cells at once. No step costs less than 1. So all cells with a cost below
the least one plus 1 are final and are expanded together (the bound of D. Crauser et al., A
Parallelization of Dijkstra's Shortest Path Algorithm, 1998). The result is exact.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Costs = npt.NDArray[np.float64]
Cell = tuple[int, int]

_DIAGONAL = 2.0**0.5


def spread(factors: Costs, start: Cell, *, until: Cell | None = None) -> Costs:
    """Cost of the cheapest path from `start`, over the sides and corners of cells.

    Args:
        factors: Cost of each cell per its width, at least 1; inf: it cannot be crossed. A step
        costs its length [cells] times the mean of the two cells' factors. Shape (height,
        width).
        start: Row and column; its factor is finite.
        until: Stop when this cell's cost is final.

    Returns:
        Costs [cells], inf: no path, shape (height, width). With `until`, costs greater than its own
        are not final.
    """
    height, width = factors.shape
    stride = width + 2
    edged = np.full((height + 2, stride), np.inf)
    edged[1:-1, 1:-1] = factors
    factor = edged.reshape(-1)
    cost = np.full(factor.size, np.inf)
    number = np.zeros(factor.size, np.intp)
    left = np.zeros(factor.size, np.bool_)
    offsets, halves = _steps(stride)
    waiting = np.array([(start[0] + 1) * stride + start[1] + 1])
    last = -1 if until is None else (until[0] + 1) * stride + until[1] + 1
    cost[waiting] = 0.0
    while waiting.size and not (last >= 0 and left[last]):
        costs = cost[waiting]
        final = costs < costs.min() + 1.0
        now, waiting = waiting[final], waiting[~final]
        # A cell is queued each time its cost falls: keep one entry.
        order = np.arange(now.size)
        number[now] = order
        now = now[(number[now] == order) & ~left[now]]
        left[now] = True
        cells = now[:, None] + offsets
        reached = cost[now][:, None] + halves * (factor[now][:, None] + factor[cells])
        better = reached < cost[cells]
        cells, reached = cells[better], reached[better]
        np.minimum.at(cost, cells, reached)
        waiting = np.concatenate((waiting, cells))
    return cost.reshape(height + 2, stride)[1:-1, 1:-1]


def way_back(factors: Costs, costs: Costs, end: Cell) -> list[Cell]:
    """The cheapest path to `end`, as cells from the start.

    Args:
        factors: As for `spread`.
        costs: The result of `spread`.
        end: Row and column; its cost is finite.
    """
    height, width = factors.shape
    row, column = end
    way = [end]
    while costs[row, column] > 0.0:
        rows = slice(max(row - 1, 0), min(row + 2, height))
        columns = slice(max(column - 1, 0), min(column + 2, width))
        lengths = _LENGTHS[
            rows.start - row + 1 : rows.stop - row + 1,
            columns.start - column + 1 : columns.stop - column + 1,
        ]
        steps = lengths * 0.5 * (factors[rows, columns] + factors[row, column])
        best = int(np.argmin(costs[rows, columns] + steps))
        across = columns.stop - columns.start
        row, column = rows.start + best // across, columns.start + best % across
        way.append((row, column))
    way.reverse()
    return way


_LENGTHS = np.array([[_DIAGONAL, 1.0, _DIAGONAL], [1.0, np.inf, 1.0], [_DIAGONAL, 1.0, _DIAGONAL]])


def _steps(stride: int) -> tuple[npt.NDArray[np.intp], Costs]:
    """Offsets to the eight neighbours in an array of rows, and half the length of each step."""
    offsets = [-stride - 1, -stride, -stride + 1, -1, 1, stride - 1, stride, stride + 1]
    lengths = _LENGTHS[np.isfinite(_LENGTHS)]
    return np.array(offsets, np.intp), 0.5 * lengths
