"""A mean and a share, each with its interval."""

from __future__ import annotations

import math

import numpy.typing as npt

from rune_study.errors import DataError
from rune_study.estimate import LEVEL, Estimate, unknown
from rune_study.statistics.arrays import complete_cases, floats
from rune_study.statistics.distributions import normal_quantile, t_quantile, upper_share


def mean(values: npt.ArrayLike, level: float = LEVEL) -> Estimate:
    """Arithmetic mean with Student's interval; a single value has no interval.

    Args:
        values: Numbers; NaN are left out.
        level: Confidence level.

    Raises:
        DataError: A value is infinite or no number, or the level is not between 0 and 1.
    """
    upper = upper_share(level)
    whole, _ = complete_cases(floats(values, "values"))
    if not whole.size:
        return unknown("there is no value")
    middle = float(whole.mean())
    if whole.size == 1:
        return Estimate(value=middle, n=1, note="one value has no interval")
    error = float(whole.std(ddof=1)) / math.sqrt(whole.size)
    half = t_quantile(upper, whole.size - 1) * error
    return Estimate(value=middle, low=middle - half, high=middle + half, n=whole.size)


def share(hits: int, n: int, level: float = LEVEL) -> Estimate:
    """A share with E. Wilson's score interval (J. Am. Statist. Assoc. 22, 1927).

    Args:
        hits: How often it happened.
        n: How often it could happen.
        level: Confidence level.

    Raises:
        DataError: There are more hits than chances, or the level is not between 0 and 1.
    """
    upper = upper_share(level)
    if not 0 <= hits <= n:
        text = f"a share of {hits} of {n} is none"
        raise DataError(text)
    if n == 0:
        return unknown("it could not happen")
    z = normal_quantile(upper)
    found, square = hits / n, z * z / n
    middle = (found + 0.5 * square) / (1.0 + square)
    half = z / (1.0 + square) * math.sqrt(found * (1.0 - found) / n + 0.25 * square / n)
    low, high = max(0.0, middle - half), min(1.0, middle + half)
    return Estimate(
        value=found, low=0.0 if hits == 0 else low, high=1.0 if hits == n else high, n=n
    )
