"""A mean and a share, each with its interval."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rune_study.errors import DataError
from rune_study.estimate import LEVEL, Estimate, unknown
from rune_study.statistics.arrays import complete_cases, floats
from rune_study.statistics.distributions import normal_quantile, t_quantile


def mean(values: npt.ArrayLike, level: float = LEVEL) -> Estimate:
    """Arithmetic mean with Student's interval; a single value has no interval.

    Args:
        values: Numbers; NaN are left out.
        level: Confidence level.

    Raises:
        DataError: A value is infinite or no number.
    """
    whole, _ = complete_cases(floats(values, "values"))
    if not whole.size:
        return unknown("there is no value")
    middle = float(whole.mean())
    if whole.size == 1:
        return Estimate(value=middle, n=1)
    error = float(whole.std(ddof=1)) / math.sqrt(whole.size)
    half = t_quantile(0.5 + 0.5 * level, whole.size - 1) * error
    return Estimate(value=middle, low=middle - half, high=middle + half, n=whole.size)


def share(hits: int, n: int, level: float = LEVEL) -> Estimate:
    """A share with E. Wilson's score interval (J. Am. Statist. Assoc. 22, 1927).

    Args:
        hits: How often it happened.
        n: How often it could happen.
        level: Confidence level.

    Raises:
        DataError: There are more hits than chances.
    """
    if not 0 <= hits <= n:
        text = f"a share of {hits} of {n} is none"
        raise DataError(text)
    if n == 0:
        return unknown("it could not happen")
    z = normal_quantile(0.5 + 0.5 * level)
    found, square = hits / n, z * z / n
    middle = (found + 0.5 * square) / (1.0 + square)
    half = z / (1.0 + square) * math.sqrt(found * (1.0 - found) / n + 0.25 * square / n)
    low, high = max(0.0, middle - half), min(1.0, middle + half)
    return Estimate(
        value=found, low=0.0 if hits == 0 else low, high=1.0 if hits == n else high, n=n
    )


def step_mean(times: npt.ArrayLike, values: npt.ArrayLike, until: float) -> float:
    """Time-weighted mean of a step function; NaN without any duration.

    Args:
        times: When each value begins [s], ascending.
        values: Each holds up to the next time, the last up to `until`.
        until: End [s].

    Raises:
        DataError: The lengths differ, or times do not ascend.
    """
    t, v = floats(times, "times"), floats(values, "values")
    widths = np.diff(np.append(t, until))
    if len(t) != len(v) or (widths < 0.0).any():
        text = "a step function needs one ascending time for each value, all before its end"
        raise DataError(text)
    total = float(widths.sum())
    return float(v @ widths) / total if total > 0.0 else math.nan
