"""What the metrics of a study say of its conditions: means, effects with intervals, tests; pure."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.data.rows import MetricRow
from rune_study.estimate import Estimate, unknown
from rune_study.metrics.registry import METRICS
from rune_study.statistics.holm import holm
from rune_study.statistics.log_rank import LogRankTest, log_rank
from rune_study.statistics.means import mean
from rune_study.statistics.paired import PairedEffect, paired_effect
from rune_study.statistics.repeated_measures import WithinAnalysis, rm_anova
from rune_study.statistics.survival import Survival, kaplan_meier, restricted_mean_estimate

CONDITION = "condition"
"""Name of the only factor of a study whose factors are not crossed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Contrast:
    """Two levels of a factor, compared within participants.

    Attributes:
        factor: The factor.
        first: One level.
        second: The other.
        effect: The first less the second.
        p_holm: p-value of the sign flips, for all contrasts of this metric together.
    """

    factor: str
    first: str
    second: str
    effect: PairedEffect
    p_holm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CensoredResult:
    """A metric that is a time, some of whose values are lower bounds only.

    Attributes:
        curves: The Kaplan-Meier curve of each condition with data, by its code.
        tau: Bound of the restricted means, the same in all conditions [s].
        test: Log-rank test of the conditions within participants; None: it needs two conditions.
    """

    curves: Mapping[str, Survival]
    tau: float
    test: LogRankTest | None


