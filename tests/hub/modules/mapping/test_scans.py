"""Which scans count as evidence, and from where."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.beams import beams_of
from hub.gcm.body import RangeGroup, RangeKind, RobotBody
from hub.gcm.ranges import RangeReadings, scan_of
from hub.modules.mapping.scans import SCANS_A_PLACE, Scan, ScanSelector
from hub.pose import Pose

SONAR = RangeGroup(name="sonar", kind=RangeKind.SONAR, beams=4, farthest=5.0)
LASER = RangeGroup(name="laser", kind=RangeKind.LASER, beams=3, farthest=8.0)
BEAMS = beams_of(RobotBody(name="a", kind="b", radius=0.2, ranges=(SONAR, LASER)))
HERE = Pose()


def readings(sonar: float, laser: float) -> RangeReadings:
    """Scans measured at these times."""
    stamps = ((SONAR, sonar), (LASER, laser))
    return RangeReadings(
        scans=tuple(
            scan_of(group, np.full(group.beams, 1.0, np.float32), stamp) for group, stamp in stamps
        )
    )


def measured(scan: Scan | None) -> list[bool]:
    """Whether sonar and laser are in a scan."""
    if scan is None:
        return [False, False]
    known = ~np.isnan(scan.ranges)
    return [bool(known[:4].all()), bool(known[4:].all())]


def test_a_scan_that_is_reported_again_is_no_new_evidence() -> None:
    scans = ScanSelector(BEAMS)
    assert measured(scans.scan(readings(1.0, 1.0), HERE)) == [True, True]
    assert scans.scan(readings(1.0, 1.0), Pose(x=1.0)) is None
    assert measured(scans.scan(readings(1.0, 1.1), Pose(x=2.0))) == [False, True]
    assert measured(scans.scan(readings(1.2, 1.1), Pose(x=3.0))) == [True, False]


def test_standing_still_only_a_few_scans_of_each_group_count() -> None:
    scans = ScanSelector(BEAMS)
    used = [measured(scans.scan(readings(n // 5, n), HERE)) for n in range(20)]
    assert np.sum(used, axis=0).tolist() == [SCANS_A_PLACE, SCANS_A_PLACE]
    assert measured(scans.scan(readings(30, 30), Pose(x=0.06))) == [True, True]
    assert measured(scans.scan(readings(31, 31), Pose(x=0.06, theta=0.1))) == [True, True]


def test_a_scan_has_the_pose_at_which_it_was_measured() -> None:
    scan = ScanSelector(BEAMS).scan(readings(1.0, 1.0), Pose(x=2.0, theta=1.0))
    assert scan is not None
    assert scan.pose == Pose(x=2.0, theta=1.0)


def test_scans_of_a_group_that_the_body_does_not_have_do_not_count() -> None:
    other = scan_of(
        RangeGroup(name="other", kind=RangeKind.LASER, farthest=1.0), np.ones(1, np.float32), 1.0
    )
    assert ScanSelector(BEAMS).scan(RangeReadings(scans=(other,)), HERE) is None


@given(x=st.floats(), y=st.floats(), theta=st.floats())
@example(x=1.7e308, y=-1.7e308, theta=1.7e308)
@example(x=math.nan, y=0.0, theta=0.0)
@example(x=0.0, y=0.0, theta=math.inf)
def test_only_scans_with_a_known_pose_count(x: float, y: float, theta: float) -> None:
    scans = ScanSelector(BEAMS)
    known = all(map(math.isfinite, (x, y, theta)))
    for stamp in range(3):
        scan = scans.scan(readings(stamp, stamp), Pose(x=x, y=y, theta=theta))
        assert (scan is not None) == (known and stamp < SCANS_A_PLACE)
    assert scans.scan(readings(9.0, 9.0), Pose(x=0.5, y=3.0)) is not None
