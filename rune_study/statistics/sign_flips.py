"""An exact test of a mean difference that assumes no distribution.

Without an effect, each participant's difference has either sign with the same chance. The p-value
is the share of all signs whose mean is as far from 0 as the one that was seen (R. A. Fisher, The
Design of Experiments, 1935, section 21).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.statistics.arrays import Floats, complete_cases, floats

MOST_EXACT = 20
"""Up to this number of differences all signs are tried: 1,048,576."""
SAMPLES = 100_000
"""Signs that are drawn for more differences."""

_TIE = 1e-12
"""Sums that differ less than this share of all differences are equal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlipTest:
    """The result of sign flips.

    Attributes:
        p: Two-sided p-value; NaN without a difference.
        n: Number of differences.
        exact: Whether all signs were tried.
    """

    p: float
    n: int
    exact: bool


def sign_flips(
    differences: npt.ArrayLike,
    *,
    most_exact: int = MOST_EXACT,
    samples: int = SAMPLES,
    seed: int = 1,
) -> FlipTest:
    """Test whether the mean difference is 0.

    Args:
        differences: One for each participant; NaN are left out.
        most_exact: Up to this number of differences all signs are tried.
        samples: Signs that are drawn for more. The p-value is then (hits + 1) / (samples + 1).
        seed: Of the draw.

    Raises:
        DataError: A difference is infinite or no number, or there is no sample.
    """
    if samples < 1:
        text = f"sign flips need at least one sample, not {samples}"
        raise DataError(text)
    given, _ = complete_cases(floats(differences, "differences"))
    n = len(given)
    if n == 0:
        return FlipTest(p=math.nan, n=0, exact=True)
    bound = abs(float(given.sum())) - _TIE * float(np.abs(given).sum())
    if n <= most_exact:
        return FlipTest(p=float(np.mean(np.abs(_all_sums(given)) >= bound)), n=n, exact=True)
    random = np.random.default_rng(seed)
    hits, left = 0, samples
    while left > 0:
        count = min(left, 1000)
        signs = random.integers(0, 2, (count, n)) * 2 - 1
        hits += int(np.count_nonzero(np.abs(signs @ given) >= bound))
        left -= count
    return FlipTest(p=(hits + 1) / (samples + 1), n=n, exact=False)


def _all_sums(differences: Floats) -> Floats:
    """The sums under all signs; the first sign stays, since the opposite sums are as far from 0."""
    sums = differences[:1]
    for each in differences[1:]:
        sums = np.concatenate((sums + each, sums - each))
    return sums
