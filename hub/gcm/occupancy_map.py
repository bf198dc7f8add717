"""A part of an occupancy grid with its cells decoded, as the hub and the console work on it."""

from __future__ import annotations

from typing import Self

import numpy as np
import numpy.typing as npt

from hub.gcm import map_coding
from hub.gcm.mapping import Map
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OccupancyMap:
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

    @classmethod
    def of(cls, message: Map) -> Self:
        """The map in a message.

        Raises:
            CodecError: The message does not match its own sizes.
        """
        return cls(
            cells=map_coding.decode(message.data, message.height_cells, message.width_cells),
            resolution=message.resolution,
            origin_x=message.origin_x,
            origin_y=message.origin_y,
        )

    def message(self, stamp: float) -> Map:
        """The message with this map, measured at a time [s since the epoch]."""
        height, width = self.cells.shape
        return Map(
            stamp=stamp,
            resolution=self.resolution,
            width_cells=width,
            height_cells=height,
            origin_x=self.origin_x,
            origin_y=self.origin_y,
            data=map_coding.encode(self.cells),
        )
