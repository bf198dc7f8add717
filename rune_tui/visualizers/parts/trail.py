"""The trails of robots on maps."""

from __future__ import annotations

import math
from collections import deque
from typing import Final, Self

import numpy as np

from rune_tui.model.pose import Pose
from rune_tui.model.sightings import Floats

STEP_M: Final = 0.1
"""Least distance between points of a trail [m]."""

_JUMP_M: Final = 1.0
"""A longer step is no motion [m]: the pose was corrected, or the robot was carried."""
_GAP: Final = (math.nan, math.nan)


class Trail:
    """The newest points of each robot's trail."""

    def __init__(self, longest: float) -> None:
        """Start without points.

        Args:
            longest: Largest length of a trail [m].
        """
        self._most = math.ceil(longest / STEP_M)
        self._ways: dict[str, deque[tuple[float, float]]] = {}

    def __copy__(self) -> Self:
        """A trail with the same points, which grows by itself."""
        twin = object.__new__(type(self))
        vars(twin).update(vars(self), _ways={name: way.copy() for name, way in self._ways.items()})
        return twin

    def follow(self, robot: str, pose: Pose) -> None:
        """Add a robot's pose to its trail, if it has moved."""
        if not self._most:
            return
        way = self._ways.setdefault(robot, deque(maxlen=self._most))
        moved = math.dist(way[-1], (pose.x, pose.y)) if way else math.inf
        if moved < STEP_M:
            return
        if way and moved > _JUMP_M:
            way.append(_GAP)
        way.append((pose.x, pose.y))

    def points(self, robot: str) -> list[Floats]:
        """The pieces of a trail in `map` [m], each of shape (n, 2)."""
        way = np.array(self._ways.get(robot, ()), np.float64).reshape(-1, 2)
        breaks = np.flatnonzero(np.isnan(way[:, 0]))
        pieces = np.split(way, breaks)
        return [piece[~np.isnan(piece[:, 0])] for piece in pieces]
