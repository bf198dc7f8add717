"""A path of straight pieces, and the robot's place on it; pure."""

from __future__ import annotations

import math
from itertools import pairwise

from hub.pose import Pose

Way = tuple[tuple[float, float], ...]

CARROT = 0.5
"""The robot heads for a point this far along the path [m]."""
OFF = 0.5
"""The robot has left the path at this distance from it [m]."""


class Route:
    """A path in `map`, from the robot's place at planning to the goal.

    Attributes:
        way: Its points [m], at least two.
    """

    def __init__(self, way: Way) -> None:
        self.way = way if len(way) > 1 else (way[0], way[0])

    def ahead(self, pose: Pose, carrot: float = CARROT) -> tuple[tuple[float, float], float, float]:
        """The point to head for.

        Args:
            pose: The robot's in `map`.
            carrot: Distance along the path from its point nearest to the robot [m].

        Returns:
            The point to head for in `map` [m], the length of the path that is left [m], and the
            robot's distance from the path [m].
        """
        piece, share, off = self._nearest(pose)
        start = _between(self.way[piece], self.way[piece + 1], share)
        rest = (start, *self.way[piece + 1 :])
        left = sum(math.dist(a, b) for a, b in pairwise(rest))
        return _along(rest, carrot), left + off, off

    def _nearest(self, pose: Pose) -> tuple[int, float, float]:
        """The nearest piece, the place of its nearest point (0 to 1), and the distance [m]."""
        best = (0, 0.0, math.inf)
        for number, (start, end) in enumerate(pairwise(self.way)):
            along_x, along_y = end[0] - start[0], end[1] - start[1]
            square = along_x * along_x + along_y * along_y
            share = (pose.x - start[0]) * along_x + (pose.y - start[1]) * along_y
            share = max(0.0, min(1.0, share / square)) if square > 0.0 else 0.0
            off = math.dist(_between(start, end, share), (pose.x, pose.y))
            if off <= best[2]:
                best = (number, share, off)
        return best


def _between(
    start: tuple[float, float], end: tuple[float, float], share: float
) -> tuple[float, float]:
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def _along(way: Way, length: float) -> tuple[float, float]:
    """The point at some length along a path [m], or its end."""
    for start, end in pairwise(way):
        piece = math.dist(start, end)
        if piece >= length > 0.0:
            return _between(start, end, length / piece)
        length -= piece
    return way[-1]
