"""Where beams of range sensors meet the ground, also from a body that leans."""

from __future__ import annotations

import math

import numpy as np

from hub.sim.ground.elements import Floats
from hub.sim.ground.height_field import HeightField

SQUARE_ENOUGH = math.radians(25.0)
"""A smooth surface that sound meets at a larger angle than this sends no echo back [rad]."""
_STEP = 0.8
"""Distance between samples of a beam, in cells of the height map."""
_TINY = 1e-9


def ground_echoes(
    field: HeightField,
    origins: Floats,
    directions: Floats,
    farthest: float,
    incidence: float = SQUARE_ENOUGH,
) -> Floats:
    """Ranges to the ground that come back [m], inf for none, shape (n,); see `ground_hits`."""
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
    ways = np.arange(1, math.ceil(farthest / (_STEP * field.cell)) + 1) * (_STEP * field.cell)
    x, y, z = (origins[:, axis, None] + directions[:, axis, None] * ways for axis in range(3))
    # A deck is ground for beams from above it; its lower side is a box's.
    above = origins[:, 2, None]
    below = z <= field.heights_at(x, y, above)
    first = below.argmax(axis=1)
    beams = np.arange(len(origins))
    hit = below[beams, first]
    far = ways[first]
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


def _tiles(
    field: HeightField, cells: np.ndarray[tuple[int], np.dtype[np.intp]], above: Floats
) -> tuple[Floats, Floats]:
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
