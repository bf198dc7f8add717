"""Published data with their results, beside R, lifelines, scipy and pingouin."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rune_study.errors import DataError
from rune_study.statistics.bootstrap import bootstrap
from rune_study.statistics.log_rank import log_rank
from rune_study.statistics.means import mean, share
from rune_study.statistics.paired import paired_effect
from rune_study.statistics.ranks import average_ranks, friedman, hodges_lehmann
from rune_study.statistics.repeated_measures import rm_anova
from rune_study.statistics.sign_flips import sign_flips
from rune_study.statistics.survival import kaplan_meier, restricted_mean_estimate
from tests.support.cases import for_each

SLEEP = (
    [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0],
    [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4],
)
"""Hours of sleep that two drugs add (Student, Biometrika 6, 1908), "sleep" of R."""
MAIZE = [49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48]
"""Crossed less self-fertilized plants [1/8 in] (C. Darwin, 1876; R. A. Fisher, 1935)."""
RECALL = np.array(
    [[10, 13, 13], [6, 8, 8], [11, 14, 14], [22, 23, 25], [16, 18, 20],
     [15, 17, 17], [1, 1, 4], [12, 15, 17], [9, 12, 12], [8, 9, 12]]
)  # fmt: skip
"""Words recalled after three exposures (G. Loftus, M. Masson, Psychon. Bull. Rev. 1, 1994)."""
RETCHING = np.array(
    [[8, 7, 1, 6], [9, 5, 2, 5], [6, 2, 3, 8], [5, 3, 1, 9],
     [8, 4, 5, 8], [7, 5, 6, 7], [10, 2, 7, 2], [12, 6, 8, 1]]
)  # fmt: skip
"""Seconds to retch after four foods (A. Field, Discovering Statistics)."""
HEADACHE = np.array(
    [[21, 22, 8, 6, 6], [20, 19, 10, 4, 4], [17, 15, 5, 4, 5], [25, 30, 13, 12, 17],
     [30, 27, 13, 8, 6], [19, 27, 8, 7, 4], [26, 16, 5, 2, 5], [17, 18, 8, 1, 5],
     [26, 24, 14, 8, 9]]
)  # fmt: skip
"""Hours of headache in five weeks of relaxation training (D. Howell, Statistical Methods)."""


def test_sleep() -> None:
    found = paired_effect(*SLEEP)
    assert (found.t, found.p) == pytest.approx((-4.062128, 0.002833), abs=5e-7)
    assert (found.mean.low, found.mean.high) == pytest.approx((-2.4598858, -0.7001142), abs=1e-7)
    assert found.flips.p == 4 / 1024  # one difference is 0: scipy's permutation_test agrees


def test_maize() -> None:
    found = paired_effect(MAIZE, np.zeros(15))
    assert (found.t, found.p) == pytest.approx((2.14799, 0.0497029), abs=5e-6)
    assert found.flips.p == 2 * 863 / 2**15  # Fisher: 863 sums are as large, or 2.634 %


def test_flips_of_signed_ranks_are_the_signed_rank_test() -> None:
    # M. Hollander, D. A. Wolfe, 1973, table 3.1; R: wilcox.test(x, y, paired = TRUE), V = 40.
    before = [1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30]
    after = [0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29]
    away = np.subtract(before, after)
    assert sign_flips(np.sign(away) * average_ranks(np.abs(away))).p == pytest.approx(0.0390625)


@for_each(
    ("values", "f", "epsilon", "p"),
    [
        (RECALL, 42.506024, 0.844965, 1.1519337e-6),
        (RETCHING, 3.793806, 0.532846, 0.0625841),
        (HEADACHE, 85.041667, 0.684457, 5.772868e-12),
    ],
)
def test_repeated_measures(values, f: float, epsilon: float, p: float) -> None:
    (found,) = rm_anova(values).effects
    assert (found.f, found.epsilon) == pytest.approx((f, epsilon), abs=1e-6)
    assert found.p_corrected == pytest.approx(p, rel=1e-5)


@for_each("level", [0.0, 1.0, 95, -0.5, math.nan])
def test_a_level_of_confidence_is_a_share(level: float) -> None:
    for interval in (
        lambda: mean([1, 2, 3], level),
        lambda: share(1, 3, level),
        lambda: hodges_lehmann([1, 2, 3], level),
        lambda: kaplan_meier([1, 2], [1, 1], level),
        lambda: bootstrap([1, 2, 3], lambda x: float(x.mean()), level=level),
    ):
        with pytest.raises(DataError, match=r"confidence level lies between 0 and 1"):
            interval()


@for_each(
    ("call", "what"),
    [
        (lambda: bootstrap(["a"], len), "not all numbers"),
        (lambda: bootstrap([1, 2], len, method="bcaa"), "not by 'bcaa'"),  # type: ignore[arg-type]
        (lambda: rm_anova([[1, 2], [3]]), "not all numbers"),
        (lambda: rm_anova([[1e200, 2e200], [3e200, 1e200]]), "beyond 1e"),
        (lambda: sign_flips(range(30), samples=0), "at least one sample"),
        (lambda: log_rank([1, 2], [1, 1], ["a", None]), "label .* is missing"),
        (lambda: log_rank([1, 2], [1, 1], [0, math.nan]), "label .* is missing"),
        (lambda: log_rank([1, 2], [1, 1], [0, 1], [None, "p"]), "label .* is missing"),
    ],
)
def test_what_cannot_be_used_is_refused_in_a_sentence(call, what: str) -> None:
    with pytest.raises(DataError, match=what):
        call()


def test_an_interval_that_says_nothing_says_so() -> None:
    assert "few" in hodges_lehmann([1, 2, 3]).note
    assert mean(np.ma.masked_array([4.0, 9.0, 6.0], [0, 1, 0])).value == 5.0
    assert "one value" in mean([4.0]).note
    assert "equal" in bootstrap([0.0] * 20, lambda x: float(x.mean()), samples=99).note
    assert "two conditions" in friedman(np.ones((5, 0))).why
    assert bootstrap([1.0, 2.0], lambda _: math.nan, samples=9).why == (
        "the statistic of the data is NaN"
    )


def test_a_restricted_mean_beyond_the_last_observation_says_so() -> None:
    curve = kaplan_meier([5, 8, 20], [1, 1, 0])
    assert restricted_mean_estimate(curve, 20).note == "restricted to 20 s"
    beyond = restricted_mean_estimate(curve, 30).note
    assert beyond == "restricted to 30 s, but nothing is known beyond 20 s"
    ended = kaplan_meier([5, 8, 20], [1, 1, 1])
    assert restricted_mean_estimate(ended, 30).note == "restricted to 30 s"


def test_ranks_of_many_differences_are_those_of_all_pairs() -> None:
    differences = np.random.default_rng(4).integers(-30, 30, 1201) / 8.0
    first, second = np.triu_indices(1201)
    means = np.sort(0.5 * (differences[first] + differences[second]))
    found = hodges_lehmann(differences)
    assert found.value == pytest.approx(float(np.median(means)), abs=1e-12)
    assert np.isclose(means, found.low).any()
    assert np.isclose(means, found.high).any()
