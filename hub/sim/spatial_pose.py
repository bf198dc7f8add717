"""Poses in space."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.orientation import rotation
from hub.pose import Pose
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class SpatialPose:
    """A place and an attitude in the world (x east, y north, z up): yaw, then pitch, then roll.

    Attributes:
        x: Position [m].
        y: Position [m].
        z: Position [m].
        roll: About x of the body [rad]; positive: right side down.
        pitch: About y of the body [rad]; positive: nose down.
        yaw: About z, counter-clockwise from east [rad].
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0

    @property
    def finite(self) -> bool:
        """Whether all its numbers are."""
        numbers = (self.x, self.y, self.z, self.roll, self.pitch, self.yaw)
        return all(map(math.isfinite, numbers))

    @property
    def plan(self) -> Pose:
        """Place and heading, seen from above."""
        return Pose(x=self.x, y=self.y, theta=self.yaw)

    def at(self, plan: Pose) -> SpatialPose:
        """The same height and lean at another place and heading."""
        return SpatialPose(
            x=plan.x, y=plan.y, z=self.z, roll=self.roll, pitch=self.pitch, yaw=plan.theta
        )

    def rotation(self) -> npt.NDArray[np.float64]:
        """The body's axes in the arena's frame as columns, shape (3, 3)."""
        return rotation(self.roll, self.pitch, self.yaw)

    @property
    def lean(self) -> float:
        """Angle between the body's axis and the vertical [rad]."""
        return math.acos(max(-1.0, min(1.0, math.cos(self.pitch) * math.cos(self.roll))))
