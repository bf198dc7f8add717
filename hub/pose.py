"""Angles and poses in the plane, and transformations between frames; pure.

Frames as in ROS REP 105 (`map`, `odom`, and the robot's own `base_link`), axes as in REP 103: x
forward, y left [m], angles counter-clockwise from x [rad].
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeVar

from hub.values import dataclass

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

Number = TypeVar("Number", float, "npt.NDArray[np.float64]")
"""One number, or many at a time, shape (n,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """A place and a heading in a frame; also the pose of another frame in it.

    Attributes:
        x: Position [m].
        y: Position [m].
        theta: Heading [rad].
    """

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def outward(self, x: Number, y: Number) -> tuple[Number, Number]:
        """Points that are seen from this pose [m], in the pose's own frame [m]."""
        cosine, sine = math.cos(self.theta), math.sin(self.theta)
        return self.x + x * cosine - y * sine, self.y + x * sine + y * cosine

    def inward(self, x: Number, y: Number) -> tuple[Number, Number]:
        """Points of the pose's own frame [m], as they are seen from this pose [m]."""
        cosine, sine = math.cos(self.theta), math.sin(self.theta)
        to_x, to_y = x - self.x, y - self.y
        return to_x * cosine + to_y * sine, to_y * cosine - to_x * sine

    def then(self, pose: Pose) -> Pose:
        """A pose that is given in this one, in this one's own frame."""
        x, y = self.outward(pose.x, pose.y)
        return Pose(x=x, y=y, theta=wrapped(self.theta + pose.theta))

    def seen_from(self, pose: Pose) -> Pose:
        """This pose in another one of the same frame: `pose.then` of it is this pose again."""
        x, y = pose.inward(self.x, self.y)
        return Pose(x=x, y=y, theta=wrapped(self.theta - pose.theta))


def wrapped(angle: float) -> float:
    """The same direction in (-pi, pi] [rad]."""
    around = math.remainder(angle, math.tau)
    return math.pi if around <= -math.pi else around


def each_wrapped(angles: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The same directions, each within a rounding of (-pi, pi] [rad]; any shape."""
    return math.pi - (math.pi - angles) % math.tau
