"""Analysis of variance of conditions that every participant did, for any number of factors.

Orthonormal contrasts turn each effect into a few differences of each participant. Their mean gives
the sum of squares of the effect, their spread that of the error (R. G. O'Brien, M. K. Kaiser,
Psychol. Bull. 97, 1985). S. Greenhouse and S. Geisser's epsilon (Psychometrika 24, 1959) comes from
their covariance: F is valid for unequal covariances too.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.statistics.arrays import Floats, complete_cases, floats
from rune_study.statistics.distributions import f_tail

_NOTHING = 1e-14
"""Squares below this share of all squares are rounding errors."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WithinEffect:
    """An effect within participants.

    Attributes:
        name: The factor, or factors with " x " between.
        f: F; infinity: participants do not differ in it. NaN: see `why`.
        df1: Degrees of freedom of the effect.
        df2: Degrees of freedom of the error.
        p: p-value if all differences had the same variance.
        epsilon: Greenhouse-Geisser, from 1 / df1 to 1.
        p_corrected: p-value with both degrees of freedom times `epsilon`: the one to report.
        eta_generalized: Generalized eta squared (S. Olejnik, J. Algina, Psychol. Methods 8, 2003).
        eta_partial: Partial eta squared.
        square_effect: Sum of squares of the effect.
        square_error: Sum of squares of the error.
        why: Why there is no F; empty where there is one.
    """

    name: str
    f: float
    df1: int
    df2: int
    p: float
    epsilon: float
    p_corrected: float
    eta_generalized: float
    eta_partial: float
    square_effect: float
    square_error: float
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class WithinAnalysis:
    """An analysis of variance within participants.

    Attributes:
        effects: Factors first, then what they do together.
        n: Complete participants.
        left_out: Rows with a missing value.
        square_participants: Sum of squares between participants.
    """

    effects: tuple[WithinEffect, ...]
    n: int
    left_out: tuple[int, ...]
    square_participants: float

    def effect(self, name: str) -> WithinEffect:
        """The effect with this name.

        Raises:
            DataError: There is none.
        """
        for each in self.effects:
            if each.name == name:
                return each
        text = f"there is no effect {name!r}, only {', '.join(each.name for each in self.effects)}"
        raise DataError(text)


def rm_anova(values: npt.ArrayLike, factors: Sequence[str] = ("condition",)) -> WithinAnalysis:
    """Test each factor and each interaction within participants.

    Args:
        values: One axis for participants, then one for each factor, shape (n, levels, ...).
            Participants with a missing value are left out whole.
        factors: Name of each factor.

    Raises:
        DataError: Axes and names do not fit, a factor has one level, or a value is infinite.
    """
    given = floats(values, "values", None)
    if given.ndim != len(factors) + 1 or not factors:
        text = f"{len(factors)} factors need {len(factors) + 1} axes, but there are {given.ndim}"
        raise DataError(text)
    levels = given.shape[1:]
    if min(levels) < 2:
        text = f"each factor needs two levels, but {factors[levels.index(min(levels))]!r} does not"
        raise DataError(text)
    whole, left_out = complete_cases(given)
    n = len(whole)
    flat = whole.reshape(n, math.prod(levels))
    flat = flat - (flat.mean() if n else 0.0)  # digits of a large common offset are kept
    total = float((flat**2).sum())
    between = _spread(flat @ _contrast(levels, ())) if n else 0.0
    parts = [
        (" x ".join(factors[place] for place in chosen), flat @ _contrast(levels, chosen))
        for chosen in _combinations(len(factors))
    ]
    errors = [_spread(scores) if n else 0.0 for _, scores in parts]
    other = between + math.fsum(errors)
    effects = tuple(
        _effect(name, scores, error, other, total)
        for (name, scores), error in zip(parts, errors, strict=True)
    )
    return WithinAnalysis(effects=effects, n=n, left_out=left_out, square_participants=between)


def _combinations(count: int) -> Iterator[tuple[int, ...]]:
    for size in range(1, count + 1):
        yield from itertools.combinations(range(count), size)


def _contrast(levels: tuple[int, ...], chosen: tuple[int, ...]) -> Floats:
    """Orthonormal contrasts of an effect, shape (conditions, df of the effect)."""
    parts = [
        _helmert(count) if place in chosen else np.full((count, 1), 1.0 / math.sqrt(count))
        for place, count in enumerate(levels)
    ]
    return functools.reduce(np.kron, parts)


def _helmert(count: int) -> Floats:
    """Each level against the mean of those before, shape (count, count - 1)."""
    contrasts = np.zeros((count, count - 1))
    for place in range(1, count):
        contrasts[:place, place - 1] = 1.0
        contrasts[place, place - 1] = -float(place)
    contrasts /= np.linalg.norm(contrasts, axis=0)
    return contrasts


def _spread(scores: Floats) -> float:
    return float(((scores - scores.mean(axis=0)) ** 2).sum())


def _effect(name: str, scores: Floats, error: float, other: float, total: float) -> WithinEffect:
    n, df1 = scores.shape
    df2 = df1 * (n - 1)
    effect = n * float((scores.mean(axis=0) ** 2).sum()) if n else 0.0
    nothing = _NOTHING * total
    why = ""
    if n < 2:
        why = "it needs two complete participants"
    elif error <= nothing and effect <= nothing:
        why = "no value differs"
    effect = 0.0 if effect <= nothing else effect
    error = 0.0 if error <= nothing else error
    f = math.nan
    if not why:
        f = math.inf if error == 0.0 else (effect / df1) / (error / df2)
    epsilon = _epsilon(scores) if error > 0.0 else math.nan
    corrected = 0.0 if f == math.inf else math.nan
    if math.isfinite(f):
        corrected = f_tail(f, epsilon * df1, epsilon * df2)
    return WithinEffect(
        name=name,
        f=f,
        df1=df1,
        df2=max(df2, 0),
        p=math.nan if why else f_tail(f, df1, df2),
        epsilon=epsilon,
        p_corrected=corrected,
        eta_generalized=math.nan if why else effect / (effect + other),
        eta_partial=math.nan if why else effect / (effect + error),
        square_effect=effect,
        square_error=error,
        why=why,
    )


def _epsilon(scores: Floats) -> float:
    """Greenhouse-Geisser's epsilon of orthonormal contrasts, shape (n, df)."""
    away = scores - scores.mean(axis=0)
    products = away.T @ away
    df = len(products)
    return float(np.trace(products) ** 2 / (df * (products**2).sum()))
