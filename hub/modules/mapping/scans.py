"""Picks the scans that count as evidence; pure."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.beam_scans import BeamScan
from hub.gcm.beams import Beams
from hub.modules.mapping.evidence import Floats
from hub.pose import Pose, wrapped

SAME_PLACE = 0.05
"""Scans nearer to each other than this come from the same place [m]."""
SAME_HEADING = math.radians(5.0)
"""The same for the heading [rad]."""
SCANS_A_PLACE = 2
"""Largest number of scans of a group used from one place: a sonar repeats its errors."""


class ScanSelector:
    """Picks the new ranges of a scan, unless enough of their group came from the same place."""

    def __init__(self, beams: Beams) -> None:
        self._groups = beams.groups
        self._places: dict[str, Pose] = {}
        self._used = dict.fromkeys(beams.groups, 0)

    def evidence(self, scan: BeamScan) -> Floats | None:
        """The ranges that count [m], shape (beams,), NaN for the others; None: no range counts."""
        counts = scan.fresh.copy()
        for name, group in self._groups.items():
            if counts[group].any():
                counts[group] &= self._is_used(name, scan.pose)
        if not counts.any():
            return None
        return np.where(counts, scan.ranges, np.nan).astype(np.float32)

    def _is_used(self, name: str, pose: Pose) -> bool:
        """Count a scan of a group; returns whether it is not one too many from one place."""
        before = self._places.get(name)
        if before is None or _moved(before, pose):
            self._places[name], self._used[name] = pose, 0
        self._used[name] += 1
        return self._used[name] <= SCANS_A_PLACE


def _moved(before: Pose, now: Pose) -> bool:
    """Whether two poses are different places."""
    turned = abs(wrapped(now.theta - before.theta))
    return math.hypot(now.x - before.x, now.y - before.y) > SAME_PLACE or turned > SAME_HEADING
