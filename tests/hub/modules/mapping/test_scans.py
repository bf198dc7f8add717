"""Which scans count as evidence."""

from __future__ import annotations

import numpy as np

from hub.gcm.beam_scans import BeamScan
from hub.gcm.beams import beams_of
from hub.gcm.body import RangeGroup, RangeKind, RobotBody
from hub.modules.mapping.scans import SCANS_A_PLACE, ScanSelector
from hub.pose import Pose

SONAR = RangeGroup(name="sonar", kind=RangeKind.SONAR, beams=4, farthest=5.0)
LASER = RangeGroup(name="laser", kind=RangeKind.LASER, beams=3, farthest=8.0)
BEAMS = beams_of(RobotBody(name="a", kind="b", radius=0.2, ranges=(SONAR, LASER)))


def used(scans: ScanSelector, pose: Pose, *, sonar: bool = True, laser: bool = True) -> list[bool]:
    """Whether sonar and laser count, of a scan in which they are new or not."""
    fresh = np.array([sonar] * 4 + [laser] * 3)
    evidence = scans.evidence(BeamScan(pose=pose, ranges=np.arange(1.0, 8.0), fresh=fresh))
    if evidence is None:
        return [False, False]
    known = ~np.isnan(evidence)
    assert evidence[known].tolist() == np.arange(1.0, 8.0)[known].tolist()
    return [bool(known[:4].all()), bool(known[4:].all())]


def test_only_new_ranges_count() -> None:
    scans = ScanSelector(BEAMS)
    assert used(scans, Pose()) == [True, True]
    assert used(scans, Pose(x=1.0), sonar=False) == [False, True]
    assert used(scans, Pose(x=2.0), laser=False) == [True, False]
    assert used(scans, Pose(x=3.0), sonar=False, laser=False) == [False, False]


def test_from_one_place_only_a_few_scans_of_each_group_count() -> None:
    scans = ScanSelector(BEAMS)
    here = [used(scans, Pose(), sonar=number % 5 == 0) for number in range(20)]
    assert np.sum(here, axis=0).tolist() == [SCANS_A_PLACE, SCANS_A_PLACE]
    assert used(scans, Pose(x=0.06)) == [True, True]
    assert used(scans, Pose(x=0.06, theta=0.1)) == [True, True]
