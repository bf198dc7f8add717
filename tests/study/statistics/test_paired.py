"""Paired effects, sign flips, ranks, means and several tests at once."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.errors import DataError
from rune_study.statistics.holm import holm
from rune_study.statistics.means import mean, share
from rune_study.statistics.paired import paired_effect
from rune_study.statistics.ranks import friedman, hodges_lehmann
from rune_study.statistics.sign_flips import sign_flips
from tests.support.cases import for_each

A = [62, 55, 71, 48, 66, 59, 73, 51]
B = [55, 50, 60, 49, 58, 50, 66, 47]
FIRST_BASE = np.fromstring(
    "5.40 5.50 5.55 5.85 5.70 5.75 5.20 5.60 5.50 5.55 5.50 5.40 5.90 5.85 5.70 5.45 5.55 5.60 "
    "5.40 5.40 5.35 5.45 5.50 5.35 5.25 5.15 5.00 5.85 5.80 5.70 5.25 5.20 5.10 5.65 5.55 5.45 "
    "5.60 5.35 5.45 5.05 5.00 4.95 5.50 5.50 5.40 5.45 5.55 5.50 5.55 5.55 5.35 5.45 5.50 5.55 "
    "5.50 5.45 5.25 5.65 5.60 5.40 5.70 5.65 5.55 6.30 6.30 6.25",
    sep=" ",
)
"""Times of 22 players by three ways to run (M. Hollander, D. A. Wolfe, 1973, page 140)."""
NUMBERS = st.lists(st.integers(-20, 20), min_size=1, max_size=9)


def test_paired_numbers() -> None:
    found = paired_effect(A, B)
    assert found.t == pytest.approx(4.8369124, abs=1e-7)
    assert (found.df, found.n, found.left_out, found.why) == (7, 8, (), "")
    assert found.p == pytest.approx(0.00188443, rel=1e-5)
    assert found.flips.p == 4 / 256
    assert found.flips.exact
    assert found.mean.value == 6.25
    assert found.dz == pytest.approx(4.8369124 / math.sqrt(8), abs=1e-7)
    half = 2.364624251592784 * 6.25 / 4.8369124
    assert (found.mean.low, found.mean.high) == pytest.approx((6.25 - half, 6.25 + half))


def test_incomplete_pairs_are_named() -> None:
    found = paired_effect([*A, math.nan, 3], [*B, 2, math.nan])
    assert (found.n, found.left_out) == (8, (8, 9))
    assert found.t == paired_effect(A, B).t


@for_each(
    ("first", "second", "why"),
    [
        ([], [], "two complete pairs"),
        ([1], [2], "two complete pairs"),
        ([1, 2], [math.nan, 1], "two complete pairs"),
        ([3, 4, 5], [1, 2, 3], "all differences are equal"),
        ([0.3, 0.4], [0.1, 0.2], "all differences are equal"),
        ([10.1, 5.1, 20.1], [10, 5, 20], "all differences are equal"),
        ([1, 1], [1, 1], "all differences are equal"),
    ],
)
def test_no_t_has_a_reason(first, second, why: str) -> None:
    found = paired_effect(first, second)
    assert why in found.why
    assert all(map(math.isnan, (found.t, found.dz, found.p)))


def test_pairs_need_equal_lengths() -> None:
    with pytest.raises(DataError, match="equally many"):
        paired_effect([1, 2], [1])
    with pytest.raises(DataError, match="infinite"):
        paired_effect([1, math.inf], [1, 2])


@given(NUMBERS)
def test_flips_are_all_signs(differences: list[int]) -> None:
    signs = itertools.product((-1, 1), repeat=len(differences))
    sums = [abs(sum(a * b for a, b in zip(differences, sign, strict=True))) for sign in signs]
    wanted = sum(each >= abs(sum(differences)) for each in sums) / len(sums)
    assert sign_flips(differences).p == wanted


def test_many_flips_are_drawn_from_a_seed() -> None:
    differences = np.arange(-9.0, 21.0)
    exact = sign_flips(differences[:18], most_exact=18).p
    drawn = sign_flips(differences[:18], most_exact=5)
    assert not drawn.exact
    assert drawn.p == pytest.approx(exact, abs=0.01)
    assert sign_flips(differences) == sign_flips(differences, seed=1)
    assert sign_flips(np.ones(40)).p == 1 / 100_001
    assert math.isnan(sign_flips([]).p)
    assert sign_flips([0.1, 0.2, -0.3]).p == 1.0  # the sum is 0 but for rounding


def test_hodges_lehmann_is_that_of_r() -> None:
    # R: wilcox.test(x, conf.int = TRUE), x <- c(1.83, .5, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.3)
    #    - c(.878, .647, .598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29): Hollander & Wolfe, table 3.1.
    before = [1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30]
    after = [0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29]
    found = hodges_lehmann(np.subtract(before, after))
    assert (found.value, found.low, found.high) == pytest.approx((0.46, 0.01, 0.786))


@for_each("n", [1, 2, 3, 4, 5])
def test_few_differences_have_no_interval_of_ranks(n: int) -> None:
    found = hodges_lehmann(range(n))
    assert (found.low, found.high) == (-math.inf, math.inf)


def test_many_differences_have_an_interval_by_the_normal_approximation() -> None:
    differences = np.random.default_rng(4).normal(0.1, 1.0, 1001)
    exact, near = hodges_lehmann(differences[:1000]), hodges_lehmann(differences)
    assert (near.low, near.high) == pytest.approx((exact.low, exact.high), abs=0.003)


def test_six_differences_have_the_whole_range_of_pair_means() -> None:
    found = hodges_lehmann([1, 2, 4, 8, 16, 32])
    assert (found.low, found.high) == (1, 32)
    assert hodges_lehmann([]).why


@given(NUMBERS, st.integers(-50, 50))
def test_hodges_lehmann_moves_with_the_numbers(differences: list[int], more: int) -> None:
    here, there = hodges_lehmann(differences), hodges_lehmann([each + more for each in differences])
    assert there.value == here.value + more
    assert there.low == here.low + more
    assert here.low <= here.value <= here.high


def test_friedman_numbers() -> None:
    # R's example of friedman.test.
    times = FIRST_BASE.reshape(22, 3)
    found = friedman(times)
    assert (found.square, found.df) == (pytest.approx(11.142857, abs=1e-6), 2)
    assert found.p == pytest.approx(0.003805, abs=5e-7)
    assert found.concordance == pytest.approx(11.142857 / 44, abs=1e-6)


@for_each("rows", [np.empty((0, 3)), [[1, 1, 1], [2, 2, 2]], [[math.nan, 1, 2]], [[1], [2]]])
def test_friedman_without_ranks(rows) -> None:
    found = friedman(rows)
    assert found.why
    assert math.isnan(found.p)


def test_friedman_leaves_out_incomplete_participants() -> None:
    rows = [[1, 2, 3], [2, math.nan, 1], [1, 3, 2]]
    assert friedman(rows).left_out == (1,)
    assert friedman(rows).square == friedman([rows[0], rows[2]]).square


@for_each(
    ("given_values", "adjusted"),
    [
        ([0.01, 0.04, 0.03], [0.03, 0.06, 0.06]),
        ([0.5, 0.6], [1.0, 1.0]),
        ([], []),
        ([0.02], [0.02]),
        ([0.01, math.nan, 0.03], [0.02, math.nan, 0.03]),
        ([0.0, 1.0], [0.0, 1.0]),
    ],
)
def test_holm(given_values: list[float], adjusted: list[float]) -> None:
    assert holm(given_values).tolist() == pytest.approx(adjusted, nan_ok=True)


def test_holm_takes_p_values_only() -> None:
    with pytest.raises(DataError, match="between 0 and 1"):
        holm([0.1, 1.2])


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12))
def test_holm_raises_and_keeps_the_order(p_values: list[float]) -> None:
    adjusted = holm(p_values)
    assert (adjusted >= p_values).all()
    assert (adjusted <= np.minimum(1.0, np.multiply(p_values, len(p_values)))).all()
    order = np.argsort(p_values)
    assert (np.diff(adjusted[order]) >= 0.0).all()


def test_means() -> None:
    found = mean([1, 2, 3, math.nan])
    half = 4.302652729911275 / math.sqrt(3)
    assert (found.value, found.low, found.high, found.n) == pytest.approx(
        (2, 2 - half, 2 + half, 3)
    )
    assert mean([5]).value == 5
    assert not mean([5]).has_interval
    assert not mean([]).known
    with pytest.raises(DataError, match="infinite"):
        mean([1, math.inf])


def test_shares() -> None:
    found = share(7, 10)  # statsmodels 0.15: proportion_confint(7, 10, method="wilson")
    assert (found.low, found.high) == pytest.approx((0.3967781474, 0.8922087326), abs=1e-10)
    assert (share(0, 5).low, share(5, 5).high) == (0.0, 1.0)
    assert not share(0, 0).known
    with pytest.raises(DataError, match="6 of 5"):
        share(6, 5)
