"""Transforms between a robot's own frame (x ahead, y left) and the world frame `map`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from hub.gcm.vision import CameraState
from rune_tui.model.sightings import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """The pose of a robot.

    Attributes:
        x: Its centre in `map` [m].
        y: Its centre in `map` [m].
        theta: Its heading in `map` [rad], counter-clockwise from x.
    """

    x: float
    y: float
    theta: float

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
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return np.stack(
            (self.x + ahead * cos - left * sin, self.y + ahead * sin + left * cos), axis=-1
        )

    def from_map(self, points: npt.ArrayLike) -> Floats:
        """Points of `map` in the robot's frame [m], shape (..., 2) both."""
        x, y = np.moveaxis(np.asarray(points, np.float64), -1, 0)
        x, y = x - self.x, y - self.y
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return np.stack((x * cos + y * sin, y * cos - x * sin), axis=-1)
