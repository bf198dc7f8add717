"""A grid map as an array, and the places of its cells in the frame `map`."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.errors import CodecError
from hub.gcm.mapping import Map
from hub.gcm.occupancy_map import OccupancyMap

UNKNOWN = -1
MOST_FREE = 45
"""A cell up to this is free: it was seen free more often than occupied."""
LEAST_OCCUPIED = 65
"""A cell from this on is occupied, as in ROS's map_server; between the two it is uncertain."""
MAX_CELLS = 1 << 22
"""Largest number of cells of a grid: 100 m by 100 m at 5 cm."""

_FARTHEST = 1e6
"""Largest coordinate of an origin [m]."""
_FINEST, _COARSEST = 0.001, 10.0

Mask = npt.NDArray[np.bool_]


class Grid(OccupancyMap):
    """A grid map in the frame `map`, and the places of its cells."""

    __slots__ = ()

    @property
    def height_cells(self) -> int:
        """Number of rows."""
        return len(self.cells)

    @property
    def width_cells(self) -> int:
        """Number of columns."""
        width: int = self.cells.shape[1]
        return width

    @property
    def occupied(self) -> Mask:
        """Which cells are occupied, shape (height, width)."""
        return self.cells >= LEAST_OCCUPIED

    @property
    def free(self) -> Mask:
        """Which cells are free, shape (height, width)."""
        return (self.cells >= 0) & (self.cells <= MOST_FREE)

    @property
    def unknown(self) -> Mask:
        """Which cells have never been seen, shape (height, width)."""
        return self.cells < 0

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Row and column of the cell at a finite point [m]; it may lie outside."""
        return (
            math.floor((y - self.origin_y) / self.resolution),
            math.floor((x - self.origin_x) / self.resolution),
        )

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """The middle of a cell [m]."""
        return (
            self.origin_x + (column + 0.5) * self.resolution,
            self.origin_y + (row + 0.5) * self.resolution,
        )

    def contains(self, row: int, column: int) -> bool:
        """Whether the grid has this cell."""
        return 0 <= row < self.height_cells and 0 <= column < self.width_cells

    def covering(self, points: tuple[tuple[float, float], ...], border: float) -> Grid | None:
        """This grid, extended by unknown cells so that it holds all points.

        Args:
            points: Finite points [m].
            border: Distance from each point to the edge of the grid [m].

        Returns:
            None if it would have more than MAX_CELLS cells.
        """
        corners = [self.cell(x + side, y + side) for x, y in points for side in (-border, border)]
        low_row, low_column = (min(0, *(c[axis] for c in corners)) for axis in (0, 1))
        height = max(self.height_cells - 1, *(row for row, _ in corners)) + 1 - low_row
        width = max(self.width_cells - 1, *(column for _, column in corners)) + 1 - low_column
        if height * width > MAX_CELLS:
            return None
        if (height, width) == self.cells.shape:
            return self
        cells = np.full((height, width), UNKNOWN, np.int8)
        cells[-low_row:, -low_column:][: self.height_cells, : self.width_cells] = self.cells
        return Grid(
            cells=cells,
            resolution=self.resolution,
            origin_x=self.origin_x + low_column * self.resolution,
            origin_y=self.origin_y + low_row * self.resolution,
        )


def grid_of(message: Map) -> Grid:
    """The grid in a message.

    Raises:
        CodecError: The message holds no map, or one of more than MAX_CELLS cells.
    """
    fine = _FINEST <= message.resolution <= _COARSEST
    near = abs(message.origin_x) <= _FARTHEST and abs(message.origin_y) <= _FARTHEST
    if not (fine and near) or message.width_cells * message.height_cells > MAX_CELLS:
        text = (
            f"a map of {message.width_cells}x{message.height_cells} cells of {message.resolution} m"
            f" at {message.origin_x}, {message.origin_y} cannot be worked on"
        )
        raise CodecError(text)
    return Grid.of(message)
