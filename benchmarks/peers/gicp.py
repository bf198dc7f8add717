"""The matching of scans by small_gicp (Koide 2024), which works in three dimensions."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import numpy.typing as npt
import small_gicp

from hub.grids.scan_matching import KEPT, NEW_PLACE, NEW_SHARE
from hub.pose import Pose

Floats = npt.NDArray[np.float64]

_LAYERS = (-0.1, 0.0, 0.1)
"""Heights of each point: on surfaces without a height all normals would be upright."""


class GicpMatcher:
    """Lays scans onto those before, and keeps the same ones as Rune's matcher."""

    def __init__(self) -> None:
        self._odom = Pose()
        self._kept: deque[tuple[Pose, Floats]] = deque(maxlen=KEPT)
        self._known: tuple | None = None

    def pose(self, odom: Pose, x: Floats, y: Floats) -> Pose:
        """The pose at a scan; points that were not measured are NaN."""
        known = np.isfinite(x)
        x, y = x[known], y[known]
        seen, _ = _prepared(np.stack((x, y), axis=1))
        real = self._odom.then(odom)
        on_surfaces = 0
        if self._known is not None:
            found = small_gicp.align(
                self._known[0],
                seen,
                self._known[1],
                init_T_target_source=_matrix(real),
                registration_type="GICP",
                max_correspondence_distance=0.3,
                num_threads=1,
            )
            moved, on_surfaces = found.T_target_source, found.num_inliers
            turn = math.atan2(moved[1, 0], moved[0, 0])
            real = Pose(x=moved[0, 3], y=moved[1, 3], theta=turn)
            self._odom = real.then(Pose().seen_from(odom))
        away = min((math.dist((real.x, real.y), (p.x, p.y)) for p, _ in self._kept), default=9.0)
        if on_surfaces < NEW_SHARE * seen.size() or away > NEW_PLACE:
            self._kept.append((real, np.stack(real.outward(x, y), axis=1)))
            self._known = _prepared(np.concatenate([points for _, points in self._kept]))
        return real


def _prepared(points: Floats) -> tuple:
    layers = [np.column_stack((points, np.full(len(points), height))) for height in _LAYERS]
    return small_gicp.preprocess_points(
        np.concatenate(layers), downsampling_resolution=0.02, num_neighbors=12, num_threads=1
    )


def _matrix(pose: Pose) -> Floats:
    matrix = np.eye(4)
    cosine, sine = math.cos(pose.theta), math.sin(pose.theta)
    matrix[:2, :2] = (cosine, -sine), (sine, cosine)
    matrix[:2, 3] = pose.x, pose.y
    return matrix
