"""Log-rank test: whether groups of censored times differ.

N. Mantel, Cancer Chemother. Rep. 50, 1966. With strata it sums over them, so that each participant
is compared with himself only. Tied times have the hypergeometric variance, as in R's `survdiff`.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.statistics.arrays import Flags, Floats
from rune_study.statistics.distributions import chi_square_tail
from rune_study.statistics.survival import durations_of


@dataclass(frozen=True, slots=True, kw_only=True)
class LogRankTest:
    """The result of a log-rank test.

    Attributes:
        square: Its statistic; NaN: see `why`.
        df: Degrees of freedom: groups that could have an event, less 1.
        p: From the chi-square distribution.
        groups: Labels of the groups, sorted.
        observed: Events of each group.
        expected: Events of each group if all were alike.
        n: Observations.
        why: Why there is no result; empty where there is one.
    """

    square: float
    df: int
    p: float
    groups: tuple[object, ...]
    observed: tuple[float, ...]
    expected: tuple[float, ...]
    n: int
    why: str = ""


def log_rank(
    durations: npt.ArrayLike,
    observed: npt.ArrayLike,
    groups: npt.ArrayLike,
    strata: npt.ArrayLike | None = None,
) -> LogRankTest:
    """Test whether the times of groups differ.

    Args:
        durations: Time to the event or to the censoring, finite, at least 0, shape (n,).
        observed: Whether the event was seen, shape (n,).
        groups: Label of each one's group, shape (n,).
        strata: Label of each one's stratum, shape (n,), such as the participant. None: there are
            none.

    Raises:
        DataError: Lengths differ, a label is missing, or a duration is negative, infinite or
            missing.
    """
    times, seen = durations_of(durations, observed)
    labels = np.asarray(groups)
    layers = np.zeros(len(times), int) if strata is None else np.asarray(strata)
    if labels.shape != times.shape or layers.shape != times.shape:
        text = "each duration needs the label of its group, and of its stratum if there are any"
        raise DataError(text)
    if any(_missing(each) for each in (*labels.tolist(), *layers.tolist())):
        text = "the label of a group or stratum is missing; leave those durations out"
        raise DataError(text)
    known, member = np.unique(labels, return_inverse=True)
    sums = _Sums(len(known))
    for layer in np.unique(layers):
        here = layers == layer
        sums.add(times[here], seen[here], member[here])
    return sums.test(tuple(known.tolist()), len(times))


def _missing(label: object) -> bool:
    return label is None or label != label  # NaN differs from itself


class _Sums:
    """Observed and expected events of each group, and the covariance of their difference."""

    def __init__(self, groups: int) -> None:
        self._observed = np.zeros(groups)
        self._expected = np.zeros(groups)
        self._covariance = np.zeros((groups, groups))

    def add(self, times: Floats, seen: Flags, member: npt.NDArray[np.intp]) -> None:
        """Add the events of a stratum."""
        groups = np.arange(len(self._observed))
        at = np.unique(times[seen])
        starts = [np.sort(times[member == group]) for group in groups]
        ends = [np.sort(times[seen & (member == group)]) for group in groups]
        at_risk = np.array([len(each) - np.searchsorted(each, at) for each in starts], float)
        edges = np.append(at, np.inf)
        events = np.array([np.diff(np.searchsorted(each, edges)) for each in ends], float)
        total, dead = at_risk.sum(axis=0), events.sum(axis=0)
        shares = at_risk / total
        self._observed += events.sum(axis=1)
        self._expected += (shares * dead).sum(axis=1)
        factor = dead * (total - dead) / np.maximum(total - 1.0, 1.0)
        self._covariance += np.diag((shares * factor).sum(axis=1)) - (shares * factor) @ shares.T

    def test(self, labels: tuple[object, ...], n: int) -> LogRankTest:
        """The test of all events that were added."""
        part = np.flatnonzero(self._expected > 0.0)
        df = len(part) - 1
        square, why = math.nan, ""
        if df < 1:
            why = "fewer than two groups could have an event"
        else:
            away = (self._observed - self._expected)[part[1:]]
            covariance = self._covariance[np.ix_(part[1:], part[1:])]
            if np.linalg.matrix_rank(covariance, hermitian=True) < df:
                why = "no event comes while two groups are observed"
            else:
                square = float(away @ np.linalg.solve(covariance, away))
        return LogRankTest(
            square=square,
            df=max(df, 0),
            p=math.nan if why else chi_square_tail(square, df),
            groups=labels,
            observed=tuple(self._observed.tolist()),
            expected=tuple(self._expected.tolist()),
            n=n,
            why=why,
        )
