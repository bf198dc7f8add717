"""Draws occupancy grids at any place, angle and size; thin walls stay visible."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.gcm.occupancy_map import OccupancyMap
from rune_tui.model.map_window import MapWindow
from rune_tui.model.sightings import Floats
from rune_tui.raster.canvas import Colour

Cells = npt.NDArray[np.int8]
Places = npt.NDArray[np.intp]

UNKNOWN: Final = -1
"""An unknown cell; known cells are 0 (free) to 100 (occupied)."""
OUTSIDE: Final = -2
"""A place outside the grid."""

_SURELY_MET: Final = math.sqrt(0.5)
"""Largest pixel [cells] with which every cell contains the middle of a pixel, at any angle."""


def grid_colours(
    *, free: Colour, occupied: Colour, unknown: Colour, outside: Colour
) -> npt.NDArray[np.uint8]:
    """Colours by a cell's value as an unsigned byte, shape (256, 4).

    Values between free and occupied get mixed colours; invalid values look unknown.
    """
    colours = np.empty((256, 4), np.uint8)
    colours[:] = unknown
    share = np.linspace(0.0, 1.0, 101)[:, None]
    colours[:101] = np.rint(np.array(free) * (1.0 - share) + np.array(occupied) * share)
    colours[OUTSIDE] = outside
    return colours


def grid_values(grid: OccupancyMap, window: MapWindow) -> Cells:
    """Values of a map at the pixels of a window.

    A small pixel shows the cell at its middle. For larger pixels, blocks of cells of at most a
    pixel's size are reduced to their most occupied cell. A pixel shows the most occupied of the
    block at its middle and the blocks with their middles in it. The error of a place is about half
    a pixel, and no occupied cell is lost.

    Returns:
        Shape (window.height, window.width); OUTSIDE beyond the grid.
    """
    cells, resolution, origin = grid.cells, grid.resolution, (grid.origin_x, grid.origin_y)
    values = np.full((window.height, window.width), OUTSIDE, np.int8)
    if not resolution > 0.0 or not all(map(math.isfinite, origin)):
        return values
    scale = window.metres_per_pixel / resolution
    step = max(1, math.floor(min(scale, max(cells.shape))))
    first_column, first_row, seen = _in_window(grid, window, step)
    blocks = _most_occupied(_most_occupied(seen, step).T, step).T
    if not blocks.size:
        return values
    corner = np.array(origin) + np.array((first_column, first_row)) * resolution
    edge = step * resolution
    column, row, within = _lattice(
        lambda pixels: (window.points(pixels) - corner) / edge, values.shape, blocks.shape
    )
    values[within] = blocks[row[within], column[within]]
    if scale > _SURELY_MET:
        column, row, within = _lattice(
            lambda places: window.pixels(corner + places * edge), blocks.shape, values.shape
        )
        place = row[within] * window.width + column[within]
        np.maximum.at(values.reshape(-1), place, blocks[within])
    return values


def _in_window(grid: OccupancyMap, window: MapWindow, step: int) -> tuple[int, int, Cells]:
    """First column and row of the visible blocks of cells, and the visible cells."""
    wide, high = float(window.width), float(window.height)
    corners = window.points([(0.0, 0.0), (wide, 0.0), (0.0, high), (wide, high)])
    places = (corners - np.array((grid.origin_x, grid.origin_y))) / grid.resolution
    largest = np.array(grid.cells.shape[::-1], np.float64)
    low = (np.clip(places.min(axis=0) // step, 0.0, largest // step) * step).astype(int)
    end = np.clip(np.ceil(places.max(axis=0) / step) * step, 0.0, largest).astype(int)
    return int(low[0]), int(low[1]), grid.cells[low[1] : end[1], low[0] : end[0]]


def _most_occupied(cells: Cells, step: int) -> Cells:
    """Maximum of each `step` rows; the last group may have fewer."""
    greatest = cells[::step].copy()
    for offset in range(1, min(step, len(cells))):
        rows = cells[offset::step]
        np.maximum(greatest[: len(rows)], rows, out=greatest[: len(rows)])
    return greatest


def _lattice(
    affine: Callable[[Floats], Floats], shape: tuple[int, ...], target: tuple[int, ...]
) -> tuple[Places, Places, npt.NDArray[np.bool_]]:
    """Places of the middles of one raster's squares in another raster.

    Args:
        affine: From coordinates (x, y) in the first raster to the second, shape (n, 2).
        shape: Rows and columns of the first.
        target: Rows and columns of the second.

    Returns:
        Column, row, and whether they are inside the second; each of the first's shape.
    """
    start, right, below = affine(np.array([(0.5, 0.5), (1.5, 0.5), (0.5, 1.5)]))
    across, down = np.arange(shape[1]), np.arange(shape[0])[:, None]
    # An affine map keeps equal steps equal.
    column, row = (
        np.floor(start[axis] + (right - start)[axis] * across + (below - start)[axis] * down)
        for axis in (0, 1)
    )
    within = (column >= 0) & (column < target[1]) & (row >= 0) & (row < target[0])
    return column.astype(np.intp), row.astype(np.intp), within
