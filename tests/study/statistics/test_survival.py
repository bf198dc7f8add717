"""Kaplan-Meier curves, beside numbers of lifelines 0.30.3 and of R's package survival."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.errors import DataError
from rune_study.statistics.survival import (
    Survival,
    kaplan_meier,
    restricted_mean_estimate,
)
from tests.support.cases import for_each

REMISSION = (
    [6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35],
    [1, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0],
)
"""Weeks of remission with 6-mercaptopurine (E. J. Freireich et al., Blood 21, 1963)."""
MAINTAINED = ([9, 13, 13, 18, 23, 28, 31, 34, 45, 48, 161], [1, 1, 0, 1, 1, 0, 1, 1, 0, 1, 0])
OTHERS = ([5, 5, 8, 8, 12, 16, 23, 27, 30, 33, 43, 45], [1, 1, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1])
"""Acute myelogenous leukemia (R. G. Miller, Survival Analysis, 1981), "aml" of R."""

TIMES = st.lists(st.tuples(st.integers(0, 12), st.booleans()), min_size=1, max_size=30)


def curve_of(pairs: list[tuple[float, bool]]) -> Survival:
    times, seen = zip(*pairs, strict=True)
    return kaplan_meier(times, seen)


def test_worked_by_hand() -> None:
    curve = kaplan_meier([5, 8, 8, 12, 15, 20, 20, 30], [1, 1, 0, 1, 0, 1, 1, 0])
    assert curve.times.tolist() == [5, 8, 12, 20]
    assert curve.survival == pytest.approx([0.875, 0.75, 0.6, 0.2])
    assert curve.at_risk.tolist() == [8, 7, 5, 3]
    assert curve.events.tolist() == [1, 1, 1, 2]
    assert curve.censored.tolist() == [8, 15, 30]
    assert curve.median.value == 20
    assert curve.restricted_mean(30).value == pytest.approx(17.425)
    assert [curve.at(time) for time in (0, 4.9, 5, 100)] == pytest.approx([1, 1, 0.875, 0.2])
    assert curve.seen == 5 / 8


def test_limits_are_those_of_lifelines() -> None:
    curve = kaplan_meier(*REMISSION)
    assert curve.times.tolist() == [6, 7, 10, 13, 16, 22, 23]
    wanted = [0.857142857, 0.806722689, 0.752941176, 0.690196078, 0.627450980, 0.537815126]
    assert curve.survival == pytest.approx([*wanted, 0.448179272], abs=1e-9)
    low = [0.61971796, 0.56314656, 0.50319951, 0.43161022, 0.36751086, 0.26777894, 0.18805201]
    high = [0.95155175, 0.92280902, 0.88936184, 0.84906596, 0.80491219, 0.74679072, 0.68014263]
    assert curve.low == pytest.approx(low, abs=1e-8)
    assert curve.high == pytest.approx(high, abs=1e-8)
    median = curve.median
    assert (median.value, median.low, median.high, median.n) == (23, 13, math.inf, 21)


@for_each(
    ("data", "median", "mean", "error"),
    [(MAINTAINED, 31, 52.6, 19.83), (OTHERS, 23, 22.7, 4.18)],
)
def test_restricted_means_are_those_of_r(data, median: float, mean: float, error: float) -> None:
    curve = kaplan_meier(*data)
    found = curve.restricted_mean(161)
    assert curve.median.value == median
    assert found.value == pytest.approx(mean, abs=0.05)
    assert found.standard_error == pytest.approx(error, abs=0.005)


def test_the_interval_of_a_restricted_mean_is_wider_with_few_events() -> None:
    found = kaplan_meier(*OTHERS).restricted_mean(161)  # 11 events
    half = 2.2281388519649385 * math.sqrt(11 / 10) * found.standard_error
    assert (found.low, found.high) == pytest.approx((found.value - half, found.value + half))
    for few in (kaplan_meier([3, 4], [0, 0]), kaplan_meier([7], [1]), kaplan_meier([5, 9], [1, 0])):
        alone = few.restricted_mean(9)
        assert math.isnan(alone.low)
        assert math.isnan(alone.high)


def test_the_median_is_the_first_time_with_half_left() -> None:
    assert kaplan_meier([1, 2, 3, 4], [1, 1, 1, 1]).median.value == 2
    many = kaplan_meier(range(1, 25), [1] * 24)
    assert many.survival[11] > 0.5  # the product rounds
    assert many.median.value == 12


def test_a_median_that_is_not_reached_is_infinite() -> None:
    none = kaplan_meier([3, 4], [0, 0])
    assert none.times.size == 0
    assert (none.median.value, none.median.low, none.median.high) == (math.inf,) * 3
    assert none.restricted_mean(4).value == 4
    few = kaplan_meier([1, 2, 3, 4], [1, 0, 0, 0])
    assert few.median.value == math.inf


def test_one_event_has_a_median_without_an_interval() -> None:
    alone = kaplan_meier([7], [1]).median
    assert (alone.value, alone.low, alone.high) == (7, 0, math.inf)


def test_where_all_had_their_event_the_variance_is_not_used() -> None:
    curve = kaplan_meier([1, 2, 3], [1, 1, 1])
    assert curve.survival[-1] == curve.low[-1] == curve.high[-1] == 0
    assert curve.median.high == math.inf
    assert curve.restricted_mean(3).standard_error == pytest.approx(math.sqrt(2) / 3)


def test_events_come_before_censorings_of_the_same_time() -> None:
    assert kaplan_meier([2, 2], [1, 0]).survival.tolist() == [0.5]
    assert kaplan_meier([0, 5], [1, 1]).survival.tolist() == [0.5, 0.0]


def test_an_estimate_names_its_bound() -> None:
    curve = kaplan_meier([0, 0], [1, 1])
    assert "every time is 0" in restricted_mean_estimate(curve, 0.0).why
    assert restricted_mean_estimate(curve, 60.0).note == "restricted to 60 s"


@for_each(
    ("durations", "observed", "what"),
    [
        ([], [], "at least one"),
        ([1, -1], [1, 1], "at least 0"),
        ([1, math.nan], [1, 1], "finite"),
        ([1, math.inf], [1, 1], "finite"),
        ([1, 2], [1], "each duration"),
        ([1, 2], [1, 2], "each duration"),
        ([[1]], [1], "axes"),
        (["a"], [1], "numbers"),
    ],
)
def test_what_is_no_duration(durations, observed, what: str) -> None:
    with pytest.raises(DataError, match=what):
        kaplan_meier(durations, observed)


@for_each("bound", [0.0, -1.0, math.inf, math.nan])
def test_a_restricted_mean_needs_a_bound(bound: float) -> None:
    with pytest.raises(DataError, match="bound"):
        kaplan_meier([1], [1]).restricted_mean(bound)


@given(TIMES, st.randoms())
def test_the_order_does_not_matter(pairs: list[tuple[float, bool]], chance: random.Random) -> None:
    first = curve_of(pairs)
    chance.shuffle(pairs)
    second = curve_of(pairs)
    assert np.array_equal(first.survival, second.survival)
    assert first.median == second.median


@given(TIMES)
def test_the_curve_falls_within_its_limits(pairs: list[tuple[float, bool]]) -> None:
    curve = curve_of(pairs)
    assert (np.diff(curve.survival) < 0).all()
    assert ((curve.low <= curve.survival) & (curve.survival <= curve.high)).all()
    assert ((curve.survival >= 0) & (curve.survival < 1)).all()
    median = curve.median
    assert median.low <= median.value <= median.high


@given(TIMES, st.integers(1, 50))
def test_units_do_not_matter(pairs: list[tuple[float, bool]], factor: int) -> None:
    small, large = curve_of(pairs), curve_of([(factor * time, seen) for time, seen in pairs])
    assert large.median.value == factor * small.median.value
    bound = small.restricted_mean(13.0)
    wanted = (factor * bound.value, factor * bound.standard_error)
    found = large.restricted_mean(factor * 13.0)
    assert (found.value, found.standard_error) == pytest.approx(wanted)


@given(st.lists(st.integers(1, 100), min_size=1, max_size=30))
def test_without_censoring_the_restricted_mean_is_the_mean(times: list[int]) -> None:
    curve = kaplan_meier(times, [1] * len(times))
    assert curve.restricted_mean(100.0).value == pytest.approx(np.mean(times))
    n = len(times)
    assert curve.restricted_mean(101.0).standard_error == pytest.approx(np.std(times) / n**0.5)
