"""Bumps, paths, steering, cameras, latency, awareness and questionnaires."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from rune_study.errors import DataError
from rune_study.metrics import driving, questionnaires, steering
from rune_study.metrics.awareness import AnswerKind, Query, awareness
from rune_study.metrics.bumps import Bumps, bumps
from rune_study.metrics.latency import motion_to_photon
from tests.support.cases import for_each

RATINGS = dict(zip(questionnaires.TLX_SCALES, (100, 80, 60, 40, 20, 0), strict=True))
CHOICES = [
    scale
    for scale, times in zip(questionnaires.TLX_SCALES, (5, 4, 3, 2, 1, 0), strict=True)
    for _ in range(times)
]


def test_bumps_by_hand() -> None:
    found = bumps(
        [0, 0.1, 0.5, 2, 3.5, 5, 7],
        [0, 1, 2, 3, 4, 4, 6],
        [0, 1, 1, 1 << 8, 1 << 4, 0, 0],
        [0.3, 0.3, 0.3, -0.2, 0.1, 0, -0.1],
    )
    assert found == Bumps(front=1, rear=2, side=1)
    assert found.total == 4


@for_each(
    ("bits", "speed", "side"),
    [
        (0b1000000000000011, 0.2, "front"),
        (0, 0.0, "front"),
        (0, 0.1, "front"),
        (0, -0.1, "rear"),
        (1 << 3, -0.1, "front"),  # 67.5 degrees
        (1 << 4, -0.1, "side"),
        (1 << 5, -0.1, "rear"),  # 112.5 degrees
        (1 << 13, -0.1, "front"),
        (1 << 12, -0.1, "side"),
        (1 | 1 << 8, -0.1, "rear"),  # opposite ones cancel out
        (1 << 40, 0.1, "front"),  # no such bumper
    ],
)
def test_sides_of_bumps(bits: int, speed: float, side: str) -> None:
    found = bumps([0, 1], [0, 1], [0, bits], [0, speed])
    assert getattr(found, side) == found.total == 1


def test_bumps_are_armed_again_after_a_second() -> None:
    times, zeros = [0, 1, 1.9, 2, 3], [0] * 5
    assert bumps(times, [0, 1, 2, 2, 2], zeros, zeros).total == 1
    assert bumps(times, [0, 1, 2, 3, 3], zeros, zeros).total == 2
    assert bumps(times, [5, 5, 5, 4, 4], zeros, zeros).total == 0  # a counter that began again
    assert bumps([], [], [], []).total == 0
    with pytest.raises(DataError, match="one value"):
        bumps([0, 1], [0], [0, 0], [0, 0])


def test_bumpers_just_before_a_contact_count() -> None:
    rear = [0, 1 << 8, 0, 0]
    assert bumps([0, 0.9, 1.0, 2], [0, 0, 1, 1], rear, [1] * 4).rear == 1
    assert bumps([0, 0.8, 1.0, 2], [0, 0, 1, 1], rear, [1] * 4).front == 1


def test_path_lengths() -> None:
    assert driving.path_length([0, 3, 3], [0, 0, 4]) == 7
    assert driving.path_length([0, 0.01] * 500, [0] * 1000) == pytest.approx(0.01)
    assert driving.path_length([1], [1]) == driving.path_length([], []) == 0
    assert driving.path_length([math.nan, 0, 3], [0, 0, 4]) == 5
    assert driving.path_length(np.arange(101) * 0.01, np.zeros(101)) == pytest.approx(1.0)


def test_path_ratio_and_success() -> None:
    assert driving.path_ratio(10, 8, arrived=True) == 1.25
    assert math.isnan(driving.path_ratio(10, 8, arrived=False))
    assert driving.success_by_path_length(10, 8, arrived=True) == 0.8
    assert driving.success_by_path_length(7.9, 8, arrived=True) == 1
    assert driving.success_by_path_length(10, 8, arrived=False) == 0
    assert driving.success_by_path_length(0, 0, arrived=True) == 1


def test_camera_off_centre() -> None:
    pans = np.deg2rad([0, 20, -30, 30])
    found = driving.camera_off_centre([0, 2, 4, 6], pans, [0.3, 0.3, 0.3, 0], [0] * 4, 10)
    assert found == pytest.approx(4 / 6)
    at_15 = np.deg2rad([15, -15])
    assert driving.camera_off_centre([0, 1], at_15, [0.3, 0.3], [0, 0], 2) == 0
    assert math.isnan(driving.camera_off_centre([0], [1.0], [0.05], [0.1], 5))
    assert driving.camera_off_centre([0], [1.0], [0.0], [-0.2], 5) == 1
    assert math.isnan(driving.camera_off_centre([], [], [], [], 5))
    with pytest.raises(DataError, match="ascending"):
        driving.camera_off_centre([0, 6], [0, 0], [0, 0], [0, 0], 5)


def test_stick_moves() -> None:
    values = [0, 0.04, 0.05, 0.06, 0.1, 0.2, 0, 0]
    assert driving.stick_moves(range(8), values).tolist() == [3, 5, 6]
    assert driving.stick_moves([], []).size == 0


def wave(size: float, hertz: float, rate: float = 30.0) -> np.ndarray:
    times = np.arange(round(60 * rate) + 1) / rate
    return size * np.sin(math.tau * hertz * times)


@for_each(
    ("size", "hertz", "cut", "wanted"),
    [
        (10, 0.25, None, 30),
        (1.4, 0.25, None, 0),
        (10, 1, None, 120),
        (10, 0.25, 0.6, 30),
    ],
)
def test_reversals_of_sines(size: float, hertz: float, cut: float | None, wanted: float) -> None:
    way = steering.Reversals(gap=3, cut_hz=cut)
    assert steering.reversal_rate(wave(size, hertz), 30, way) == pytest.approx(wanted)


def test_reversals() -> None:
    assert steering.reversals([0, 5, 0, 5, 0], 3) == 3  # the last sample is not stationary
    assert steering.reversals([0, 5, 5, 0], 3) == 1
    assert steering.reversals([], 3) == steering.reversals([1], 3) == 0
    assert steering.reversal_rate(wave(10, 1), 30, steering.VISUAL) <= 1
    assert steering.reversal_rate(np.zeros(100), 30, steering.VISUAL) == 0
    assert math.isnan(steering.reversal_rate(np.zeros(9), 30, steering.KEYS))
    assert steering.reversal_rate(np.zeros(10), 30, steering.KEYS) == 0


def test_the_filter_is_that_of_scipy() -> None:
    # scipy 1.17: filtfilt(*butter(2, 0.6, fs=50), x)[[0, 7, 19]]
    values = np.sin(np.arange(20.0)) + 0.1 * np.arange(20.0)
    found = steering.low_pass(values, 0.6, 50.0)
    assert found[[0, 7, 19]] == pytest.approx(
        [-0.02535180202129293, 0.36067657560040156, 0.7723081288193402]
    )


@given(
    arrays.arrays(float, st.integers(10, 60), elements=st.integers(-9, 9).map(float)),
    st.integers(-5, 5),
)
def test_the_filter_is_linear_and_has_no_direction(values, more: int) -> None:
    here = steering.low_pass(values, 2.0, 50.0)
    assert steering.low_pass(3 * values + more, 2.0, 50.0) == pytest.approx(
        3 * here + more, abs=1e-6
    )
    count = steering.reversals(values, 2)
    assert steering.reversals(-values, 2) == count
    assert steering.reversals(values + more, 2) == count
    assert count <= len(values)


def test_what_cannot_be_filtered() -> None:
    for values, cut in ((np.zeros(9), 1.0), (np.full(20, math.nan), 1.0), (np.zeros(20), 25.0)):
        with pytest.raises(DataError, match=r"filter|cut-off"):
            steering.low_pass(values, cut, 50.0)


def test_signals_are_held() -> None:
    assert steering.held([1, 2, 3.5], [5, -5, 0], 4, 2).tolist() == [0, 0, 5, 5, -5, -5, -5, 0, 0]
    assert steering.held([], [], 1, 2).tolist() == [0, 0, 0]
    assert steering.held([-3], [2], 1, 1).tolist() == [2, 2]
    with pytest.raises(DataError, match="ascending"):
        steering.held([1, 0], [1, 2], 3, 1)


def test_motion_to_photon() -> None:
    # Inputs at 1 and 9 s; frames taken before the answer at 1.1 s and after it.
    found = motion_to_photon([1.0, 9.0], [1.1, 9.1], [1.05, 1.12], [1.20, 1.27])
    assert found[0] == pytest.approx(0.27)
    assert math.isnan(found[1])
    # A frame that was taken early and shown late does not count.
    late = motion_to_photon([1.0], [1.1], [1.12, 1.05, 1.13], [1.4, 1.3, 1.35])
    assert late[0] == pytest.approx(0.35)
    assert np.isnan(motion_to_photon([1.0], [math.nan], [2.0], [2.1])).all()
    assert motion_to_photon([], [], [], []).size == 0
    with pytest.raises(DataError, match="answer"):
        motion_to_photon([1.0], [], [], [])


def bearing(answer: float | None, truth: float, tolerance: float = 30.0) -> Query:
    return Query(level=1, kind=AnswerKind.BEARING, answer=answer, truth=truth, tolerance=tolerance)


@for_each(
    ("query", "right"),
    [
        (bearing(-170, 175), True),
        (bearing(0, 31), False),
        (bearing(0, 30), True),
        (bearing(725, 5, 0), True),
        (bearing(None, 5), False),
        (Query(level=1, kind=AnswerKind.PLACE, answer=(1, 2), truth=(1, 3), tolerance=1), True),
        (Query(level=1, kind=AnswerKind.PLACE, answer=(1, 2), truth=(2, 3), tolerance=1), False),
        (Query(level=2, kind=AnswerKind.NUMBER, answer=3, truth=3), True),
        (Query(level=2, kind=AnswerKind.NUMBER, answer=3, truth=4), False),
        (Query(level=3, kind=AnswerKind.CHOICE, answer="yes", truth="yes"), True),
        (Query(level=3, kind=AnswerKind.CHOICE, answer="yes", truth="no"), False),
    ],
)
def test_answers(query: Query, right) -> None:
    assert query.right == right


def test_awareness() -> None:
    asked = [bearing(0, 0), bearing(90, 0), bearing(None, 0), bearing(10, 0)]
    found = awareness(asked, 1)
    assert (found.value, found.n, found.note) == (0.5, 4, "1 without an answer")
    assert found.low < 0.5 < found.high
    assert not awareness(asked, 2).known
    wrong = Query(level=1, kind=AnswerKind.CHOICE, answer=3, truth="yes")
    with pytest.raises(DataError, match="choice"):
        awareness([wrong], 1)


def test_tlx() -> None:
    assert questionnaires.raw_tlx(RATINGS) == 50
    assert questionnaires.weighted_tlx(RATINGS, CHOICES) == pytest.approx(73.3333, abs=1e-4)
    equal = dict.fromkeys(questionnaires.TLX_SCALES, 50)
    assert questionnaires.weighted_tlx(equal, CHOICES) == 50


@for_each(
    "choices",
    [
        CHOICES[:-1],
        ["mental"] * 6 + CHOICES[6:],
        [*CHOICES[:-1], "mood"],
        CHOICES[:9] + ["mental"] * 6,
    ],
)
def test_choices_that_are_not_one_of_each_pair(choices) -> None:
    with pytest.raises(DataError, match="each pair"):
        questionnaires.weighted_tlx(RATINGS, choices)


@for_each("rating", [52, -5, 105, math.nan])
def test_ratings_between_marks_are_refused(rating: float) -> None:
    with pytest.raises(DataError, match="steps of 5"):
        questionnaires.raw_tlx({**RATINGS, "mental": rating})
    with pytest.raises(DataError, match="scales"):
        questionnaires.raw_tlx({"mental": 50})


def test_sus() -> None:
    assert questionnaires.sus([4, 1, 5, 2, 5, 1, 4, 2, 3, 1]) == 85
    assert questionnaires.sus([3] * 10) == 50
    assert questionnaires.sus([5, 1] * 5) == 100
    assert questionnaires.sus([1, 5] * 5) == 0
    assert questionnaires.sus([None, 1] + [5, 1] * 4) == 95
    assert questionnaires.sus([None] * 3 + [3] * 7) == 50
    assert math.isnan(questionnaires.sus([None] * 4 + [3] * 6))
    with pytest.raises(DataError, match="item 1 of SUS"):
        questionnaires.sus([0] + [3] * 9)
    with pytest.raises(DataError, match="10 items"):
        questionnaires.sus([3] * 9)


def test_sart() -> None:
    assert questionnaires.sart([4] * 10) == 16
    assert questionnaires.sart([7] * 3 + [1] * 7) == -14
    assert questionnaires.sart([1] * 3 + [7] * 7) == 46
    assert math.isnan(questionnaires.sart([None] + [4] * 9))
    with pytest.raises(DataError, match="item 10 of SART"):
        questionnaires.sart([4] * 9 + [8])
