"""The height map of an arena's ground."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.geometry import Box, Surface
from hub.sim.ground.elements import Floats
from hub.values import dataclass

Singles = npt.NDArray[np.float32]

NO_DECK = np.float32(np.inf)
"""Height in `decks` where there is none [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeightField:
    """The ground as square tiles, each a plane; steps are where tiles do not meet.

    Beyond the map the ground is level, at height 0.

    Attributes:
        heights: Height in the middle of each cell [m], shape (rows, columns).
        east: Slope of each cell towards east [m/m], same shape.
        north: Slope of each cell towards north [m/m], same shape.
        cell: Side of a cell [m].
        origin: South-west corner of the first cell [m].
        grip: Share of the grip on a dry floor, same shape.
        appearance: Number of each cell's surface in `surfaces`, same shape.
        surfaces: Appearances; the first is the floor's.
        decks: Height of the deck above each cell [m], `NO_DECK` where there is none, same shape;
            None: there are no decks.
        undersides: Height of the lower side of that deck [m], same shape.
        deck_boxes: The decks as boxes to be drawn.
    """

    heights: Singles
    east: Singles
    north: Singles
    cell: float
    origin: tuple[float, float]
    grip: Singles
    appearance: npt.NDArray[np.uint16]
    surfaces: tuple[Surface, ...]
    decks: Singles | None = None
    undersides: Singles | None = None
    deck_boxes: tuple[Box, ...] = ()

    def cells(self, x: Floats, y: Floats) -> npt.NDArray[np.intp]:
        """Flat numbers of the cells at points [m], the nearest cell for points beyond the map."""
        rows, columns = self.heights.shape
        column = np.floor((x - self.origin[0]) / self.cell).clip(0, columns - 1).astype(np.intp)
        row = np.floor((y - self.origin[1]) / self.cell).clip(0, rows - 1).astype(np.intp)
        number: npt.NDArray[np.intp] = row * columns + column
        return number

    def heights_at(self, x: Floats, y: Floats, below: Floats | float = -math.inf) -> Floats:
        """Height of the ground at points [m].

        Args:
            x: Points [m], any shape.
            y: Points [m], same shape.
            below: A deck counts where it is below this height [m].
        """
        cells = self.cells(x, y)
        columns = self.heights.shape[1]
        off = [
            (place - first) / self.cell - number - 0.5
            for place, first, number in zip(
                (x, y), self.origin, (cells % columns, cells // columns), strict=True
            )
        ]
        rise = sum(
            np.clip(part, -0.5, 0.5) * slope.take(cells) * self.cell
            for part, slope in zip(off, (self.east, self.north), strict=True)
        )
        ground: Floats = self.heights.take(cells).astype(np.float64) + rise
        if self.decks is not None:
            decks = self.decks.take(cells)
            ground = np.where(decks < below, decks, ground)
        return ground

    def height(self, x: float, y: float, below: float = -math.inf) -> float:
        """Height of the ground at one point [m]; see `heights_at`."""
        return float(self.heights_at(np.array([x]), np.array([y]), below)[0])
