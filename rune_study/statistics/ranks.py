"""Ranks: Friedman's test, and the Hodges-Lehmann estimate with its exact interval."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.estimate import LEVEL, Estimate, unknown
from rune_study.statistics.arrays import Floats, complete_cases, floats
from rune_study.statistics.distributions import chi_square_tail, normal_quantile, upper_share

_MOST_EXACT = 1000
"""Most differences with an exact interval; for more it is by the normal approximation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FriedmanTest:
    """The result of Friedman's test.

    Attributes:
        square: Its statistic, corrected for ties; NaN: see `why`.
        df: Degrees of freedom: conditions less 1.
        p: From the chi-square distribution.
        concordance: Kendall's W, from 0 to 1.
        n: Complete participants.
        left_out: Rows with a missing value.
        why: Why there is no result; empty where there is one.
    """

    square: float
    df: int
    p: float
    concordance: float
    n: int
    left_out: tuple[int, ...] = ()
    why: str = ""


def friedman(values: npt.ArrayLike) -> FriedmanTest:
    """Test whether conditions differ, by the ranks within each participant.

    The statistic is that of W. J. Conover, Practical Nonparametric Statistics, 3rd edition, 5.8:
    equal values share their mean rank.

    Args:
        values: One row for each participant, one column for each condition.

    Raises:
        DataError: The array has other axes, or a value is infinite.
    """
    whole, left_out = complete_cases(floats(values, "values", 2))
    n, k = whole.shape
    spread = 0.0
    if n and k > 1:
        ranks = np.array([average_ranks(row) for row in whole])
        middle = 0.5 * (k + 1)
        spread = float(((ranks - middle) ** 2).sum())
        between = float(((ranks.sum(axis=0) - n * middle) ** 2).sum())
    if spread == 0.0:
        why = "no participant ranks one condition higher"
        if k < 2:
            why = "it needs two conditions"
        elif not n:
            why = "no participant is complete"
        return FriedmanTest(
            square=math.nan,
            df=max(k - 1, 0),
            p=math.nan,
            concordance=math.nan,
            n=n,
            left_out=left_out,
            why=why,
        )
    square = (k - 1) * between / spread
    return FriedmanTest(
        square=square,
        df=k - 1,
        p=chi_square_tail(square, k - 1),
        concordance=square / (n * (k - 1)),
        n=n,
        left_out=left_out,
    )


def average_ranks(values: Floats) -> Floats:
    """Ranks from 1; equal values share the mean of theirs."""
    _, group, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    ranks: Floats = (last - 0.5 * (counts - 1))[group]
    return ranks


def hodges_lehmann(differences: npt.ArrayLike, level: float = LEVEL) -> Estimate:
    """Median of the means of all pairs of differences, each with itself too.

    The interval is that of the signed-rank test (J. Hodges, E. Lehmann, Ann. Math. Statist. 34,
    1963). It is exact for differences without ties; with few differences it is the whole line.

    Args:
        differences: One for each participant; NaN are left out.
        level: Confidence level.

    Raises:
        DataError: A difference is infinite or no number, or the level is not between 0 and 1.
    """
    given, _ = complete_cases(floats(differences, "differences"))
    tail = 1.0 - upper_share(level)
    n = len(given)
    if n == 0:
        return unknown("there is no complete pair")
    count, cut = n * (n + 1) // 2, _signed_rank_cut(n, tail)
    ends = (cut, count + 1 - cut) if cut else ()
    middle = ((count + 1) // 2, count // 2 + 1)
    values = _pair_means(np.sort(given), (*middle, *ends))
    low, high = values[2:] if cut else (-math.inf, math.inf)
    note = "" if cut else f"too few differences ({n}) for a level of {level:g}"
    return Estimate(value=0.5 * (values[0] + values[1]), low=low, high=high, n=n, note=note)


def _pair_means(ordered: Floats, places: tuple[int, ...]) -> list[float]:
    """Means of pairs of differences, each with itself too, by their place in ascending order.

    Args:
        ordered: The differences, ascending.
        places: From 1 to n (n + 1) / 2.
    """
    n = len(ordered)
    if n <= _MOST_EXACT:
        first, second = np.triu_indices(n)
        means = np.sort(0.5 * (ordered[first] + ordered[second]))
        return [float(means[place - 1]) for place in places]
    return [_pair_mean(ordered, place) for place in places]


def _pair_mean(ordered: Floats, place: int) -> float:
    """One of them by bisection of the numbers, since all of them would need much memory."""
    before = np.arange(len(ordered))
    low, high = float(ordered[0]), float(ordered[-1])
    while low < (middle := 0.5 * (low + high)) < high:
        reached = np.searchsorted(ordered, 2.0 * middle - ordered, side="right")
        enough = np.maximum(reached - before, 0).sum() >= place
        low, high = (low, middle) if enough else (middle, high)
    return high


def _signed_rank_cut(n: int, tail: float) -> int:
    """The largest c with P(signed-rank sum < c) <= tail; 0: there is none above 0."""
    if n > _MOST_EXACT:
        middle, error = n * (n + 1) / 4, math.sqrt(n * (n + 1) * (2 * n + 1) / 24)
        return max(0, math.floor(middle + error * normal_quantile(tail) + 0.5))
    chances = np.zeros(n * (n + 1) // 2 + 1)
    chances[0] = 1.0
    for rank in range(1, n + 1):
        shifted = np.zeros_like(chances)
        shifted[rank:] = chances[:-rank]
        chances = 0.5 * (chances + shifted)
    return int(np.searchsorted(np.cumsum(chances), tail * (1.0 + 1e-12), side="right"))
