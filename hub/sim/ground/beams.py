"""Where beams of range sensors meet the ground, also from a body that leans."""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt

from hub.sim.ground.elements import Floats
from hub.sim.ground.height_field import HeightField

_STEP = 0.8
"""Distance between samples of a beam, in cells of the height map."""
_SAMPLES = 5
"""Samples of a stretch of a beam, which is shorter than a block."""
_STRETCHES = 4
"""Stretches that are sampled together."""
_BLOCK = 8
"""Side of a block [cells]."""
_TINY = 1e-9


def ground_echoes(
    field: HeightField,
    origins: Floats,
    directions: Floats,
    farthest: float,
    incidence: float,
) -> Floats:
    """Ranges to the ground that come back [m], inf for none, shape (n,); see `ground_hits`.

    At a larger angle to the normal than `incidence` [rad] a surface sends no echo back.
    """
    distance, squareness = ground_hits(field, origins, directions, farthest)
    return np.where(squareness >= math.cos(incidence), distance, np.inf)


def ground_hits(
    field: HeightField, origins: Floats, directions: Floats, farthest: float
) -> tuple[Floats, Floats]:
    """The first hits of beams on the ground: on its slopes, and on the sides of its steps.

    Args:
        field: The ground.
        origins: Where the beams begin [m], shape (n, 3).
        directions: Unit vectors, shape (n, 3).
        farthest: Largest distance [m].

    Returns:
        Distance to the hit [m], inf for none; cosine of the angle between the beam and the normal
        of the surface there, 0 for none; each of shape (n,).
    """
    far = _first_below(field, origins, directions, farthest)
    hit = np.isfinite(far)
    far = np.where(hit, far, 0.0)
    near = far - _STEP * field.cell
    point = origins + directions * far[:, None]
    cells = field.cells(point[:, 0], point[:, 1])
    top, normal = _tiles(field, cells, origins[:, 2])
    # Where the beam meets the plane of the tile; outside of the last step it meets the tile's side.
    gap = (top - origins) * normal
    speed = (directions * normal).sum(axis=1)
    plane = gap.sum(axis=1) / np.where(np.abs(speed) < _TINY, _TINY, speed)
    on_top = (speed < 0.0) & (plane >= near - _TINY) & (plane <= far + _TINY)
    before = origins + directions * np.maximum(near, 0.0)[:, None]
    side, side_square = _sides(field, before, point, directions, near, far)
    distance = np.where(on_top, plane, side)
    squareness = np.where(on_top, -speed, side_square)
    hit &= distance <= farthest
    return np.where(hit, distance, np.inf), np.where(hit, squareness, 0.0)


def _first_below(
    field: HeightField, origins: Floats, directions: Floats, farthest: float
) -> Floats:
    """Distance of the first sample of each beam that is below ground [m], inf for none.

    Only stretches of a beam are sampled that are lower than the highest ground around them.
    """
    fine = _STEP * field.cell
    stretch = _SAMPLES * fine
    starts = np.arange(math.ceil(farthest / stretch)) * stretch
    x, y, z = (origins[:, axis, None] + directions[:, axis, None] * starts for axis in range(3))
    lowest = z + np.minimum(directions[:, 2, None], 0.0) * stretch
    maybe = lowest <= _highest_around(field)[_blocks_at(field, x, y)]
    numbers = np.arange(len(starts))
    samples = np.arange(1, _SAMPLES * _STRETCHES + 1) * fine
    found = np.full(len(origins), np.inf)
    beams = np.flatnonzero(maybe.any(axis=1))
    first = maybe[beams].argmax(axis=1)
    while len(beams):
        ways = starts[first][:, None] + samples
        x, y, z = (
            origins[beams, axis, None] + directions[beams, axis, None] * ways for axis in range(3)
        )
        # A deck is ground for beams from above it; its lower side is a box's.
        below = z <= field.heights_at(x, y, origins[beams, 2, None])
        hits = below.any(axis=1)
        found[beams[hits]] = ways[hits, below[hits].argmax(axis=1)]
        beams, first = beams[~hits], first[~hits]
        later = maybe[beams] & (numbers >= (first + _STRETCHES)[:, None])
        beams, first = beams[later.any(axis=1)], later.argmax(axis=1)[later.any(axis=1)]
    return found


@functools.lru_cache(maxsize=4)
def _highest_around(field: HeightField) -> npt.NDArray[np.float32]:
    """The highest ground in each block of the map and in the blocks around it [m]."""
    tops = field.heights + (np.abs(field.east) + np.abs(field.north)) * field.cell / 2
    if field.decks is not None:
        tops = np.maximum(tops, np.where(np.isfinite(field.decks), field.decks, 0.0))
    rows, columns = (-count % _BLOCK for count in tops.shape)
    tops = np.pad(tops, ((0, rows), (0, columns)), mode="edge")
    whole = tops.reshape(tops.shape[0] // _BLOCK, _BLOCK, -1, _BLOCK).max(axis=(1, 3))
    wide = np.pad(whole, 1, mode="edge")
    around = [
        wide[row : row + whole.shape[0], column : column + whole.shape[1]]
        for row in range(3)
        for column in range(3)
    ]
    highest: npt.NDArray[np.float32] = np.max(around, axis=0)
    return highest


def _blocks_at(
    field: HeightField, x: Floats, y: Floats
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Row and column of the blocks at points, the nearest for points beyond the map."""
    rows, columns = _highest_around(field).shape
    side = _BLOCK * field.cell
    row = np.floor((y - field.origin[1]) / side).clip(0, rows - 1).astype(np.intp)
    column = np.floor((x - field.origin[0]) / side).clip(0, columns - 1).astype(np.intp)
    return row, column


def _tiles(field: HeightField, cells: npt.NDArray[np.intp], above: Floats) -> tuple[Floats, Floats]:
    """A point on each tile [m] and its normal, each of shape (n, 3)."""
    columns = field.heights.shape[1]
    east, north = (part.take(cells).astype(np.float64) for part in (field.east, field.north))
    height = field.heights.take(cells).astype(np.float64)
    if field.decks is not None:
        decks = field.decks.take(cells)
        upper = decks < above
        height = np.where(upper, decks, height)
        east, north = np.where(upper, 0.0, east), np.where(upper, 0.0, north)
    upright = 1.0 / np.sqrt(1.0 + east * east + north * north)
    normal = np.stack((-east * upright, -north * upright, upright), axis=1)
    middle = np.stack(
        (
            field.origin[0] + (cells % columns + 0.5) * field.cell,
            field.origin[1] + (cells // columns + 0.5) * field.cell,
            height,
        ),
        axis=1,
    )
    return middle, normal


def _sides(
    field: HeightField, before: Floats, after: Floats, directions: Floats, near: Floats, far: Floats
) -> tuple[Floats, Floats]:
    """Distance to the upright side between two samples [m], and the cosine of the incidence."""
    distance, squareness = near.copy(), np.zeros(len(near))
    for axis in (0, 1):
        cell = np.floor((after[:, axis] - field.origin[axis]) / field.cell)
        earlier = np.floor((before[:, axis] - field.origin[axis]) / field.cell)
        crosses = cell != earlier
        edge = field.origin[axis] + np.maximum(cell, earlier) * field.cell
        part = directions[:, axis]
        way = near + (edge - before[:, axis]) / np.where(crosses, part, 1.0)
        facing = np.abs(part)
        # A beam that crosses a corner's both sides meets the one that it faces.
        better = crosses & (facing > squareness)
        distance = np.where(better, np.clip(way, near, far), distance)
        squareness = np.where(better, facing, squareness)
    return distance, squareness
