"""Overlays say where robots drove, stayed and bumped, and which victims were found."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from rune_study.data.overlay import CELL_M, TrialOverlay, overlay_of, simplified
from rune_study.metrics.trial import Contacts, Motion, RobotData, Travel, TrialData
from rune_study.metrics.victims import Mark
from rune_study.statistics.arrays import Floats

POINTS = arrays.arrays(
    np.float64,
    st.tuples(st.integers(0, 40), st.just(2)),
    elements=st.floats(-100, 100, allow_nan=False),
)


def robot(x: list[float], y: list[float], contacts: list[float] | None = None) -> RobotData:
    """A robot with a position each half second."""
    times = 0.5 * np.arange(len(x))
    zero = np.zeros(len(x))
    counts = np.array(contacts) if contacts else zero
    return RobotData(
        name="rover",
        travel=Travel(x=np.array(x), y=np.array(y)),
        motion=Motion(times=times, linear=zero, angular=zero),
        contacts=Contacts(times=times, counts=counts, bumpers=zero.astype(int), linear=zero),
    )


def overlay(*robots: RobotData, **data: object) -> TrialOverlay:
    trial = dataclasses.replace(TrialData(length=60.0, robots=robots), **data)
    return overlay_of(trial, participant=1, trial=1, code="A", arena="yellow")


def away(point: Floats, path: Floats) -> float:
    """Distance of a point from a path."""
    best = float(np.hypot(*(path - point).T).min())
    for begin, end in itertools.pairwise(path):
        along = end - begin
        length = float(along @ along)
        if length:
            share = min(max(float((point - begin) @ along) / length, 0.0), 1.0)
            best = min(best, float(np.hypot(*(point - begin - share * along))))
    return best


@given(path=POINTS, tolerance=st.floats(0.001, 10))
def test_a_simplified_path_keeps_its_ends_and_stays_near(path: Floats, tolerance: float) -> None:
    found = simplified(path, tolerance)
    assert len(found) <= len(path)
    if len(path):
        assert (found[[0, -1]] == path[[0, -1]]).all()
        assert all(away(point, found) <= tolerance + 1e-9 for point in path)


def test_a_straight_drive_is_two_points_and_has_its_length() -> None:
    found = overlay(robot([0, 0.25, 0.5, 0.75, 1.0], [0] * 5))
    assert [path.tolist() for path in found.paths] == [[[0, 0], [1, 0]]]
    assert found.driven == pytest.approx(1.0)


def test_a_jump_is_not_driven_and_damaged_positions_do_not_count() -> None:
    found = overlay(robot([0, 0.5, 40, 40.5, np.nan, 1e300], [0, 0, 0, 0, 0, 0]))
    assert len(found.paths) == 2
    assert found.driven == pytest.approx(1.0)
    assert sum(found.stays.values()) == pytest.approx(2.0)


def test_bumps_are_where_the_robot_was_and_are_counted_once() -> None:
    found = overlay(robot([0, 0.1, 0.2, 0.3], [1, 1, 1, 1], [0, 1, 2, 2]))
    assert found.bumps.tolist() == [[0.1, 1]]


def test_time_is_counted_in_cells() -> None:
    found = overlay(robot([-0.1, 0.1, 0.1, 2 * CELL_M + 0.1], [0.1] * 4))
    assert found.stays == {(-1, 0): 0.5, (0, 0): 1.0, (2, 0): 0.0}


def test_victims_are_found_by_the_nearest_marks_and_others_are_false() -> None:
    marks = [
        Mark(time=1, x=0.5, y=0),
        Mark(time=2, x=5, y=5),
        Mark(time=3, x=9, y=0, removed=True),
    ]
    found = overlay(marks=tuple(marks), victims=np.array([[0.0, 0.0], [9.0, 0.0]]))
    assert found.found.tolist() == [True, False]
    assert found.false.tolist() == [[5.0, 5.0]]


def test_a_trial_without_robots_or_truth_is_empty() -> None:
    found = overlay()
    assert found.paths == ()
    assert len(found.victims) == len(found.bumps) == len(found.false) == 0
