"""Which reports count as evidence, and from where."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.navigation import MotionState, RobotState
from hub.modules.mapping.scans import LONGEST_LAG, SCANS_A_PLACE, ScanSelector
from tests.support.cases import for_each

ECHOES = np.linspace(0.5, 3.0, 16, dtype=np.float32)
NOTHING = np.full(16, np.inf, np.float32)


def report(x: float = 0.0, theta: float = 0.0, **fields: object) -> RobotState:
    values = {
        "linear": 0.0,
        "angular": 0.0,
        "sonar": ECHOES,
        "infrared": NOTHING,
        **fields,
    }
    return RobotState(
        stamp=0.0,
        x=x,
        y=0.0,
        theta=theta,
        commanded_linear=0.0,
        commanded_angular=0.0,
        bumpers=0,
        battery_voltage=math.nan,
        battery_fraction=math.nan,
        motion=MotionState.MOVING,
        refused=0,
        **values,  # type: ignore[arg-type]
    )


def test_a_scan_that_is_reported_again_is_no_new_evidence() -> None:
    scans = ScanSelector()
    assert scans.scan(report(), 0.0) is not None
    assert scans.scan(report(x=0.06), 0.05) is not None  # nothing came back to infrared here
    again = ScanSelector()
    assert again.scan(report(infrared=ECHOES), 0.0) is not None
    assert again.scan(report(infrared=ECHOES), 0.05) is None
    assert again.scan(report(x=0.5, infrared=ECHOES), 0.10) is None


def test_only_ranges_that_changed_count() -> None:
    scans = ScanSelector()
    scans.scan(report(), 0.0)
    changed = ECHOES.copy()
    changed[3] += 0.01
    scan = scans.scan(report(sonar=changed), 0.1)
    assert scan is not None
    assert np.flatnonzero(~np.isnan(scan.sonar)).tolist() == [3]
    assert np.isnan(scan.infrared).all()


def test_silent_sensors_say_so_anew_with_the_others_of_their_ring() -> None:
    partly = np.where(np.arange(16) < 8, ECHOES, np.inf).astype(np.float32)
    scans = ScanSelector()
    scans.scan(report(sonar=partly), 0.0)
    scan = scans.scan(report(sonar=(partly * 1.01).astype(np.float32)), 0.1)
    assert scan is not None
    assert np.isinf(scan.sonar[8:]).all()
    assert np.isnan(scan.infrared).all()


def test_in_a_hall_without_echoes_each_new_place_counts() -> None:
    scans = ScanSelector()
    used = [scans.scan(report(x=0.02 * n, sonar=NOTHING), 0.05 * n) for n in range(20)]
    assert 5 <= sum(scan is not None for scan in used) <= 10


def test_standing_still_only_a_few_scans_count() -> None:
    scans = ScanSelector()
    random = np.random.default_rng(1)
    used = 0
    for number in range(100):
        noisy = (ECHOES * random.normal(1.0, 0.01, 16)).astype(np.float32)
        used += scans.scan(report(sonar=noisy), 0.1 * number) is not None
    assert used == SCANS_A_PLACE
    assert scans.scan(report(x=0.06), 10.1) is not None
    assert scans.scan(report(x=0.06, theta=0.1, sonar=ECHOES[::-1]), 10.2) is not None


def test_the_scan_was_made_half_way_since_the_report_before() -> None:
    scans = ScanSelector()
    scans.scan(report(), 1.0)
    scan = scans.scan(report(x=0.5, sonar=ECHOES[::-1], linear=0.4, angular=1.0), 1.1)
    assert scan is not None
    assert scan.x == pytest.approx(0.5 - 0.4 * 0.05, abs=1e-4)
    assert scan.theta == pytest.approx(-0.05)
    assert scan.y == pytest.approx(0.0005, abs=1e-4)


def test_after_a_pause_the_scan_is_not_older_than_scans_can_be() -> None:
    scans = ScanSelector()
    scans.scan(report(), 1.0)
    scan = scans.scan(report(x=1.0, sonar=ECHOES[::-1], linear=0.5), 9.0)
    assert scan is not None
    assert scan.x == pytest.approx(1.0 - 0.5 * LONGEST_LAG / 2)


def test_a_jump_of_the_pose_does_not_move_the_scan() -> None:
    """A landmark corrects the pose: the way comes from the velocities, not from two poses."""
    scans = ScanSelector()
    scans.scan(report(x=0.0, linear=0.2), 1.0)
    scan = scans.scan(report(x=2.0, sonar=ECHOES[::-1], linear=0.2), 1.05)
    assert scan is not None
    assert scan.x == pytest.approx(2.0 - 0.2 * 0.025)


@given(x=st.floats(), theta=st.floats(), linear=st.floats(), angular=st.floats())
@example(x=1.7e308, theta=-1.7e308, linear=1.7e308, angular=1.7e308)
def test_no_report_breaks_the_selection(
    x: float, theta: float, linear: float, angular: float
) -> None:
    scans = ScanSelector()
    for time in (0.0, 9.0):
        scan = scans.scan(report(x=x, theta=theta, linear=linear, angular=angular), time)
        assert scan is None or math.isfinite(scan.theta)


@for_each("field", ["x", "theta", "linear", "angular"])
def test_a_report_that_is_not_finite_is_survived(field: str) -> None:
    scans = ScanSelector()
    scan = scans.scan(report(**{field: math.nan}), 1.0)  # type: ignore[arg-type]
    assert (scan is None) == (field in ("x", "theta"))
    assert scans.scan(report(x=1.0, sonar=ECHOES[::-1]), 1.1) is not None