@dataclass(frozen=True, slots=True, kw_only=True)
class MetricResult:
    """A metric over all conditions.

    Attributes:
        metric: Its name.
        participants: Numbers of the participants.
        values: Mean of each participant under each condition (participants, conditions).
        means: Of each condition.
        contrasts: Effects of each factor's levels, first of all results.
        tests: Analysis of variance; None: it needs two participants and two conditions.
        reasons: Why trials have no value, with how many.
        by_place: Means over participants of each trial of the session, by its number.
        missing: Trials without a value of each condition that has some, by its code.
        censored: For times that are partly lower bounds; then means and effects are none. None:
            all values are exact.
    """

    metric: str
    participants: tuple[int, ...]
    values: npt.NDArray[np.float64]
    means: tuple[Estimate, ...]
    contrasts: tuple[Contrast, ...]
    tests: WithinAnalysis | None
    reasons: Mapping[str, int]
    missing: Mapping[str, int]
    by_place: Mapping[int, Estimate]
    censored: CensoredResult | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions:
    """The conditions of a study.

    Attributes:
        codes: Their codes.
        levels: Of each: the levels of its factors.
    """

    codes: tuple[str, ...]
    levels: tuple[Mapping[str, Any], ...]

    @property
    def factors(self) -> dict[str, list[str]]:
        """Levels of each factor, in their order; one factor if they are not crossed."""
        found: dict[str, list[str]] = {}
        for levels in self.levels:
            for name, level in levels.items():
                words = found.setdefault(name, [])
                if str(level) not in words:
                    words.append(str(level))
        found = {name: words for name, words in found.items() if len(words) > 1}
        cells = {self._cell(number, found) for number in range(len(self.codes))}
        crossed = math.prod(map(len, found.values())) == len(self.codes) == len(cells)
        return found if found and crossed else {CONDITION: list(self.codes)}

    def crossed(self, values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Values (participants, conditions) with an axis for each factor."""
        factors = self.factors
        if list(factors) == [CONDITION]:
            return values
        shape = [len(words) for words in factors.values()]
        found = np.full((len(values), *shape), np.nan)
        by_cell = np.moveaxis(found, 0, -1)
        for number in range(len(self.codes)):
            by_cell[self._cell(number, factors)] = values[:, number]
        return found

    def blinded(self) -> Conditions:
        """The same without levels."""
        return Conditions(codes=self.codes, levels=tuple({} for _ in self.codes))

    def _cell(self, number: int, factors: Mapping[str, list[str]]) -> tuple[int, ...]:
        levels = self.levels[number]
        return tuple(
            words.index(str(levels[name])) if name in levels else -1
            for name, words in factors.items()
        )


def compare(
    rows: Iterable[MetricRow], conditions: Conditions, metrics: Sequence[str]
) -> list[MetricResult]:
    """Compare conditions by metrics.

    Args:
        rows: All values that count; those of several trials, attempts and robots of one person
            under one condition are averaged first.
        conditions: The conditions.
        metrics: Which metrics, in this order.
    """
    by_metric: dict[str, list[MetricRow]] = {}
    for row in rows:
        by_metric.setdefault(row.metric, []).append(row)
    people = sorted({row.participant for each in by_metric.values() for row in each})
    return [_result(name, by_metric.get(name, []), conditions, people) for name in metrics]


def asked_once(rows: Iterable[MetricRow]) -> dict[str, Estimate]:
    """Means over participants of what was asked once per session, by metric."""
    values: dict[str, list[float]] = {}
    for row in rows:
        if not row.trial:
            values.setdefault(row.metric, []).append(row.value)
    return {name: _bounded(name, mean(each)) for name, each in values.items()}


def corrected(results: Sequence[MetricResult], primary: Sequence[str]) -> dict[str, float]:
    """p-values of the primary metrics' tests by "METRIC: FACTOR", after Holm together.

    Of a metric whose times are partly lower bounds, that is the log-rank test of all conditions.
    """
    tests = {
        f"{result.metric}: {effect.name}": effect.p_corrected
        for result in results
        if result.metric in primary and result.tests is not None
        for effect in result.tests.effects
    }
    tests |= {
        f"{result.metric}: {CONDITION}": result.censored.test.p
        for result in results
        if result.metric in primary and result.censored is not None and result.censored.test
    }
    return dict(zip(tests, holm(list(tests.values())).tolist(), strict=True)) if tests else {}


def _result(
    name: str, rows: Sequence[MetricRow], conditions: Conditions, people: Sequence[int]
) -> MetricResult:
    if any(row.censored for row in rows):
        return _censored(name, rows, conditions, people)
    gathered: dict[tuple[int, str], list[float]] = {}
    reasons: dict[str, int] = {}
    missing: dict[str, int] = {}
    places: dict[int, list[float]] = {}
    for row in rows:
        if math.isfinite(row.value):
            gathered.setdefault((row.participant, row.code), []).append(row.value)
            places.setdefault(row.trial, []).append(row.value)
        else:
            why = row.why or ("it is infinite" if math.isinf(row.value) else "it has no value")
            reasons[why] = reasons.get(why, 0) + 1
            missing[row.code] = missing.get(row.code, 0) + 1
    values = np.array(
        [
            [float(np.mean(gathered.get((person, code), [math.nan]))) for code in conditions.codes]
            for person in people
        ]
    ).reshape(len(people), len(conditions.codes))
    return MetricResult(
        metric=name,
        participants=tuple(people),
        values=values,
        means=tuple(
            _bounded(name, mean(values[:, number])) for number in range(len(conditions.codes))
        ),
        contrasts=tuple(_contrasts(name, values, conditions)),
        tests=_tests(values, conditions),
        reasons=reasons,
        missing=missing,
        by_place={place: _bounded(name, mean(each)) for place, each in places.items()},
    )


def _censored(
    name: str, rows: Sequence[MetricRow], conditions: Conditions, people: Sequence[int]
) -> MetricResult:
    known = [row for row in rows if math.isfinite(row.value)]
    durations = np.array([row.value for row in known])
    observed = np.array([not row.censored for row in known])
    codes = np.array([row.code for row in known])
    curves = {
        code: kaplan_meier(durations[codes == code], observed[codes == code])
        for code in conditions.codes
        if (codes == code).any()
    }
    strata = np.array([row.participant for row in known])
    test = log_rank(durations, observed, codes, strata) if len(curves) > 1 else None
    # Every condition has data up to here.
    tau = min(float(durations[codes == code].max()) for code in curves)
    nothing = np.full((len(people), len(conditions.codes)), math.nan)
    return MetricResult(
        metric=name,
        participants=tuple(people),
        values=nothing,
        means=tuple(
            restricted_mean_estimate(curves[code], tau)
            if code in curves
            else unknown("there is no trial")
            for code in conditions.codes
        ),
        contrasts=(),
        tests=None,
        reasons={},
        missing={},
        by_place={},
        censored=CensoredResult(curves=curves, tau=tau, test=test),
    )


def _tests(values: npt.NDArray[np.float64], conditions: Conditions) -> WithinAnalysis | None:
    complete = int(np.isfinite(values).all(axis=1).sum()) if values.size else 0
    if complete < 2 or len(conditions.codes) < 2:
        return None
    return rm_anova(conditions.crossed(values), tuple(conditions.factors))


def _bounded(metric: str, found: Estimate) -> Estimate:
    """A mean, whose interval ends where the metric does."""
    known = METRICS.get(metric)
    return known.bounded(found) if known is not None else found


def _bounded_effect(metric: str, found: PairedEffect) -> PairedEffect:
    known = METRICS.get(metric)
    if known is None:
        return found
    return dataclasses.replace(
        found,
        mean=known.bounded_difference(found.mean),
        middle=known.bounded_difference(found.middle),
    )


def _contrasts(
    metric: str, values: npt.NDArray[np.float64], conditions: Conditions
) -> list[Contrast]:
    """Each pair of levels of each factor, over the means of all other factors."""
    crossed = conditions.crossed(values)
    found: list[tuple[str, str, str, PairedEffect]] = []
    for axis, (factor, words) in enumerate(conditions.factors.items(), 1):
        others = tuple(each for each in range(1, crossed.ndim) if each != axis)
        by_level = crossed.mean(axis=others) if others else crossed
        for first, second in itertools.combinations(range(len(words)), 2):
            effect = paired_effect(by_level[:, first], by_level[:, second])
            effect = _bounded_effect(metric, effect)
            found.append((factor, words[first], words[second], effect))
    adjusted = holm([effect.flips.p for *_, effect in found]).tolist()
    return [
        Contrast(factor=factor, first=first, second=second, effect=effect, p_holm=float(p))
        for (factor, first, second, effect), p in zip(found, adjusted, strict=True)
    ]
