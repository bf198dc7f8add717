"""Intervals by the bootstrap; the numbers are those of scipy 1.17 with the same draws."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rune_study.errors import DataError
from rune_study.statistics.bootstrap import bootstrap
from tests.support.cases import for_each

VALUES = [0.3, 1.2, 0.1, 2.5, 0.7, 4.1, 0.2, 0.9, 1.6, 0.4]


def average(values) -> float:
    return float(np.mean(values))


@for_each(
    ("method", "low", "high"), [("bca", 0.65, 2.2351848725328294), ("percentile", 0.55, 1.96)]
)
def test_numbers_are_those_of_scipy(method, low: float, high: float) -> None:
    found = bootstrap(VALUES, average, method=method, samples=999, seed=3)
    assert (found.value, found.n) == (pytest.approx(1.2), 10)
    assert (found.low, found.high) == pytest.approx((low, high), rel=1e-12)


def test_the_seed_decides() -> None:
    assert bootstrap(VALUES, average, samples=99) == bootstrap(VALUES, average, samples=99, seed=1)
    assert bootstrap(VALUES, average, samples=99) != bootstrap(VALUES, average, samples=99, seed=2)


def test_rows_are_participants() -> None:
    rows = np.column_stack((VALUES, np.array(VALUES) + 1.0))
    found = bootstrap(rows, lambda each: float((each[:, 1] - each[:, 0]).mean()), samples=99)
    assert (found.value, found.low, found.high) == pytest.approx((1.0, 1.0, 1.0))


def test_incomplete_participants_are_left_out() -> None:
    found = bootstrap([*VALUES, math.nan], average, samples=99)
    assert found == bootstrap(VALUES, average, samples=99)


def test_what_has_no_interval_says_so() -> None:
    assert not bootstrap([], average).known
    assert not bootstrap([3.0], average).has_interval
    equal = bootstrap([3.0] * 5, average, samples=99)
    assert (equal.value, equal.low, equal.high) == (3.0, 3.0, 3.0)
    with pytest.raises(DataError, match="infinite"):
        bootstrap([1.0, math.inf], average)
    with pytest.raises(DataError, match="row"):
        bootstrap(3.0, average)
