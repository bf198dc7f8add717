"""Where wheels touch the ground: the grey dilation of the height map by a ball, at points.

A wheel counts as a ball. It rests on the tile that lifts it most: at the point of the tile where
tile and ball have the same slope, or at the nearest point of the tile's edge. So ramps and edges of
steps are exact, however large the cells are.
"""

from __future__ import annotations

import math

import numpy as np

from hub.sim.ground.elements import Floats
from hub.sim.ground.height_field import HeightField

_SLOPED, _SLIPPERY, _ROOFED = 1, 2, 4
"""Kinds of tiles that need more than a level tile of full grip."""


class RollingGround:
    """The ground under wheels of given radii."""

    def __init__(self, field: HeightField, radii: Floats) -> None:
        """Prepare for wheels.

        Args:
            field: The ground.
            radii: Radius of each wheel, 0 for a point [m], shape (n,).
        """
        self._field = field
        self._radii = radii
        self._wheels = {
            len(each): (each, each * each) for each in (radii, np.concatenate((radii, radii)))
        }
        cell = field.cell
        self._reach = math.ceil(float(radii.max()) / cell - 1e-9)
        around = np.arange(-self._reach, self._reach + 1)
        columns, rows = (part.ravel() for part in np.meshgrid(around, around))
        nearest = [np.maximum(np.abs(part) - 1, 0) * cell for part in (columns, rows)]
        kept = np.hypot(*nearest) < max(float(radii.max()), cell / 2)
        self._east, self._north = columns[kept, None] * cell, rows[kept, None] * cell
        self._rows, self._columns = field.heights.shape
        self._offsets = (rows[kept] * self._columns + columns[kept])[:, None]
        # The unit normal leans against the slope; a ball touches that share of its radius uphill.
        upright = 1.0 / np.sqrt(
            1.0 + field.east.astype(float) ** 2 + field.north.astype(float) ** 2
        )
        self._lean = (field.east * upright, field.north * upright)
        self._kinds = _SLOPED * ((field.east != 0.0) | (field.north != 0.0)).astype(np.uint8)
        self._kinds |= _SLIPPERY * (field.grip != 1.0).astype(np.uint8)
        if field.decks is not None:
            self._kinds |= _ROOFED * np.isfinite(field.decks).astype(np.uint8)

    def supports(self, x: Floats, y: Floats, middle: Floats) -> tuple[Floats, Floats]:
        """How low wheels can go.

        Args:
            x: Middles of the wheels at one place, or at two one after the other [m], shape (n,) or
                (2 n,).
            y: The same [m].
            middle: Present height of the middles [m]; decks above it do not count.

        Returns:
            Height of the lowest point of each wheel that stands there [m], and the share of the
            grip where it touches; each of the same shape.
        """
        field = self._field
        cell, half = field.cell, field.cell / 2
        column = (x - field.origin[0]) / cell
        row = (y - field.origin[1]) / cell
        window = self._window(row, self._rows), self._window(column, self._columns)
        kinds = int(np.bitwise_or.reduce(self._kinds[window], axis=None))
        if not kinds:
            around = field.heights[window]
            first = around[0, 0]
            if (around == first).all():
                return np.full(len(x), float(first)), np.ones(len(x))
        radii, squares = self._wheels[len(x)]
        column = np.minimum(np.maximum(column, self._reach), self._columns - self._reach - 1e-6)
        row = np.minimum(np.maximum(row, self._reach), self._rows - self._reach - 1e-6)
        whole_column, whole_row = column.astype(np.intp), row.astype(np.intp)
        tiles = self._offsets + (whole_row * self._columns + whole_column)
        off_x = ((column - whole_column) - 0.5) * cell - self._east
        off_y = ((row - whole_row) - 0.5) * cell - self._north
        heights = field.heights.take(tiles)
        reached = None
        if kinds & _ROOFED and field.decks is not None:
            decks = field.decks.take(tiles)
            reached = decks < middle
            heights = np.where(reached, decks, heights)
        touch_x, touch_y = off_x, off_y
        if kinds & _SLOPED:
            parts = [part.take(tiles) for part in (*self._lean, field.east, field.north)]
            if reached is not None:
                parts = [np.where(reached, 0.0, part) for part in parts]
            touch_x, touch_y = off_x + parts[0] * radii, off_y + parts[1] * radii
        touch_x = np.minimum(np.maximum(touch_x, -half), half)
        touch_y = np.minimum(np.maximum(touch_y, -half), half)
        if kinds & _SLOPED:
            heights = heights + parts[2] * touch_x + parts[3] * touch_y
        off_x -= touch_x
        off_y -= touch_y
        under = squares - off_x * off_x - off_y * off_y
        lift = heights + np.sqrt(np.maximum(under, 0.0))
        lift[under < 0.0] = -np.inf
        if not kinds & _SLIPPERY:
            return lift.max(axis=0) - radii, np.ones(len(x))
        best = lift.argmax(axis=0)
        wheels = np.arange(len(x))
        return lift[best, wheels] - radii, field.grip.take(tiles[best, wheels])

    def _window(self, places: Floats, count: int) -> slice:
        """The rows or columns of the map that wheels can touch."""
        first = int(places.min()) - self._reach - 1
        last = int(places.max()) + self._reach + 2
        return slice(max(0, min(first, count - 1)), max(1, min(last, count)))
