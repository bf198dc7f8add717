"""Ground that stands out of an arena's floor, as those see it who draw it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from hub.sim.geometry import Surface


class HeightMap(Protocol):
    """A height for each cell of a grid; beyond the grid the floor is level."""

    @property
    def heights(self) -> npt.NDArray[np.float32]:
        """Height of each cell above the floor, 0 or more [m], shape (rows, columns).

        Rows grow with y, columns with x.
        """

    @property
    def cell(self) -> float:
        """Side of a cell [m]."""

    @property
    def origin(self) -> tuple[float, float]:
        """X and y of the corner with the least of both [m]."""

    @property
    def appearance(self) -> npt.NDArray[np.uint16]:
        """Number of each cell's surface, shape (rows, columns)."""

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """The surfaces; the first is the floor's."""
