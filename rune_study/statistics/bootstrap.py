"""Intervals of any statistic, by drawing participants with replacement."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
import numpy.typing as npt

from rune_study.errors import DataError
from rune_study.estimate import LEVEL, Estimate, unknown
from rune_study.statistics.arrays import Floats, complete_cases, floats
from rune_study.statistics.distributions import normal_quantile, normal_tails, upper_share

SAMPLES = 9999


def bootstrap(
    values: npt.ArrayLike,
    statistic: Callable[[Floats], float],
    *,
    method: Literal["bca", "percentile"] = "bca",
    level: float = LEVEL,
    samples: int = SAMPLES,
    seed: int = 1,
) -> Estimate:
    """A statistic with the interval of B. Efron's bootstrap.

    "percentile" takes quantiles of the statistic over the samples. "bca" shifts them for bias and
    for an error that grows with the value (J. Am. Statist. Assoc. 82, 1987).

    Args:
        values: One row for each participant. Rows with NaN are left out.
        statistic: Of such an array.
        method: How the ends of the interval are chosen.
        level: Confidence level.
        samples: Number of draws.
        seed: Of the draws: the same seed gives the same interval.

    Raises:
        DataError: A value is infinite or no number, there is no axis of participants, or a method,
            level or number of samples is none.
    """
    given = floats(values, "values", None)
    if given.ndim == 0 or samples < 1:
        text = "a bootstrap needs a row for each participant and at least one sample"
        raise DataError(text)
    if method not in ("bca", "percentile"):
        text = f"a bootstrap's interval is by 'bca' or 'percentile', not by {method!r}"
        raise DataError(text)
    upper = upper_share(level)
    whole, _ = complete_cases(given)
    n = len(whole)
    if n == 0:
        return unknown("no participant is complete")
    value = float(statistic(whole))
    if math.isnan(value):
        return unknown("the statistic of the data is NaN", n)
    if n == 1:
        return Estimate(value=value, n=1, note="one participant has no interval")
    random = np.random.default_rng(seed)
    drawn = np.array([statistic(whole[random.integers(0, n, n)]) for _ in range(samples)], float)
    finite = drawn[np.isfinite(drawn)]
    if not finite.size:
        return Estimate(value=value, n=n, note="no sample has a finite value")
    tails, notes = (1.0 - upper, upper), []
    if method == "bca":
        left_one_out = [statistic(np.delete(whole, row, axis=0)) for row in range(n)]
        corrected = _corrected(tails, value, finite, np.array(left_one_out, float))
        tails = corrected or tails
        notes += [] if corrected else ["by percentiles, since bias or acceleration is not known"]
    low, high = np.quantile(finite, tails).tolist()
    lost = len(drawn) - len(finite)
    notes += [f"{lost} of {samples} samples have no finite value"] if lost else []
    notes += ["all samples are equal, so the interval says nothing"] if low == high else []
    return Estimate(value=value, low=low, high=high, n=n, note="; ".join(notes))


def _corrected(
    tails: tuple[float, float], value: float, drawn: Floats, left_one_out: Floats
) -> tuple[float, float] | None:
    """The shares to cut off, corrected for bias and acceleration; None: one is not known."""
    below = (np.count_nonzero(drawn < value) + np.count_nonzero(drawn <= value)) / (2 * len(drawn))
    if not 0.0 < below < 1.0 or not np.isfinite(left_one_out).all():
        return None
    away = left_one_out.mean() - left_one_out
    squares = float((away**2).sum())
    if squares <= 0.0:
        return None
    bias = normal_quantile(below)
    speed = float((away**3).sum()) / (6.0 * squares**1.5)

    def shifted(share: float) -> float:
        z = bias + normal_quantile(share)
        return _normal_share(bias + z / (1.0 - speed * z))

    return shifted(tails[0]), shifted(tails[1])


def _normal_share(z: float) -> float:
    half = 0.5 * normal_tails(z)
    return half if z < 0.0 else 1.0 - half
