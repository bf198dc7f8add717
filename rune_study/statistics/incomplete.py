"""The regularized incomplete beta and gamma functions.

Continued fractions by W. Lentz's method and the power series (Numerical Recipes, 3rd edition,
6.2 and 6.4). The factor before them is the density of a distribution. C. Loader's form of it
(Fast and Accurate Computation of Binomial Probabilities, 2000) keeps its digits at thousands of
degrees of freedom. Differences of `lgamma` lose them.
"""

from __future__ import annotations

import math

_MOST_TERMS = 100_000
_LEAST = 1e-300
_ENOUGH = 1e-16
_HALF_LOG_TAU = 0.5 * math.log(math.tau)
_STIRLING = (1 / 12, -1 / 360, 1 / 1260, -1 / 1680, 1 / 1188, -691 / 360360, 1 / 156)


def beta_share(a: float, b: float, x: float, rest: float) -> float:
    """The regularized incomplete beta function I_x(a, b).

    Args:
        a: First shape, finite and above 0.
        b: Second shape, the same.
        x: From 0 to 1.
        rest: 1 - x; given apart, since subtraction loses digits.
    """
    if x <= 0.0:
        return 0.0
    if rest <= 0.0:
        return 1.0
    if x > (a + 1.0) / (a + b + 2.0):
        return 1.0 - beta_share(b, a, rest, x)
    return math.exp(_log_beta_density(a, b, x, rest)) * _beta_fraction(a, b, x) / a


def gamma_tail(a: float, x: float) -> float:
    """The regularized upper incomplete gamma function Q(a, x).

    Args:
        a: Shape, finite and above 0.
        x: From 0 on.
    """
    if x <= 0.0:
        return 1.0
    if x == math.inf:
        return 0.0
    density = math.exp(_log_gamma_density(a, x))
    return 1.0 - density * _gamma_series(a, x) if x < a + 1.0 else density * _gamma_fraction(a, x)


def _log_beta_density(a: float, b: float, x: float, rest: float) -> float:
    """log(x^a (1-x)^b / B(a, b))."""
    total = a + b
    above = x - a / total if x < rest else b / total - rest  # the smaller ones keep more digits
    return (
        a * _log_ratio(x, a / total, above)
        + b * _log_ratio(rest, b / total, -above)
        + 0.5 * math.log(a * (b / total))
        - _HALF_LOG_TAU
        + _excess(total)
        - _excess(a)
        - _excess(b)
    )


def _log_gamma_density(a: float, x: float) -> float:
    """log(x^a exp(-x) / Gamma(a))."""
    above = (x - a) / a
    exponent = math.log1p(above) - above if abs(above) < 0.5 else math.log(x / a) - above
    return a * exponent + 0.5 * math.log(a) - _HALF_LOG_TAU - _excess(a)


def _log_ratio(x: float, mean: float, above: float) -> float:
    """log(x / mean) of a number that lies by `above` above the mean."""
    return math.log1p(above / mean) if abs(above) < 0.5 * mean else math.log(x / mean)


def _excess(a: float) -> float:
    """log(Gamma(a)) less Stirling's approximation (a - 1/2) log(a) - a + log(2 pi) / 2."""
    if a < 15.0:
        return math.lgamma(a) - (a - 0.5) * math.log(a) + a - _HALF_LOG_TAU
    return math.fsum(factor / a ** (2 * place + 1) for place, factor in enumerate(_STIRLING))


def _beta_fraction(a: float, b: float, x: float) -> float:
    fraction, upper, lower = 1.0, 1.0, 0.0
    for term in range(1, _MOST_TERMS):
        half = term // 2
        if term == 1:
            factor = 1.0
        elif term % 2:
            factor = half * (b - half) * x / ((a + 2 * half - 1) * (a + 2 * half))
        else:
            half -= 1
            factor = -(a + half) * (a + b + half) * x / ((a + 2 * half) * (a + 2 * half + 1))
        lower = 1.0 / _not_zero(1.0 + factor * lower)
        upper = _not_zero(1.0 + factor / upper)
        change = upper * lower
        fraction *= change
        if term > 1 and abs(change - 1.0) < _ENOUGH:
            break
    return fraction - 1.0


def _gamma_series(a: float, x: float) -> float:
    total = part = 1.0 / a
    for term in range(1, _MOST_TERMS):
        part *= x / (a + term)
        total += part
        if part < total * _ENOUGH:
            break
    return total


def _gamma_fraction(a: float, x: float) -> float:
    middle = x + 1.0 - a
    upper, lower = 1.0 / _LEAST, 1.0 / _not_zero(middle)
    fraction = lower
    for term in range(1, _MOST_TERMS):
        factor = -term * (term - a)
        middle += 2.0
        lower = 1.0 / _not_zero(factor * lower + middle)
        upper = _not_zero(middle + factor / upper)
        change = upper * lower
        fraction *= change
        if abs(change - 1.0) < _ENOUGH:
            break
    return fraction


def _not_zero(value: float) -> float:
    return value if abs(value) > _LEAST else _LEAST
