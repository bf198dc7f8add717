"""Free time of circular arcs for a body with a convex outline among points; pure geometry.

At a constant velocity each point moves on a circle around the arc's centre, seen from the body. It
enters the outline where this circle crosses an edge inwards; that is exact, not sampled. Each edge
has at most one such crossing: the circle meets its line twice, once inwards and once outwards.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

MOST_EDGES = 12
"""An outline with more edges is replaced by one around it with this number."""
_LEAST_CURVATURE = 1e-4
"""Least curvature of an arc [1/m]: 50 micrometres aside after a metre."""
_TOUCH = 1e-6
"""Tolerance of contacts [m]."""


class Sweep:
    """A convex outline that moves along its x axis and turns.

    Attributes:
        radius: Of the circle around the origin that encloses the outline [m].
    """

    def __init__(self, corners: Floats) -> None:
        """Compute the edges.

        Args:
            corners: Of the outline [m], convex, counter-clockwise, shape (k, 2).
        """
        self.radius = float(np.hypot(*corners.T).max())
        if len(corners) <= MOST_EDGES:
            along = np.roll(corners, -1, axis=0) - corners
            bearing = np.arctan2(-along[:, 0], along[:, 1])
        else:
            bearing = np.arange(MOST_EDGES) * (math.tau / MOST_EDGES)
        normals = np.stack((np.cos(bearing), np.sin(bearing)), axis=1)
        self._bearing, self._normals = bearing, normals
        self._offsets: Floats = (normals @ corners.T).max(axis=1)
        after = np.roll(bearing, -1) - bearing
        self._cosine, self._sine = np.cos(after), np.sin(after)

    def along(self, axis: float) -> Sweep:
        """The same outline, seen from a frame with x in a direction [rad]."""
        if axis == 0.0:
            return self
        turned = object.__new__(Sweep)
        turned.__dict__.update(self.__dict__)
        turned._bearing = self._bearing - axis
        turned._normals = np.stack((np.cos(turned._bearing), np.sin(turned._bearing)), axis=1)
        return turned

    def distances(self, x: Floats, y: Floats) -> Floats:
        """Distances of points from the outline [m], shape (n,), or less; negative inside."""
        distances: Floats = self._beyond(x, y).max(axis=0, initial=-np.inf)
        return distances

    def free_times(
        self, linear: Floats, angular: Floats, x: Floats, y: Floats, ahead: Floats, around: Floats
    ) -> Floats:
        """The time until the outline meets a point, at each velocity.

        Points within the margins do not count while they go away from the outline.

        Args:
            linear: Velocity along x of each arc [m/s], shape (m,); 0 or positive.
            angular: Turn rate of each arc [rad/s], shape (m,).
            x: Points [m], shape (n,).
            y: The same.
            ahead: Margin in the direction of the motion [m], shape (m,); at least `around`.
            around: Margin on all other sides [m], shape (m,).

        Returns:
            The times [s], shape (m,); inf: it meets none.
        """
        times = np.full(len(linear), np.inf)
        moving = np.flatnonzero((linear != 0.0) | (angular != 0.0))
        if not len(moving) or not len(x):
            return times
        speed, rate = linear[moving], angular[moving]
        least = np.maximum(_LEAST_CURVATURE * speed, 1e-9)
        rate = np.where(np.abs(rate) < least, np.copysign(least, rate), rate)
        # Support of the outline, a disc, and a step ahead: their sum is convex too.
        forward = np.maximum(self._normals[:, 0], 0.0)
        margin = around[moving, None] + (ahead - around)[moving, None] * forward
        turns = speed / rate, np.sign(rate)
        angles = self._angles(*turns, x, y, self._offsets + margin)
        beyond = self._beyond(x, y)
        near = (beyond < margin.max(axis=0)[:, None] + _TOUCH).all(axis=0)
        if near.any():
            beyond, x, y = beyond[:, near], x[near], y[near]
            # A point that goes away now may meet another part later.
            np.minimum(
                angles,
                self._angles(*turns, x, y, np.broadcast_to(self._offsets, margin.shape)),
                out=angles,
            )
            angles[self._approach(speed, rate, x, y, beyond, margin)] = 0.0
        found = angles / np.abs(rate)
        times[moving] = found
        return times

    def _beyond(self, x: Floats, y: Floats) -> Floats:
        """How far points are beyond each edge's line [m], shape (edges, n)."""
        return self._normals @ np.stack((x, y)) - self._offsets[:, None]

    def _approach(
        self, speed: Floats, rate: Floats, x: Floats, y: Floats, beyond: Floats, margin: Floats
    ) -> npt.NDArray[np.bool_]:
        """Whether a point within the margins comes nearer to the edge before it; shape (m,)."""
        normal = self._normals[beyond.argmax(axis=0)]
        nearer = (rate[:, None] * y - speed[:, None]) * normal[:, 0]
        nearer -= rate[:, None] * x * normal[:, 1]
        inside = (beyond < margin[:, :, None] + _TOUCH).all(axis=1)
        return np.asarray((inside & (nearer < 0.0)).any(axis=1))

    def _angles(
        self, centre: Floats, left: Floats, x: Floats, y: Floats, offsets: Floats
    ) -> Floats:
        """The angle by which each arc turns until it meets a point [rad], shape (m,).

        Args:
            centre: Of each arc, on the y axis [m], shape (m,).
            left: 1 for a turn to the left, -1 to the right, shape (m,).
            x: The points.
            y: The same.
            offsets: Of each arc's edges from the origin [m], shape (m, edges).
        """
        after = np.roll(offsets, -1, axis=1)
        ends = (after - offsets * self._cosine) / self._sine
        starts = np.roll((after * self._cosine - offsets) / self._sine, 1, axis=1)
        heights = offsets - self._normals[:, 1] * centre[:, None]
        squares = centre[:, None] * (centre[:, None] - 2.0 * y)
        squares += x * x + y * y
        # The circle meets the edge if half of its chord on the line ends between these.
        middle = self._normals[:, 0] * centre[:, None]
        ends, starts = middle - ends - _TOUCH, middle - starts + _TOUCH
        least = np.where(left[:, None] > 0.0, ends, -starts)
        most = np.where(left[:, None] > 0.0, starts, -ends)
        least = heights * heights + np.square(np.maximum(least, 0.0))
        most = np.where(most < 0.0, -1.0, heights * heights + most * most)
        angles = np.full(len(centre), np.inf)
        for edge, (normal_x, normal_y) in enumerate(self._normals.tolist()):
            met = (squares >= least[:, edge, None]) & (squares <= most[:, edge, None])
            arcs, points = np.divmod(np.flatnonzero(met), len(x))
            height, sign = heights[arcs, edge], left[arcs]
            way = -sign * np.sqrt(np.maximum(squares[arcs, points] - height * height, 0.0))
            contact_x = normal_x * height - normal_y * way
            contact_y = normal_y * height + normal_x * way
            to_x, to_y = x[points], y[points] - centre[arcs]
            cross = contact_x * to_y - contact_y * to_x
            angle = np.arctan2(sign * cross, contact_x * to_x + contact_y * to_y)
            np.minimum.at(angles, arcs, np.where(angle < 0.0, angle + math.tau, angle))
        return angles
