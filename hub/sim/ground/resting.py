"""The plane on which a body rests: the lowest centre of mass with no contact point below ground.

The problem is a linear one. The centre of mass is at (cx, cy), and the ground holds each contact
point (x, y) at a height h. Minimise z + a cx + b cy with z + a x + b y >= h for all contact points.
The dual variables are the loads: shares of the weight on three contact points. The dual simplex
method changes one of the three points at a time, so a pose that is nearly the last one needs few
changes.
"""

from __future__ import annotations

import math

import numpy as np

from hub.sim.ground.elements import Floats
from hub.values import dataclass

Triangle = tuple[int, int, int]

_TOUCH = 1e-9
"""A point this much below ground [m] counts as on it."""
_NO_AREA = 1e-9
_MOST_CHANGES = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class RestingPlane:
    """The plane z + east x + north y.

    Attributes:
        height: z, under the origin [m].
        east: Slope along x [m/m].
        north: Slope along y [m/m].
        triangle: The contact points that carry.
        loads: The share of the weight on each of them.
    """

    height: float
    east: float
    north: float
    triangle: Triangle
    loads: tuple[float, float, float]

    def above(self, x: float, y: float) -> float:
        """Height of the plane at a point [m]."""
        return self.height + self.east * x + self.north * y


def resting_plane(
    x: Floats, y: Floats, heights: Floats, centre: tuple[float, float], guess: Triangle | None
) -> RestingPlane | None:
    """The plane on which a body rests; None: its contact points do not hold its centre of mass.

    Args:
        x: Contact points [m], shape (n,).
        y: The same [m].
        heights: Least height of the plane there [m], shape (n,).
        centre: The centre of mass in x and y [m].
        guess: Points that may carry, for example those that carried before.
    """
    points = list(zip(x.tolist(), y.tolist(), heights.tolist(), strict=True))
    loads = None if guess is None else _shares(points, guess, *centre)
    if guess is None or loads is None or min(loads) < 0.0:
        guess = _triangle_around(x - centre[0], y - centre[1])
        if guess is None:
            return None
        loads = _shares(points, guess, *centre)
        if loads is None:
            return None
    triangle = guess
    for _ in range(_MOST_CHANGES):
        east, north = _slopes(points, triangle)
        first = points[triangle[0]]
        height = first[2] - east * first[0] - north * first[1]
        missing = heights - east * x - north * y
        lowest = int(missing.argmax())
        if float(missing[lowest]) - height <= _TOUCH or lowest in triangle:
            break
        shares = _shares(points, triangle, points[lowest][0], points[lowest][1])
        if shares is None:
            break
        ratio, leaving = min(
            (load / share, number)
            for number, (load, share) in enumerate(zip(loads, shares, strict=True))
            if share > _NO_AREA
        )
        changed = [load - ratio * share for load, share in zip(loads, shares, strict=True)]
        changed[leaving] = ratio
        loads = (max(changed[0], 0.0), max(changed[1], 0.0), max(changed[2], 0.0))
        corners = list(triangle)
        corners[leaving] = lowest
        triangle = (corners[0], corners[1], corners[2])
    return RestingPlane(height=height, east=east, north=north, triangle=triangle, loads=loads)


def _slopes(points: list[tuple[float, float, float]], triangle: Triangle) -> tuple[float, float]:
    (x, y, z), (x1, y1, z1), (x2, y2, z2) = (points[corner] for corner in triangle)
    x1, y1, z1, x2, y2, z2 = x1 - x, y1 - y, z1 - z, x2 - x, y2 - y, z2 - z
    area = x1 * y2 - x2 * y1
    return (z1 * y2 - z2 * y1) / area, (x1 * z2 - x2 * z1) / area


def _shares(
    points: list[tuple[float, float, float]], triangle: Triangle, x: float, y: float
) -> tuple[float, float, float] | None:
    """The weights of the corners that make a point; None for a triangle without area."""
    (x0, y0, _), (x1, y1, _), (x2, y2, _) = (points[corner] for corner in triangle)
    x1, y1, x2, y2, x, y = x1 - x0, y1 - y0, x2 - x0, y2 - y0, x - x0, y - y0
    area = x1 * y2 - x2 * y1
    if abs(area) < _NO_AREA:
        return None
    second, third = (x * y2 - x2 * y) / area, (x1 * y - x * y1) / area
    return 1.0 - second - third, second, third


def _triangle_around(x: Floats, y: Floats) -> Triangle | None:
    """Three points around the origin; None: it is outside of all."""
    first = int((x * x + y * y).argmax())
    turned = (np.arctan2(y, x) - math.atan2(y[first], x[first])) % math.tau
    left = np.where(turned < math.pi, turned, -1.0)
    right = np.where(turned >= math.pi, turned, math.inf)
    second, third = int(left.argmax()), int(right.argmin())
    if math.isinf(right[third]) or right[third] - left[second] > math.pi or second == first:
        return None
    return first, second, third
