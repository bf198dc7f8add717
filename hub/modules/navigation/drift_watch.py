"""Corrects the pose by laser scans, and by a match of recent points with an older map; pure."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from hub.gcm.beam_scans import BeamScan
from hub.gcm.navigation import DriveState
from hub.grids.grid import Grid
from hub.grids.scan_matching import ScanMatcher, surfaces
from hub.modules.navigation.beam_rules import BeamRules, LightGroup
from hub.modules.navigation.correction import PoseCorrection
from hub.modules.navigation.matching import FARTHEST, Sightings, drift
from hub.modules.navigation.pose_uncertainty import PoseUncertainty, Spread
from hub.pose import Pose

YOUNGEST_S = 1.0
"""Least age of the map; the points since a younger one are too few [s]."""
OLDEST_S = 10.0
"""Largest age of the map; an older one may be outdated [s]."""
APART_S = 1.0
"""Least time between two matches, so that the same points do not count again [s]."""
LAID_S = 1.0
"""Maps are not matched for this time after a laser scan showed the pose more exactly [s]."""


class DriftWatch:
    """Keeps recent points, recent maps and the uncertainty of the pose."""

    def __init__(self, correction: PoseCorrection, rules: BeamRules) -> None:
        """Start without points and maps.

        Args:
            correction: The transform that it corrects.
            rules: What the robot's beams show.
        """
        self._correction = correction
        self._rules = rules
        self._uncertainty = PoseUncertainty()
        self._sightings = Sightings(rules)
        self._maps: deque[tuple[float, Grid]] = deque()
        self._matched = self._laid = -math.inf
        self._scans = ScanMatcher()

    def restart(self) -> None:
        """Forget points and maps: the robot has lost its place."""
        self._uncertainty = PoseUncertainty()
        self._sightings = Sightings(self._rules)
        self._maps.clear()
        self._matched = self._laid = -math.inf
        self._scans = ScanMatcher()

    @property
    def spread(self) -> Spread:
        """The uncertainty of the pose in the map."""
        return self._uncertainty.whole

    def moved(self, drive: DriveState, now: float) -> None:
        """Take a pose by dead reckoning; one that is not valid is left out."""
        here = Pose(x=drive.x, y=drive.y, theta=drive.theta)
        if _valid(here):
            self._uncertainty.moved(here, now)

    def scanned(self, scan: BeamScan, now: float) -> None:
        """Take new ranges; those at a pose that is not valid are left out."""
        if _valid(scan.pose):
            self._sightings.scanned(scan, now)
            laser = self._rules.laser
            if laser is not None and scan.fresh[laser.place].any():
                self._lay(scan, laser, now)

    def _lay(self, scan: BeamScan, laser: LightGroup, now: float) -> None:
        """Lay the scan of a laser onto those before, and correct the pose by it."""
        numbers = np.arange(laser.place.start, laser.place.stop)
        usable = np.isfinite(scan.ranges) & (scan.ranges > self._rules.blind)
        x, y = self._rules.beams.hits(numbers, np.where(usable, scan.ranges, np.nan))
        error = self._scans.matched(scan.pose, surfaces(x, y, laser.step))
        if error is None:
            return
        here = self._correction.odom.then(scan.pose)
        self._correction.shift(here, here.then(error))
        if self._scans.sure:
            self._uncertainty.laid()
            self._laid = now

    def met_landmark(self) -> None:
        """Note that a landmark corrected the pose."""
        self._uncertainty.met_landmark()

    def mapped(self, grid: Grid | None, odom: Pose, now: float) -> None:
        """Take a map and match the recent points with an older one.

        Args:
            grid: The map; None: no cell is known.
            odom: The robot's pose in `odom`.
            now: Monotonic time [s].
        """
        while self._maps and self._maps[0][0] < now - OLDEST_S:
            self._maps.popleft()
        old = [item for item in self._maps if item[0] <= now - YOUNGEST_S]
        if old and now - self._matched >= APART_S and now - self._laid >= LAID_S:
            self._match(*old[-1], odom, now)
        if grid is not None:
            self._maps.append((now, grid))

    def _match(self, came: float, grid: Grid, odom: Pose, now: float) -> None:
        x, y = self._correction.odom.outward(*self._sightings.since(came))
        here = self._correction.pose(odom.x, odom.y, odom.theta)
        match = drift(grid, x, y, here, self._uncertainty.spread)
        if match is None:
            return
        moved = match.moved
        there = Pose(x=here.x + moved.x, y=here.y + moved.y, theta=here.theta + moved.theta)
        self._correction.shift(here, there)
        self._uncertainty.matched(match.spread)
        self._matched = now


def _valid(pose: Pose) -> bool:
    return all(abs(each) < FARTHEST for each in (pose.x, pose.y, pose.theta))
