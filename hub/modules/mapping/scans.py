"""New scans among the readings of range sensors; pure."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.beams import Beams
from hub.gcm.ranges import LaserScan, RangeReadings
from hub.gcm.standard import Time
from hub.modules.mapping.evidence import Floats
from hub.pose import Pose, wrapped
from hub.values import dataclass

SAME_PLACE = 0.05
"""Scans nearer to each other than this come from the same place [m]."""
SAME_HEADING = math.radians(5.0)
"""The same for the heading [rad]."""
SCANS_A_PLACE = 2
"""Largest number of scans of a group used from one place: a sonar repeats its errors."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scan:
    """Ranges, and the pose at which they were measured.

    Attributes:
        pose: The robot's pose in `map`.
        ranges: Range of each beam [m], shape (beams,); inf: no echo; NaN: no evidence.
    """

    pose: Pose
    ranges: Floats


@dataclass(slots=True, kw_only=True)
class _LastScans:
    """The last used scans of a group: its stamp, their place, and their number there."""

    stamp: Time
    place: Pose
    used: int


class ScanSelector:
    """Picks the new scans out of the readings.

    Readings repeat the scans of groups that have not measured since. A new scan has a new stamp.
    """

    def __init__(self, beams: Beams) -> None:
        self._beams = beams
        self._groups: dict[str, _LastScans] = {}

    def scan(self, readings: RangeReadings, pose: Pose) -> Scan | None:
        """The new scans in the readings.

        Args:
            readings: The newest scan of each group.
            pose: The robot's pose in `map` when the newest was measured; NaN: not known.

        Returns:
            None if nothing is new, if enough scans came from this place, or without a pose.
        """
        if not all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            return None
        new = tuple(scan for scan in readings.scans if self._is_used(scan, pose))
        ranges = self._beams.ranges(RangeReadings(scans=new))
        return None if np.isnan(ranges).all() else Scan(pose=pose, ranges=ranges)

    def _is_used(self, scan: LaserScan, pose: Pose) -> bool:
        """Whether a scan is new, and not one too many from one place."""
        name, stamp = scan.header.frame_id, scan.header.stamp
        if name not in self._beams.groups:
            return False
        group = self._groups.get(name)
        if group is None:
            group = self._groups[name] = _LastScans(stamp=stamp, place=pose, used=0)
        elif group.stamp == stamp:
            return False
        group.stamp = stamp
        if _moved(group.place, pose):
            group.place, group.used = pose, 0
        group.used += 1
        return group.used <= SCANS_A_PLACE


def _moved(before: Pose, now: Pose) -> bool:
    """Whether two poses are different places."""
    turned = abs(wrapped(now.theta - before.theta))
    return math.hypot(now.x - before.x, now.y - before.y) > SAME_PLACE or turned > SAME_HEADING
