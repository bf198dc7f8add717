"""A part of an occupancy grid, as others get it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GridPicture:
    """Cells of a part of the map, as nav_msgs/OccupancyGrid has them.

    Attributes:
        cells: -1 unknown, 0 free to 100 occupied; shape (height, width), row 0 at the least y.
        resolution: Edge of a cell [m].
        origin_x: Lower left corner of cell (0, 0) in `map` [m].
        origin_y: Lower left corner of cell (0, 0) in `map` [m].
    """

    cells: npt.NDArray[np.int8]
    resolution: float
    origin_x: float
    origin_y: float
