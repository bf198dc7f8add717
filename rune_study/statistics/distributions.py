"""p-values and quantiles of the normal, t, F and chi-square distributions."""

from __future__ import annotations

import functools
import math
from statistics import NormalDist

from rune_study.errors import DataError
from rune_study.statistics.incomplete import beta_share, gamma_tail


def normal_tails(z: float) -> float:
    """P(|Z| >= |z|) of the standard normal distribution."""
    return math.erfc(abs(z) / math.sqrt(2.0))


def normal_quantile(share: float) -> float:
    """The number below which this share, between 0 and 1, of the standard normal lies.

    Raises:
        DataError: The share is not between 0 and 1.
    """
    _check_share(share)
    return NormalDist().inv_cdf(share)


def upper_share(level: float) -> float:
    """The share below the upper end of a two-sided interval: 0.975 for a level of 0.95.

    Raises:
        DataError: The confidence level is not between 0 and 1.
    """
    if not 0.0 < level < 1.0:
        text = f"a confidence level lies between 0 and 1, such as 0.95, and is not {level:g}"
        raise DataError(text)
    return 0.5 + 0.5 * level


def t_tails(t: float, df: float) -> float:
    """P(|T| >= |t|) of Student's distribution.

    Args:
        t: The statistic; NaN gives NaN.
        df: Degrees of freedom, above 0, whole or not.

    Raises:
        DataError: `df` is not a finite number above 0.
    """
    _check_df(df)
    if math.isnan(t):
        return math.nan
    square = t * t
    if square == math.inf:
        return 0.0
    return beta_share(0.5 * df, 0.5, df / (df + square), square / (df + square))


@functools.lru_cache(maxsize=1024)
def t_quantile(share: float, df: float) -> float:
    """The number below which this share, between 0 and 1, of Student's distribution lies.

    Raises:
        DataError: The share is not between 0 and 1, or `df` not a finite number above 0.
    """
    _check_share(share)
    _check_df(df)
    tails = 2.0 * min(share, 1.0 - share)
    low, high = 0.0, 1.0
    while t_tails(high, df) > tails:
        low, high = high, 2.0 * high
    while high - low > 1e-15 * high:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if t_tails(middle, df) > tails else (low, middle)
    return math.copysign(high, share - 0.5) if tails < 1.0 else 0.0


def f_tail(f: float, df1: float, df2: float) -> float:
    """P(F >= f) of Fisher's distribution.

    Args:
        f: The statistic; NaN gives NaN.
        df1: Degrees of freedom of the numerator, above 0, whole or not.
        df2: The same of the denominator.

    Raises:
        DataError: Degrees of freedom are not finite numbers above 0.
    """
    _check_df(df1, df2)
    if math.isnan(f):
        return math.nan
    if f <= 0.0:
        return 1.0
    if f == math.inf:
        return 0.0
    whole = df2 + df1 * f
    return beta_share(0.5 * df2, 0.5 * df1, df2 / whole, df1 * f / whole)


def chi_square_tail(square: float, df: float) -> float:
    """P(X >= square) of the chi-square distribution.

    Args:
        square: The statistic; NaN gives NaN.
        df: Degrees of freedom, above 0.

    Raises:
        DataError: `df` is not a finite number above 0.
    """
    _check_df(df)
    return math.nan if math.isnan(square) else gamma_tail(0.5 * df, 0.5 * square)


def _check_df(*numbers: float) -> None:
    for df in numbers:
        if not 0.0 < df < math.inf:
            text = f"degrees of freedom must be a finite number above 0, not {df:g}"
            raise DataError(text)


def _check_share(share: float) -> None:
    if not 0.0 < share < 1.0:
        text = f"a quantile needs a share between 0 and 1, not {share:g}"
        raise DataError(text)
