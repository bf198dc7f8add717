"""Whether corners are the footprint of a robot; pure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

FARTHEST_CORNER = 5.0
"""Largest distance of a corner from the origin along one axis [m]."""
_LEAST_AREA = 1e-4
"""Smallest surface of a footprint [m^2]."""
_ROUNDING = 1e-6

Corner = tuple[float, float]


def area(corners: Sequence[Corner]) -> float:
    """Surface of a polygon [m^2]; negative if its corners [m] are in clockwise order."""
    return sum(x * v - u * y for (x, y), (u, v) in _edges(corners)) / 2.0


def footprint_fault(corners: Sequence[Corner]) -> str:
    """What is wrong with a footprint, to follow its name; empty: nothing.

    Args:
        corners: In `base_link` [m], one after the other around it.
    """
    if len(corners) < 3 or abs(area(corners)) < _LEAST_AREA:
        return "is not a list of the corners [x, y] of a surface"
    farthest = max(max(map(abs, corner)) for corner in corners)
    if farthest > FARTHEST_CORNER:
        return f"reaches {farthest:.4g} m from [0, 0]; at most {FARTHEST_CORNER:g} m are allowed"
    for (a, b), (c, d) in itertools.combinations(_edges(corners), 2):
        if _turn(a, b, c) * _turn(a, b, d) < 0.0 and _turn(c, d, a) * _turn(c, d, b) < 0.0:
            return (
                f"crosses itself between {_shown(a)} and {_shown(b)}; list the corners one after"
                " the other around it"
            )
    if not _encloses_origin(corners):
        return "does not enclose [0, 0], the point where the robot turns; count from there"
    return ""


def _edges(corners: Sequence[Corner]) -> list[tuple[Corner, Corner]]:
    return [*zip(corners, (*corners[1:], *corners[:1]), strict=True)]


def _encloses_origin(corners: Sequence[Corner]) -> bool:
    """Whether the origin is inside of the convex hull: no half plane is without a corner."""
    angles = sorted(math.atan2(y, x) for x, y in corners)
    gaps = [after - before for before, after in itertools.pairwise(angles)]
    return max(*gaps, angles[0] + math.tau - angles[-1]) < math.pi - _ROUNDING


def _turn(a: Corner, b: Corner, c: Corner) -> float:
    """Twice the area of a triangle [m^2], positive counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _shown(corner: Corner) -> str:
    return f"[{corner[0]:g}, {corner[1]:g}]"
