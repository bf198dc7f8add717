"""Free length of circular arcs for a round body among points; pure geometry.

At a constant velocity the body drives a circular arc. The contact of its rim with a point is
exact, not sampled: it follows from the triangle of the arc's centre, the body's centre and the
point.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_LEAST_CURVATURE = 1e-5
"""Least curvature of an arc [1/m]: 5 micrometres aside after a metre."""
LONGEST = 3.0
"""Arcs of more than half a circle and longer than this [m] count as free."""
_LEAST_SPEED = 1e-9


def free_ways(
    linear: Floats,
    angular: Floats,
    x: Floats,
    y: Floats,
    radius: Floats,
    half_width: Floats,
) -> Floats:
    """The free length of the arc of each velocity.

    The body is a disc cut off at its sides: points farther than `half_width` from the arc do not
    count. So the margin is ahead of the body and not beside it, and a robot can drive along a
    wall.

    For points inside the disc the length is 0 if the velocity leads towards them, and they do not
    count if it leads away.

    Args:
        linear: Forward velocity of each arc [m/s], shape (m,); negative backwards, 0 on the spot.
        angular: Turn rate of each arc [rad/s], shape (m,).
        x: Points ahead of the body's centre [m], shape (n,).
        y: Points to its left [m], shape (n,).
        radius: Of the disc, for each arc [m], shape (m,).
        half_width: To both sides of each arc [m], shape (m,), at most `radius`.

    Returns:
        Length of each arc that is free [m], shape (m,); inf: all of it, or more than LONGEST.
    """
    ways = np.full(len(linear), np.inf)
    moving = np.flatnonzero(np.abs(linear) > _LEAST_SPEED)
    if not len(moving) or not len(x):
        return ways
    # Mirror the points for backward velocities, and for turns to the right.
    ahead = np.sign(linear[moving])
    curvature = angular[moving] / linear[moving]
    left = np.where(curvature < 0.0, -1.0, 1.0)
    turn_radius = 1.0 / np.maximum(np.abs(curvature), _LEAST_CURVATURE)
    width = half_width[moving]
    arcs, points = _touching(ahead, left, turn_radius, width, x, y)
    if not len(arcs):
        return ways
    along = ahead[arcs] * x[points]
    beside = turn_radius[arcs] - left[arcs] * y[points]
    centre = np.sqrt(along * along + beside * beside)
    met = _way_to_contact(
        along,
        beside,
        centre,
        centre - turn_radius[arcs],
        turn_radius[arcs],
        radius[moving][arcs],
        np.hypot(x, y)[points],
    )
    first = np.flatnonzero(np.diff(arcs, prepend=-1))
    ways[moving[arcs[first]]] = np.minimum.reduceat(met, first)
    return ways


def _touching(
    ahead: Floats, left: Floats, turn_radius: Floats, width: Floats, x: Floats, y: Floats
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Pairs of arcs and points nearer than their width; numbers of arcs, ascending, and points.

    A point at distance c from an arc's centre is near if |c - r| < w. In squares that is
    |s / 2r - y - w^2 / 2r| < w with s = x^2 + y^2: a product of two thin matrices, no root.
    """
    half = 0.5 / turn_radius
    aside = np.stack((half, -left), axis=1) @ np.stack((x * x + y * y, y))
    aside -= (width * width * half)[:, None]
    near = aside < width[:, None]
    # The centre of a narrow arc lies under the body, so points near it are met too.
    near &= aside > np.where(turn_radius < width, -np.inf, -width)[:, None]
    # Points behind the body are met after more than half a circle.
    round_about = (turn_radius * np.pi < LONGEST)[:, None]
    front, back = x > 0.0, x < 0.0
    near &= round_about | np.where((ahead > 0.0)[:, None], front, back)
    arcs, points = np.divmod(np.flatnonzero(near), len(x))
    return arcs, points


def _way_to_contact(
    along: Floats,
    beside: Floats,
    centre: Floats,
    offset: Floats,
    turn_radius: Floats,
    radius: Floats,
    distance: Floats,
) -> Floats:
    """Arc length to where the body's centre is at `radius` from a point [m], each shape (k,).

    In the triangle of arc centre, body centre and point the two long sides are `turn_radius` and
    `centre`; the half-angle formula gives the angle between them where the third is `radius`.
    """
    half_sine = np.sqrt(
        np.maximum(radius * radius - offset * offset, 0.0)
        / (4.0 * turn_radius * np.maximum(centre, _LEAST_SPEED))
    )
    before = 2.0 * np.arcsin(np.minimum(half_sine, 1.0))
    abreast = np.arctan2(along, beside)
    abreast += np.where(abreast < 0.0, 2.0 * np.pi, 0.0)
    way = np.maximum(abreast - before, 0.0) * turn_radius
    inside = np.where(along > 0.0, 0.0, np.inf)
    return np.where(distance < radius, inside, way)
