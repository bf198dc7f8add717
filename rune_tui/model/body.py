"""The robot's outline on the ground."""

from __future__ import annotations

import functools
import math

import numpy as np

from hub.gcm.body import RobotBody
from rune_tui.model.sightings import Floats


def rim(body: RobotBody | None, count: int) -> Floats:
    """Distances of the robot's rim from its origin [m], shape (count,).

    The directions begin straight ahead, counter-clockwise. For an unknown body all distances are 0.
    """
    return _rim(body, count)


def largest_radius(body: RobotBody | None) -> float:
    """Radius of the circle around the whole robot, at least to its corners [m]; 0: not known."""
    if body is None:
        return 0.0
    return max(body.radius, *(math.hypot(each.x, each.y) for each in body.footprint), 0.0)


def corners(body: RobotBody | None) -> Floats:
    """Corners of the robot's footprint in its frame [m], shape (n, 2).

    n is 0 if the footprint is a circle, is not known, or has two corners only.
    """
    points = body.footprint if body is not None and len(body.footprint) > 2 else ()
    return np.array([(point.x, point.y) for point in points], np.float64).reshape(-1, 2)


@functools.lru_cache(maxsize=64)
def _rim(body: RobotBody | None, count: int) -> Floats:
    around = corners(body)
    if not len(around):
        distances = np.full(count, largest_radius(body))
    else:
        distances = _ray_lengths(around, count)
    distances.flags.writeable = False
    return distances


def _ray_lengths(around: Floats, count: int) -> Floats:
    """Distance from the origin to the farthest edge in each direction [m].

    A ray `s d` meets the edge `p + t e` at `s=(p x e)/(d x e)` and `t=(p x d)/(d x e)`.
    """
    angles = np.arange(count) * (math.tau / count)
    ray_x, ray_y = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x, y = around.T
    edge_x, edge_y = np.roll(x, -1) - x, np.roll(y, -1) - y
    across = ray_x * edge_y - ray_y * edge_x
    with np.errstate(divide="ignore", invalid="ignore"):
        length = (x * edge_y - y * edge_x) / across
        along = (x * ray_y - y * ray_x) / across
    # A corner belongs to both edges: a rounding error must not let a ray pass between them.
    meets = (along >= -1e-9) & (along <= 1.0 + 1e-9) & (length > 0.0)
    distances: Floats = np.where(meets, length, 0.0).max(axis=1)
    return distances
