"""Corrects the pose by the map: what was seen lately is laid onto the map of before; pure."""

from __future__ import annotations

import math
from collections import deque

from hub.gcm.navigation import DriveState
from hub.grids.grid import Grid
from hub.modules.navigation.correction import PoseCorrection
from hub.modules.navigation.matching import FARTHEST, Sightings, drift
from hub.modules.navigation.pose_uncertainty import PoseUncertainty, Spread
from hub.pose import Pose

YOUNGEST_S = 1.0
"""What was seen since a younger map is too little to be laid onto it [s]."""
OLDEST_S = 10.0
"""An older map may be another one by now [s]."""
APART_S = 1.0
"""The same sightings do not count again and again: matches are so far apart [s]."""
BLIND = 0.11
"""What is nearer to the rim than this [m] infrared sensors cannot measure."""


class DriftWatch:
    """Knows what was seen and which maps came, and how far the pose may be off."""

    def __init__(self, correction: PoseCorrection, radius: float) -> None:
        """Begin.

        Args:
            correction: What it corrects.
            radius: The robot's [m].
        """
        self._correction = correction
        self._blind = radius + BLIND
        self._doubt = PoseUncertainty()
        self._sightings = Sightings()
        self._maps: deque[tuple[float, Grid]] = deque()
        self._matched = -math.inf

    def restart(self) -> None:
        """Forget what was seen and mapped: the robot has lost its place."""
        self._doubt = PoseUncertainty()
        self._sightings = Sightings()
        self._maps.clear()
        self._matched = -math.inf

    @property
    def spread(self) -> Spread:
        """How far the pose may be off in the map."""
        return self._doubt.whole

    def reported(self, drive: DriveState, now: float) -> None:
        """The hardware has reported; a pose that cannot be is left out."""
        here = Pose(x=drive.x, y=drive.y, theta=drive.theta)
        if not all(abs(each) < FARTHEST for each in (here.x, here.y, here.theta)):
            return
        self._doubt.moved(here, now)
        self._sightings.scanned(here, drive.sonar, drive.infrared, self._blind, now)

    def met_landmark(self) -> None:
        """A landmark has corrected the pose."""
        self._doubt.met_landmark()

    def mapped(self, grid: Grid | None, odom: Pose, now: float) -> None:
        """A map has come.

        Args:
            grid: The map; None: nothing is known.
            odom: The robot's pose in `odom`.
            now: Monotonic time [s].
        """
        while self._maps and self._maps[0][0] < now - OLDEST_S:
            self._maps.popleft()
        old = [item for item in self._maps if item[0] <= now - YOUNGEST_S]
        if old and now - self._matched >= APART_S:
            self._match(*old[-1], odom, now)
        if grid is not None:
            self._maps.append((now, grid))

    def _match(self, came: float, grid: Grid, odom: Pose, now: float) -> None:
        x, y = self._correction.odom.outward(*self._sightings.since(came))
        here = self._correction.pose(odom.x, odom.y, odom.theta)
        match = drift(grid, x, y, here, self._doubt.spread)
        if match is None:
            return
        moved = match.moved
        there = Pose(x=here.x + moved.x, y=here.y + moved.y, theta=here.theta + moved.theta)
        self._correction.shift(here, there)
        self._doubt.matched(match.spread)
        self._matched = now
