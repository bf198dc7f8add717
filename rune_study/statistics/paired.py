"""The difference of two conditions that each participant did: effects first, p-values last."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.estimate import LEVEL, Estimate
from rune_study.statistics.arrays import pairs
from rune_study.statistics.distributions import t_tails
from rune_study.statistics.means import mean
from rune_study.statistics.ranks import hodges_lehmann
from rune_study.statistics.sign_flips import FlipTest, sign_flips

_ROUNDING = 1e-14
"""Differences that vary less than this share of the values are equal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PairedEffect:
    """How the first condition differs from the second.

    Attributes:
        mean: Mean difference, with Student's interval.
        middle: Hodges-Lehmann estimate of the difference, with the interval of signed ranks.
        dz: J. Cohen's dz: mean difference over the standard deviation of differences. NaN: that is
            0, or there is one pair.
        t: Student's statistic; NaN as `dz`.
        df: Its degrees of freedom.
        p: Two-sided p-value of `t`.
        flips: Exact test of the mean difference, without a distribution.
        n: Complete pairs.
        left_out: Participants with a missing value.
        why: Why there is no `t`; empty where there is one.
    """

    mean: Estimate
    middle: Estimate
    dz: float
    t: float
    df: int
    p: float
    flips: FlipTest
    n: int
    left_out: tuple[int, ...] = ()
    why: str = ""


def paired_effect(
    first: npt.ArrayLike, second: npt.ArrayLike, *, level: float = LEVEL, seed: int = 1
) -> PairedEffect:
    """Compare two conditions within participants.

    Args:
        first: One value for each participant; NaN is missing.
        second: The same under the other condition.
        level: Confidence level of the intervals.
        seed: Of the sign flips, if there are too many to try all.

    Raises:
        DataError: The lengths differ, or a value is infinite.
    """
    whole, left_out = pairs(first, second)
    differences = whole[:, 0] - whole[:, 1]
    n = len(differences)
    spread = float(differences.std(ddof=1)) if n > 1 else 0.0
    rounding = _ROUNDING * float(np.abs(whole).max(initial=0.0))
    why = ""
    if n < 2:
        why = "it needs two complete pairs"
    elif spread <= rounding:
        why = "all differences are equal"
    dz = math.nan if why else float(differences.mean()) / spread
    t = dz * math.sqrt(n)
    return PairedEffect(
        mean=mean(differences, level),
        middle=hodges_lehmann(differences, level),
        dz=dz,
        t=t,
        df=max(n - 1, 0),
        p=math.nan if why else t_tails(t, n - 1),
        flips=sign_flips(differences, seed=seed),
        n=n,
        left_out=left_out,
        why=why,
    )
