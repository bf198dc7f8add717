"""Gaps between a convex outline and boxes and cylinders in the plane; pure.

By the separating axis theorem two convex shapes are apart exactly if an edge's normal of one of
them parts them; for a circle, the direction from the outline's nearest corner counts as well.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.gcm.outline import hull
from hub.pose import Pose
from hub.sim.arena import Footprints

Floats = npt.NDArray[np.float64]

_BOX_NORMALS: Floats = np.array(((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)))
_PATCH = np.linspace(0.0, 1.0, 9)


class ConvexBody:
    """An outline that moves among the footprints of obstacles."""

    def __init__(self, corners: Floats, footprints: Footprints) -> None:
        """Take the convex hull of an outline.

        Args:
            corners: Of the outline in the body [m], shape (n, 2).
            footprints: The obstacles.
        """
        self._corners = hull(corners)
        along = np.roll(self._corners, -1, axis=0) - self._corners
        normals = np.stack((along[:, 1], -along[:, 0]), axis=1)
        self._normals: Floats = normals / np.hypot(normals[:, 0], normals[:, 1])[:, None]
        self._footprints = footprints

    @property
    def radius(self) -> float:
        """Of the circle around the origin that encloses the outline [m]."""
        return float(np.hypot(self._corners[:, 0], self._corners[:, 1]).max())

    def gaps(self, pose: Pose) -> tuple[Floats, Floats]:
        """The gap to each obstacle, and the direction to it.

        A gap is at most the distance, and negative by the depth of an overlap.

        Args:
            pose: Of the body in the arena's frame.

        Returns:
            Gaps [m], boxes first, shape (b + c,); unit vectors, shape (b + c, 2).
        """
        corners, normals = self._placed(pose)
        offsets = (normals * corners).sum(axis=1)
        boxes, box_ways = self._box_gaps(corners, normals, offsets)
        rounds, round_ways = self._cylinder_gaps(corners, normals, offsets)
        return np.concatenate((boxes, rounds)), np.concatenate((box_ways, round_ways))

    def contact_bearings(self, pose: Pose, obstacle: int, within: float) -> Floats:
        """Directions from the origin to where an obstacle touches, from the heading [rad].

        Args:
            pose: Of the body.
            obstacle: Number of the obstacle, boxes first.
            within: Largest distance of a contact [m].
        """
        corners, normals = self._placed(pose)
        there = self._footprints
        boxes = len(there.low)
        if obstacle < boxes:
            low, high = there.low[obstacle], there.high[obstacle]
            (x, y), (u, v) = low, high
            ends = np.array(((x, y), (u, y), (u, v), (x, v)))
            apart = np.maximum(np.maximum(low - corners, corners - high), 0.0)
            touching = np.hypot(apart[:, 0], apart[:, 1]) <= within
            beyond = ends @ normals.T - (normals * corners).sum(axis=1)
            points = np.concatenate((corners[touching], ends[(beyond <= within).all(axis=1)]))
        else:
            centre, radius = there.centre[obstacle - boxes], there.radius[obstacle - boxes]
            edge = np.roll(corners, -1, axis=0) - corners
            share = ((centre - corners) * edge).sum(axis=1) / (edge * edge).sum(axis=1)
            nearest = corners + np.clip(share, 0.0, 1.0)[:, None] * edge
            away = np.hypot(*(centre - nearest).T) - radius
            points = nearest[away <= within]
        if not len(points):
            return np.empty(0)
        # Two faces touch along the line between the outermost contacts.
        first, last = points[[np.lexsort(points.T)[0], np.lexsort(points.T)[-1]]]
        patch = first + _PATCH[:, None] * (last - first)
        x, y = pose.inward(patch[:, 0], patch[:, 1])
        bearings: Floats = np.arctan2(y, x)
        return bearings

    def _placed(self, pose: Pose) -> tuple[Floats, Floats]:
        """Corners and normals in the arena's frame, shape (k, 2) each."""
        turn = Pose(theta=pose.theta)
        corners = pose.outward(self._corners[:, 0], self._corners[:, 1])
        normals = turn.outward(self._normals[:, 0], self._normals[:, 1])
        return np.stack(corners, axis=1), np.stack(normals, axis=1)

    def _box_gaps(self, corners: Floats, normals: Floats, offsets: Floats) -> tuple[Floats, Floats]:
        low, high = self._footprints.low, self._footprints.high
        if not len(low):
            return np.empty(0), np.empty((0, 2))
        nearest = np.minimum(normals[:, :, None] * low.T, normals[:, :, None] * high.T).sum(axis=1)
        lows, highs = corners.min(axis=0), corners.max(axis=0)
        sides = (
            low[:, 0] - highs[0],
            lows[0] - high[:, 0],
            low[:, 1] - highs[1],
            lows[1] - high[:, 1],
        )
        gaps = np.concatenate((nearest - offsets[:, None], np.stack(sides)))
        return _widest(gaps, np.concatenate((normals, _BOX_NORMALS)))

    def _cylinder_gaps(
        self, corners: Floats, normals: Floats, offsets: Floats
    ) -> tuple[Floats, Floats]:
        centre, radius = self._footprints.centre, self._footprints.radius
        if not len(centre):
            return np.empty(0), np.empty((0, 2))
        gaps, ways = _widest(normals @ centre.T - offsets[:, None], normals)
        to = centre[None] - corners[:, None]
        away = np.hypot(to[:, :, 0], to[:, :, 1])
        corner = away.argmin(axis=0)
        each = np.arange(len(centre))
        direction = to[corner, each] / np.maximum(away[corner, each], 1e-12)[:, None]
        # Seen from outside of a corner, the corner is nearest.
        beyond = (corners @ direction.T).max(axis=0)
        by_corner = (direction * centre).sum(axis=1) - beyond
        is_wider = by_corner > gaps
        ways[is_wider] = direction[is_wider]
        return np.maximum(gaps, by_corner) - radius, ways


def _widest(gaps: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """Of the gaps along each normal, shape (k, n), the widest ones and their normals."""
    best = gaps.argmax(axis=0)
    return gaps[best, np.arange(gaps.shape[1])], normals[best]
