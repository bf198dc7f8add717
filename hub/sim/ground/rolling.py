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
        self._squares = radii * radii
        cell = field.cell
        self._reach = math.ceil(float(radii.max()) / cell - 1e-9)
        around = np.arange(-self._reach, self._reach + 1)
        columns, rows = (part.ravel() for part in np.meshgrid(around, around))
        nearest = [np.maximum(np.abs(part) - 1, 0) * cell for part in (columns, rows)]
        kept = np.hypot(*nearest) < max(float(radii.max()), cell / 2)
        self._east, self._north = columns[kept, None] * cell, rows[kept, None] * cell
        rows_of_map, columns_of_map = field.heights.shape
        self._offsets = (rows[kept] * columns_of_map + columns[kept])[:, None]
        self._columns = columns_of_map
        last = self._reach + 1e-6
        self._highest = columns_of_map - last, rows_of_map - last
        # The unit normal leans against the slope; a ball touches that share of its radius uphill.
        upright = 1.0 / np.sqrt(
            1.0 + field.east.astype(float) ** 2 + field.north.astype(float) ** 2
        )
        self._is_sloped = bool(field.east.any() or field.north.any())
        self._lean = (field.east * upright, field.north * upright)
        self._grips_alike = bool((field.grip == 1.0).all())
        uneven = (field.east != 0.0) | (field.north != 0.0) | (field.grip != 1.0)
        if field.decks is not None:
            uneven |= np.isfinite(field.decks)
        self._level = np.where(uneven, np.float32(np.nan), field.heights)

    def supports(self, x: Floats, y: Floats, middle: Floats) -> tuple[Floats, Floats]:
        """How low wheels can go.

        Args:
            x: Middles of the wheels, several places of all wheels one after the other [m],
                shape (k n,).
            y: The same [m].
            middle: Present height of the middles [m]; decks above it do not count.

        Returns:
            Height of the lowest point of each wheel that stands there [m], and the share of the
            grip where it touches; each of shape (k n,).
        """
        field = self._field
        cell, half = field.cell, field.cell / 2
        column = (x - field.origin[0]) / cell
        row = (y - field.origin[1]) / cell
        level = self._level_height(column, row)
        if level is not None:
            return np.full(len(x), level), np.ones(len(x))
        radii, squares = self._radii, self._squares
        if len(x) != len(radii):
            times = len(x) // len(radii)
            radii, squares = np.tile(radii, times), np.tile(squares, times)
        column = np.minimum(np.maximum(column, self._reach), self._highest[0])
        row = np.minimum(np.maximum(row, self._reach), self._highest[1])
        whole_column, whole_row = column.astype(np.intp), row.astype(np.intp)
        tiles = self._offsets + (whole_row * self._columns + whole_column)
        off_x = ((column - whole_column) - 0.5) * cell - self._east
        off_y = ((row - whole_row) - 0.5) * cell - self._north
        heights = field.heights.take(tiles)
        if self._is_sloped:
            lean_x, lean_y = (part.take(tiles) for part in self._lean)
            slope_x, slope_y = field.east.take(tiles), field.north.take(tiles)
        if field.decks is not None:
            decks = field.decks.take(tiles)
            reached = decks < middle
            heights = np.where(reached, decks, heights)
            if self._is_sloped:
                lean_x, lean_y, slope_x, slope_y = (
                    np.where(reached, 0.0, part) for part in (lean_x, lean_y, slope_x, slope_y)
                )
        if self._is_sloped:
            touch_x = np.minimum(np.maximum(off_x + lean_x * radii, -half), half)
            touch_y = np.minimum(np.maximum(off_y + lean_y * radii, -half), half)
            heights = heights + slope_x * touch_x + slope_y * touch_y
        else:
            touch_x = np.minimum(np.maximum(off_x, -half), half)
            touch_y = np.minimum(np.maximum(off_y, -half), half)
        off_x -= touch_x
        off_y -= touch_y
        under = squares - off_x * off_x - off_y * off_y
        lift = heights + np.sqrt(np.maximum(under, 0.0))
        lift[under < 0.0] = -np.inf
        if self._grips_alike:
            return lift.max(axis=0) - radii, np.ones(len(x))
        best = lift.argmax(axis=0)
        wheels = np.arange(len(x))
        return lift[best, wheels] - radii, field.grip.take(tiles[best, wheels])

    def _level_height(self, column: Floats, row: Floats) -> float | None:
        """Height of the ground under all wheels, if it is level there, for speed [m]."""
        around = []
        for places, count in zip((row, column), self._level.shape, strict=True):
            first = int(places.min()) - self._reach - 1
            last = int(places.max()) + self._reach + 2
            around.append(slice(max(0, min(first, count - 1)), max(1, min(last, count))))
        tiles = self._level[around[0], around[1]]
        height = tiles[0, 0]
        return float(height) if bool((tiles == height).all()) else None
