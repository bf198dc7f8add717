"""Ground behind what stands near is not drawn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rune_tui.model.covered_ground import COVERS_M, covered, covers_of, uncovered
from rune_tui.model.robot_ranges import RobotRanges
from tests.console.states import range_readings, ranges_around
from tests.support.car import CAR, car_readings, laser_of
from tests.support.magellan import magellan_body

CLEAR = np.full(16, np.inf, np.float32)


def ahead(distance: float) -> tuple[float, ...]:
    sonar = CLEAR.copy()
    sonar[[15, 0, 1]] = distance
    return covers_of(around(sonar=sonar))


def around(**readings: Any) -> RobotRanges:
    return ranges_around(magellan_body(), range_readings(**readings))


def test_ground_is_covered_behind_a_wall_ahead_and_not_beside_it() -> None:
    points = np.array([[0.2, 0.0], [2.0, 0.0], [2.0, 0.7], [0.0, 2.0], [-2.0, 0.0]])
    assert covered(points, ahead(0.27)).tolist() == [False, True, True, False, False]


def test_what_a_sensor_at_the_side_finds_covers_the_ground_behind_it_there() -> None:
    covers = covers_of(ranges_around(CAR, car_readings(side=0.5)))
    points = np.array([[-0.2, -0.7], [-0.4, -1.5], [-0.2, 1.5], [1.5, -0.2]])
    assert covered(points, covers).tolist() == [False, True, False, False]


def test_a_scan_covers_the_ground_behind_what_it_hits_however_far_it_is() -> None:
    laser = laser_of(**{f"{side}{degree}": 3.0 for side in "lr" for degree in range(20)})
    covers = covers_of(ranges_around(CAR, car_readings(laser=laser)))
    points = np.array([[3.3, 0.0], [3.8, 0.0], [3.8, 0.9], [0.0, 3.8]])
    assert covered(points, covers).tolist() == [False, True, True, False]


def test_nothing_is_covered_by_what_is_far_or_not_seen() -> None:
    assert ahead(COVERS_M + 0.1) == ()
    assert covers_of(None) == ()
    assert covers_of(around(sonar=math.nan)) == ()
    assert not covered(np.array([[9.0, 0.0]]), ()).any()


def test_a_line_goes_as_far_as_the_wall_and_on_beside_it() -> None:
    line = np.array([[0.0, 0.0], [5.0, 0.0], [np.nan, np.nan], [1.0, -5.0], [1.0, 5.0]])
    seen = uncovered(line, ahead(0.7))
    along = seen[np.isfinite(seen[:, 0]) & (seen[:, 1] == 0.0)]
    assert along[:, 0].max() == pytest.approx(0.8, abs=0.2)
    beside = seen[np.isfinite(seen[:, 1]) & (np.abs(seen[:, 1]) > 1.0)]
    assert beside[:, 1].min() == -5.0
    assert beside[:, 1].max() == 5.0
    assert uncovered(line, ()) is line


def test_what_is_covered_changes_in_steps_only() -> None:
    assert ahead(0.501) == ahead(0.499) != ahead(0.6)


@pytest.mark.parametrize("far", [1e4, 1e12, 1e300])
def test_a_line_of_any_length_takes_little_memory(far: float) -> None:
    line = np.array([(1.0, 0.0), (far, 0.0), (1.0, 0.0)])
    broken = uncovered(line, (0.5, *(float("inf"),) * 15))
    assert 3 <= len(broken) < 1000
    assert np.isnan(broken).all()
