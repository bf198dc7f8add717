"""A way of straight pieces, and how far along it the robot is; pure."""

from __future__ import annotations

import math
from itertools import pairwise

from hub.pose import Pose

Way = tuple[tuple[float, float], ...]

CARROT = 0.5
"""So far along the way lies the point that the robot heads for [m]."""
OFF = 0.5
"""Farther from the way than this [m] the robot has left it."""


class Route:
    """A way in `map`, from where it was planned to the goal.

    Attributes:
        way: Its points [m], at least two.
    """

    def __init__(self, way: Way) -> None:
        self.way = way if len(way) > 1 else (way[0], way[0])

    def ahead(self, pose: Pose, carrot: float = CARROT) -> tuple[tuple[float, float], float, float]:
        """Where to head for.

        Args:
            pose: The robot's in `map`.
            carrot: How far along the way from the robot's nearest point on it [m].

        Returns:
            The point to head for in `map` [m], the length of the way that is left [m], and how far
            the robot is off the way [m].
        """
        piece, share, off = self._nearest(pose)
        start = _between(self.way[piece], self.way[piece + 1], share)
        rest = (start, *self.way[piece + 1 :])
        left = sum(math.dist(a, b) for a, b in pairwise(rest))
        return _along(rest, carrot), left + off, off

    def _nearest(self, pose: Pose) -> tuple[int, float, float]:
        """The piece that is nearest, where on it the nearest point is (0 to 1), and how far [m]."""
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
    """The point at some length along a way [m], or its end."""
    for start, end in pairwise(way):
        piece = math.dist(start, end)
        if piece >= length > 0.0:
            return _between(start, end, length / piece)
        length -= piece
    return way[-1]
