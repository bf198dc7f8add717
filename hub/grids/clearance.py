"""The distance of every cell to the nearest occupied one.

Source: P. Felzenszwalb, D. Huttenlocher, Distance Transforms of Sampled Functions, 2012: the
square of the distance is separable, columns first, then rows. Distances are capped, so whole rows
are shifted a few times only.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.grids.grid import Mask

MOST_CELLS = 180
"""Largest cap [cells]: the sum of two squares must fit 16 bits."""


def clearance(occupied: Mask, resolution: float, cap: float) -> npt.NDArray[np.float32]:
    """Distance from the middle of each cell to the middle of the nearest occupied one.

    Args:
        occupied: Which cells are occupied, shape (height, width).
        resolution: Edge of a cell [m].
        cap: Largest distance [m], at most 180 cells.

    Returns:
        Distances [m], shape (height, width), exact below the cap. Cells outside count as free.
    """
    reach = max(1, min(math.ceil(cap / resolution), MOST_CELLS))
    columns = _down_the_columns(occupied, reach)
    squares = columns * columns
    nearest = squares.copy()
    shifted = np.empty_like(squares)
    for offset in range(1, min(reach, squares.shape[1] - 1) + 1):
        np.add(squares, np.uint16(offset * offset), out=shifted)
        np.minimum(nearest[:, offset:], shifted[:, :-offset], out=nearest[:, offset:])
        np.minimum(nearest[:, :-offset], shifted[:, offset:], out=nearest[:, :-offset])
    distance: npt.NDArray[np.float32] = np.sqrt(nearest, dtype=np.float32)
    distance *= np.float32(resolution)
    np.minimum(distance, np.float32(min(cap, reach * resolution)), out=distance)
    return distance


def _down_the_columns(occupied: Mask, reach: int) -> npt.NDArray[np.uint16]:
    """Cells to the nearest occupied one of the same column, at most `reach`."""
    height = occupied.shape[0]
    rows = np.arange(height, dtype=np.int32)[:, None]
    above = np.where(occupied, rows, np.int32(-reach))
    np.maximum.accumulate(above, axis=0, out=above)
    below = np.where(occupied, rows, np.int32(height + reach))
    np.minimum.accumulate(below[::-1], axis=0, out=below[::-1])
    near = np.minimum(rows - above, below - rows)
    return np.minimum(near, np.int32(reach)).astype(np.uint16)
