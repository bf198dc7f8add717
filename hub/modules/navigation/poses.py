"""Poses in the plane and how one frame lies in another; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """A place and a heading in a frame; also how another frame lies in it.

    Attributes:
        x: Position [m].
        y: Position [m].
        theta: Heading [rad].
    """

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def outward(self, x: float, y: float) -> tuple[float, float]:
        """A point that is seen from this pose [m], in the pose's own frame [m]."""
        cosine, sine = math.cos(self.theta), math.sin(self.theta)
        return self.x + x * cosine - y * sine, self.y + x * sine + y * cosine

    def inward(self, x: float, y: float) -> tuple[float, float]:
        """A point of the pose's own frame [m], as it is seen from this pose [m]."""
        cosine, sine = math.cos(self.theta), math.sin(self.theta)
        to_x, to_y = x - self.x, y - self.y
        return to_x * cosine + to_y * sine, to_y * cosine - to_x * sine

    def then(self, pose: Pose) -> Pose:
        """A pose that is given in this one, in this one's own frame."""
        x, y = self.outward(pose.x, pose.y)
        return Pose(x=x, y=y, theta=wrapped(self.theta + pose.theta))


def wrapped(angle: float) -> float:
    """The same direction within (-pi, pi] [rad]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)
