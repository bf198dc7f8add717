"""The outline of a robot's body on the ground, as a polygon or a circle; pure."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.gcm.body import RobotBody

Floats = npt.NDArray[np.float64]

_PARALLEL = 1e-12
_STRAIGHT = 1e-6
"""Corners that turn by less than this [m^2] are left out."""


def corners(body: RobotBody) -> Floats:
    """The corners of the footprint [m], counter-clockwise, shape (n, 2); none: a circle."""
    return np.array([(point.x, point.y) for point in body.footprint]).reshape(-1, 2)


def hull(points: Floats) -> Floats:
    """The corners of the convex hull, counter-clockwise, shape (k, 2); Andrew's monotone chain."""
    order = sorted(map(tuple, points.tolist()))
    chain: list[tuple[float, ...]] = []
    for side in (order, order[::-1]):
        base = len(chain)
        for point in side:
            while len(chain) - base >= 2 and _turn(chain[-2], chain[-1], point) <= _STRAIGHT:
                chain.pop()
            chain.append(point)
        chain.pop()
    return np.array(chain).reshape(-1, 2)


def _turn(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> float:
    """Twice the area of a triangle [m^2], positive counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def exits(body: RobotBody, x: Floats, y: Floats, bearing: Floats) -> Floats:
    """Where lines leave the outline.

    Args:
        body: The body.
        x: Where each line begins, in `base_link` [m], shape (n,).
        y: The same.
        bearing: Direction of each line [rad], shape (n,).

    Returns:
        Length of each line to where it leaves the outline [m], shape (n,); 0: it misses it.
    """
    ahead, left = np.cos(bearing), np.sin(bearing)
    start = corners(body)
    if not len(start):
        along, beside = x * ahead + y * left, y * ahead - x * left
        half = np.sqrt(np.maximum(body.radius**2 - beside * beside, 0.0))
        return np.where(np.abs(beside) <= body.radius, np.maximum(half - along, 0.0), 0.0)
    edge_x, edge_y = (np.roll(start, -1, axis=0) - start).T
    to_x, to_y = start[:, 0] - x[:, None], start[:, 1] - y[:, None]
    slant = ahead[:, None] * edge_y - left[:, None] * edge_x
    slant = np.where(np.abs(slant) < _PARALLEL, np.nan, slant)
    way = (to_x * edge_y - to_y * edge_x) / slant
    share = (to_x * left[:, None] - to_y * ahead[:, None]) / slant
    met = (way >= 0.0) & (share >= 0.0) & (share <= 1.0)
    ways: Floats = np.where(met, way, 0.0).max(axis=1)
    return ways
