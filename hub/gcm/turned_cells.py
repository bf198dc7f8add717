"""Turns the cells of an occupancy grid onto the axes of its frame; pure."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.gcm.mapping import MOST_CELLS
from hub.gcm.occupancy_map import OccupancyMap
from hub.pose import Pose

Cells = npt.NDArray[np.int8]
Floats = npt.NDArray[np.float64]

_STRAIGHT: Final = 1e-4
"""Smallest angle that turns a map [rad]: over 100 m it is a centimetre."""
_ROUNDING: Final = 1e-6
_OCCUPIED: Final = 50
"""Least value of an occupied cell, in percent."""


def turned_map(cells: Cells, resolution: float, origin: Pose) -> OccupancyMap | None:
    """A map whose rows are along x, of cells whose rows are turned.

    A cell gets the value of the cell where its middle is. Each occupied cell also gives its value
    to the cell of its own middle, so that no thin wall gets a hole.

    Args:
        cells: -1 unknown, 0 free to 100 occupied; shape (height, width).
        resolution: Edge of a cell [m].
        origin: Of the lower left corner of cell (0, 0) in the frame.

    Returns:
        The map, of the known cells only where it is turned; None: it would be too large.
    """
    if abs(origin.theta) < _STRAIGHT:
        return OccupancyMap(
            cells=cells, resolution=resolution, origin_x=origin.x, origin_y=origin.y
        )
    rows, columns = (np.flatnonzero((cells >= 0).any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        rows = columns = np.array([0])
    known = cells[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    height, width = known.shape
    ahead, left = origin.outward(columns[0] * resolution, rows[0] * resolution)
    corner = Pose(x=ahead, y=left, theta=origin.theta)
    right, top = width * resolution, height * resolution
    ends = np.array([corner.outward(x, y) for x in (0.0, right) for y in (0.0, top)])
    low, size = ends.min(axis=0), np.ptp(ends, axis=0) / resolution
    across, down = (math.ceil(each - _ROUNDING) for each in size.tolist())
    if max(across, down) > MOST_CELLS:
        return None
    made = np.full((down, across), -1, np.int8)
    middles: Floats = low[0] + (np.arange(across, dtype=np.float64) + 0.5) * resolution
    for row in range(down):
        own_x, own_y = corner.inward(middles, np.full(across, low[1] + (row + 0.5) * resolution))
        column, line = _cells(own_x, resolution), _cells(own_y, resolution)
        inside = (column >= 0) & (column < width) & (line >= 0) & (line < height)
        made[row, inside] = known[line[inside], column[inside]]
    line, column = np.nonzero(known >= _OCCUPIED)
    x, y = corner.outward(_middles(column, resolution), _middles(line, resolution))
    places = (
        np.clip(_cells(y - low[1], resolution), 0, down - 1),
        np.clip(_cells(x - low[0], resolution), 0, across - 1),
    )
    np.maximum.at(made, places, known[line, column])
    return OccupancyMap(
        cells=made, resolution=resolution, origin_x=float(low[0]), origin_y=float(low[1])
    )


def _middles(numbers: npt.NDArray[np.intp], resolution: float) -> Floats:
    """The middles of cells along one axis [m], shape (n,)."""
    return np.asarray((numbers + 0.5) * resolution, np.float64)


def _cells(places: Floats, resolution: float) -> npt.NDArray[np.intp]:
    """Numbers of the cells of places along one axis [m], shape (n,)."""
    return np.floor(places / resolution).astype(np.intp)
