"""Transforms between a robot's own frame (x ahead, y left) and the world frame `map`."""

from __future__ import annotations

import math
from typing import Self

import numpy as np
import numpy.typing as npt

from hub import pose
from hub.gcm.vision import CameraState
from rune_tui.model.sightings import Floats


class Pose(pose.Pose):
    """The pose of a robot in `map`; points are arrays."""

    __slots__ = ()

    @classmethod
    def of(cls, camera: CameraState) -> Self | None:
        """The robot's pose at the time of a picture; None: not known."""
        known = (camera.robot_x, camera.robot_y, camera.robot_theta)
        if not all(map(math.isfinite, known)):
            return None
        return cls(x=camera.robot_x, y=camera.robot_y, theta=camera.robot_theta)

    def to_map(self, points: npt.ArrayLike) -> Floats:
        """Points of the robot's frame in `map` [m], shape (..., 2) both."""
        ahead, left = np.moveaxis(np.asarray(points, np.float64), -1, 0)
        return np.stack(self.outward(ahead, left), axis=-1)

    def from_map(self, points: npt.ArrayLike) -> Floats:
        """Points of `map` in the robot's frame [m], shape (..., 2) both."""
        x, y = np.moveaxis(np.asarray(points, np.float64), -1, 0)
        return np.stack(self.inward(x, y), axis=-1)
