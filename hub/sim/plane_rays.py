"""Rays in the plane among obstacles, seen from above."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.sim.arena import Footprints

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

NO_COMPONENT = 1e-12
"""A smaller component of a ray counts as this."""


def first_hits(
    obstacles: Footprints, origins: Floats, directions: Floats
) -> tuple[Floats, Floats, Indices]:
    """The first hits of rays.

    Args:
        obstacles: The obstacles.
        origins: Where the rays begin, outside of all obstacles [m], shape (n, 2).
        directions: Unit vectors, shape (n, 2).

    Returns:
        Distance to the first hit [m], inf for none; cosine of the angle between the ray and the
        surface's normal there; number of the obstacle, -1 for none; each of shape (n,).
    """
    count = len(directions)
    distance = np.full((count,), np.inf)
    squareness = np.zeros(count)
    number = np.full((count,), -1, dtype=np.intp)
    if len(obstacles.low):
        distance, squareness, number = _box_hits(obstacles, origins, directions)
        number = np.where(np.isfinite(distance), number, -1)
    if len(obstacles.radius):
        away, square, nearest = _cylinder_hits(obstacles, origins, directions)
        nearer = away < distance
        distance = np.where(nearer, away, distance)
        squareness = np.where(nearer, square, squareness)
        number = np.where(nearer, nearest + len(obstacles.low), number)
    return distance, squareness, number


def slab(
    low: Floats, high: Floats, origins: Floats, directions: Floats, axis: int
) -> tuple[Floats, Floats]:
    """Where rays enter and leave the space between two planes, each of shape (solids, rays)."""
    component = directions[:, axis]
    inverse = 1.0 / np.where(np.abs(component) < NO_COMPONENT, NO_COMPONENT, component)
    first, second = (low - origins[:, axis]) * inverse, (high - origins[:, axis]) * inverse
    return np.minimum(first, second), np.maximum(first, second)


def _box_hits(
    obstacles: Footprints, origins: Floats, directions: Floats
) -> tuple[Floats, Floats, Indices]:
    """Distance (inf: none), cosine of the incidence and number of the nearest box, shape (rays,).

    Slab method (Kay and Kajiya 1986).
    """
    x_in, x_out = slab(obstacles.low[:, :1], obstacles.high[:, :1], origins, directions, 0)
    y_in, y_out = slab(obstacles.low[:, 1:], obstacles.high[:, 1:], origins, directions, 1)
    enter = np.maximum(x_in, y_in)
    met = (enter <= np.minimum(x_out, y_out)) & (enter >= 0.0)
    enter = np.where(met, enter, np.inf)
    nearest = enter.argmin(axis=0), np.arange(len(directions))
    facing_x = x_in[nearest] > y_in[nearest]
    cosine = np.where(facing_x, np.abs(directions[:, 0]), np.abs(directions[:, 1]))
    return enter[nearest], cosine, nearest[0]


def _cylinder_hits(
    obstacles: Footprints, origins: Floats, directions: Floats
) -> tuple[Floats, Floats, Indices]:
    """The same for the nearest cylinder."""
    to_x = obstacles.centre[:, :1] - origins[:, 0]
    to_y = obstacles.centre[:, 1:] - origins[:, 1]
    along = to_x * directions[:, 0] + to_y * directions[:, 1]
    passing = to_x * directions[:, 1] - to_y * directions[:, 0]
    radius = obstacles.radius[:, None]
    under = radius * radius - passing * passing
    depth = np.sqrt(np.maximum(under, 0.0))
    hit = along - depth
    hit = np.where((under >= 0.0) & (hit >= 0.0), hit, np.inf)
    nearest = hit.argmin(axis=0), np.arange(len(directions))
    return hit[nearest], depth[nearest] / obstacles.radius[nearest[0]], nearest[0]
