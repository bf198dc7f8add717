"""The results on the page of a study: effects with intervals first, tests last; pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from hub.plain_text import markup
from hub.values import dataclass
from rune_study.data.rows import TrialRow
from rune_study.estimate import Estimate
from rune_study.report.comparison import (
    CensoredResult,
    Conditions,
    Contrast,
    MetricResult,
    corrected,
)
from rune_study.report.html import interval, number, p_value, paragraph, people, table
from rune_study.report.svg import COLOURS, Axis, Chart


@dataclass(frozen=True, slots=True, kw_only=True)
class MetricWords:
    """What a reader must know of a metric.

    Attributes:
        label: Its words and unit: "neglect tolerance [s]".
        meaning: Its definition in a sentence.
        better: "more", "less", or empty where neither is.
        caution: What its comparison does not show, in a sentence.
    """

    label: str
    meaning: str
    better: str = ""
    caution: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """All that the results show.

    Attributes:
        conditions: Codes and levels; of a blind study without levels.
        trials: All trials that were begun.
        primary: Metrics that were chosen to decide.
        results: Every metric.
        words: Of every metric.
        once: Means of what was asked once per session, by metric.
    """

    conditions: Conditions
    trials: Sequence[TrialRow]
    primary: Sequence[str]
    results: Sequence[MetricResult]
    words: Mapping[str, MetricWords]
    once: Mapping[str, Estimate]

    @property
    def tested(self) -> bool:
        """Whether there are enough participants for tests."""
        return len({trial.participant for trial in self.trials if not trial.excluded}) > 1

    def words_of(self, metric: str) -> MetricWords:
        """Words of a metric; its name where there are none."""
        return self.words.get(metric, MetricWords(label=metric, meaning=""))


_READING = (
    "Intervals of means are between people; compare conditions by the intervals of differences, "
    "which are within people. All intervals are of 95 %, each for itself. They are cut where a "
    "metric ends: a share has no values below 0 or above 1."
)


def results_section(found: Results) -> Iterator[str]:
    """All results."""
    yield "<h2>Results</h2>"
    yield paragraph(_READING)
    yield from _decided(found)
    if any(result.metric not in found.primary for result in found.results) and found.primary:
        yield paragraph(
            "All other metrics are exploration: their p-values are corrected within a metric, and "
            "not over metrics."
        )
    for result in found.results:
        yield from _metric(found, result)
    yield from _asked_once(found)


def _decided(found: Results) -> Iterator[str]:
    """Metrics that were chosen to decide: all differences, then all tests."""
    chosen = [result for result in found.results if result.metric in found.primary]
    yield from map(paragraph, _untested(found))
    rows = [
        [
            found.words_of(result.metric).label,
            each.factor,
            f"{each.first} - {each.second}",
            number(each.effect.mean.value),
            interval(each.effect.mean),
            str(each.effect.n),
        ]
        for result in chosen
        for each in result.contrasts
        if each.effect.n
    ]
    if rows:
        heads = ["metric", "factor", "difference", "mean", "95 % interval", "n"]
        yield table(heads, rows, caption="Metrics that were chosen to decide: differences")
    adjusted = corrected(found.results, found.primary) if found.tested else {}
    if adjusted:
        yield table(
            ["metric", "factor", "p (Holm)"],
            [[*name.split(": ", 1), p_value(p)] for name, p in adjusted.items()],
            caption=f"Their {len(adjusted)} tests, together",
        )
        yield paragraph(
            "Analyses of variance within participants, after Greenhouse-Geisser; log-rank tests "
            f"for times with lower bounds. Holm's correction is over all {len(adjusted)}."
        )


def _untested(found: Results) -> Iterator[str]:
    """Why metrics that were chosen to decide have no test, in sentences."""
    if not found.primary:
        yield "No metric was chosen to decide: all that follows is exploration."
    if not found.tested:
        yield "It is too early for tests: they need trials that count of two participants or more."
        return
    for result in found.results:
        censored = result.censored is not None and result.censored.test is not None
        if result.metric not in found.primary or result.tests is not None or censored:
            continue
        label = found.words_of(result.metric).label
        if not any(each.known for each in result.means):
            reasons = f": {_reasons(result)}" if result.reasons else ""
            yield f"No trial has a value of {label!r}, which was chosen to decide{reasons}."
        else:
            yield (
                f"Fewer than two participants have a value of {label!r} under each condition; it "
                "was chosen to decide."
            )


def _metric(found: Results, result: MetricResult) -> Iterator[str]:
    words = found.words_of(result.metric)
    chosen = " (chosen to decide)" if result.metric in found.primary else ""
    yield f"<h3>{markup(words.label)}{chosen}</h3>"
    better = f" {words.better.capitalize()} is better." if words.better else ""
    yield paragraph(f"{words.meaning}{better}")
    if words.caution:
        yield paragraph(f"Caution: {words.caution}")
    known = [each for each in result.means if each.known and math.isfinite(each.value)]
    if result.censored is not None:
        yield from _times(found, result, result.censored, words.label)
    elif known:
        effects = _effects_chart(result.contrasts, words.label)
        yield f'<div class="pictures">{_people_chart(found, result, words.label)}{effects}</div>'
        yield _means(found, result)
        yield _contrasts(result.contrasts, tested=found.tested)
        yield from _tests(result) if found.tested else ()
        if result.metric in found.primary and len(result.by_place) > 1:
            yield _places(result.by_place)
    if result.reasons:
        yield paragraph(f"Trials without a value: {_reasons(result)}.")
    elif not known:
        yield paragraph("No trial has a value.")


def _reasons(result: MetricResult) -> str:
    """Why trials have no value, with the number of trials of each reason."""
    return "; ".join(f"{count} x {why}" for why, count in sorted(result.reasons.items()))


def _means(found: Results, result: MetricResult) -> str:
    rows = []
    for at, (code, each) in enumerate(zip(found.conditions.codes, result.means, strict=True)):
        column = result.values[:, at]
        whole = column[np.isfinite(column)]
        spread = float(whole.std(ddof=1)) if len(whole) > 1 else math.nan
        cells = [code, number(each.value), interval(each), number(spread), str(each.n)]
        rows.append([*cells, str(result.missing.get(code, 0))])
    heads = ["condition", "mean", "95 % interval", "SD", "participants", "trials without a value"]
    return table(heads, rows)


def _places(by_place: Mapping[int, Estimate]) -> str:
    rows = [
        [str(place), number(each.value), interval(each), str(each.n)]
        for place, each in sorted(by_place.items())
    ]
    heads = ["trial", "mean", "95 % interval", "n"]
    return table(heads, rows, caption="By the place in the session: learning, or fatigue")


def _times(
    found: Results, result: MetricResult, censored: CensoredResult, label: str
) -> Iterator[str]:
    """Curves of times that are partly censored, with their medians and restricted means."""
    codes = found.conditions.codes
    tau = censored.tau
    chart = Chart(Axis(label, 0.0, 1.05 * tau or 1.0), Axis("share without it", 0.0, 1.02))
    for code, curve in censored.curves.items():
        steps = [(0.0, 1.0), *zip(curve.times.tolist(), curve.survival.tolist(), strict=True)]
        kept = [(time, share) for time, share in steps if time <= tau]
        chart.steps([*kept, (tau, kept[-1][1])], COLOURS[codes.index(code) % len(COLOURS)])
        chart.text(tau, kept[-1][1], code, anchor="end")
    yield f'<div class="pictures">{chart.svg(f"share without {label} over time")}</div>'
    yield table(
        [
            "condition",
            "median",
            "95 % interval",
            f"mean up to {number(tau)} s",
            "95 % interval",
            "seen",
            "trials",
        ],
        [
            [
                code,
                number(censored.curves[code].median.value),
                interval(censored.curves[code].median),
                number(mean.value),
                interval(mean),
                str(int(censored.curves[code].events.sum())),
                str(censored.curves[code].n),
            ]
            for code, mean in zip(codes, result.means, strict=True)
            if code in censored.curves
        ],
    )
    yield paragraph(
        "Trials without it are lower bounds (Kaplan-Meier curves). Each trial counts by itself, so "
        "the intervals are too narrow if a participant has several in a condition."
    )
    if censored.test is not None and found.tested:
        words = censored.test.why or (
            f"Log-rank test within participants: chi-square {number(censored.test.square)} "
            f"with {censored.test.df} degrees of freedom, p {p_value(censored.test.p)}"
        )
        yield paragraph(f"{words}.")


def _people_chart(found: Results, result: MetricResult, label: str) -> str:
    """A line for each participant, and the mean of each condition with its interval."""
    codes = found.conditions.codes
    ends = [end for each in result.means for end in (each.low, each.high)]
    y = Axis.around(label, [*result.values.ravel().tolist(), *ends])
    chart = Chart(Axis.of_names("condition", codes), y)
    for line in result.values:
        chart.line([(float(at), float(value)) for at, value in enumerate(line)], "#b4b8be", wide=1)
    for at, each in enumerate(result.means):
        colour = COLOURS[at % len(COLOURS)]
        for participant, value in zip(result.participants, result.values[:, at], strict=True):
            title = f"participant {participant}: {number(float(value))}"
            chart.dot(at, float(value), "#8a8f96", size=2.5, title=title)
        chart.interval_up(at, each.low, each.high, colour)
        chart.dot(at, each.value, colour, size=5, title=f"{codes[at]}: {number(each.value)}")
    return chart.svg(f"{label} of each participant, and means with 95 % intervals")


def _effects_chart(contrasts: Sequence[Contrast], label: str) -> str:
    """Differences with their intervals, around no difference."""
    if not contrasts:
        return ""
    ends = [end for each in contrasts for end in (each.effect.mean.low, each.effect.mean.high)]
    values = [each.effect.mean.value for each in contrasts]
    contrasts = contrasts[::-1]  # the first is at the top
    names = [f"{each.first} - {each.second}" for each in contrasts]
    x = Axis.around(f"difference of {label}", [*values, *ends, 0.0])
    chart = Chart(x, Axis.of_names("", names), height=max(160, 60 + 26 * len(names)))
    chart.upright(0.0, "#555b63")
    for at, each in enumerate(contrasts):
        mean = each.effect.mean
        chart.interval_across(mean.low, mean.high, at, COLOURS[0])
        chart.dot(mean.value, at, COLOURS[0], size=4.5, title=number(mean.value))
    return chart.svg(f"differences of {label} with 95 % intervals")


def _contrasts(contrasts: Sequence[Contrast], *, tested: bool) -> str:
    rows = [
        [
            each.factor,
            f"{each.first} - {each.second}",
            number(each.effect.mean.value),
            interval(each.effect.mean),
            number(each.effect.middle.value),
            interval(each.effect.middle),
            number(each.effect.dz),
            str(each.effect.n),
            *((p_value(each.effect.flips.p), p_value(each.p_holm)) if tested else ()),
        ]
        for each in contrasts
    ]
    heads = ["factor", "difference", "mean", "95 % interval"]
    heads += ["Hodges-Lehmann", "95 % interval", "dz", "n"]
    exact = all(each.effect.flips.exact for each in contrasts)
    flips = "p (sign flips)" if exact else "p (sign flips, drawn)"
    return table([*heads, *((flips, "p (Holm)") if tested else ())], rows)


def _tests(result: MetricResult) -> Iterator[str]:
    if result.tests is None:
        return
    rows = [
        [
            each.name,
            number(each.eta_generalized),
            each.why
            or f"F({_df(each.df1, each.epsilon)}, {_df(each.df2, each.epsilon)}) = "
            f"{number(each.f)}",
            number(each.epsilon),
            p_value(each.p_corrected),
        ]
        for each in result.tests.effects
    ]
    yield table(["effect", "generalized η²", "test", "epsilon", "p (Greenhouse-Geisser)"], rows)
    if result.tests.left_out:
        gone = [result.participants[row] for row in result.tests.left_out]
        yield paragraph(
            f"The analysis of variance has the {result.tests.n} complete participants; "
            f"{people(gone)} had missing values."
        )


def _df(degrees: int, epsilon: float) -> str:
    """Degrees of freedom after Greenhouse-Geisser."""
    return number(degrees if math.isnan(epsilon) else degrees * epsilon)


def _asked_once(found: Results) -> Iterator[str]:
    if found.once:
        yield "<h2>Asked once per session</h2>"
        yield table(
            ["score", "mean", "95 % interval", "participants"],
            [
                [found.words_of(name).label, number(each.value), interval(each), str(each.n)]
                for name, each in found.once.items()
            ],
        )


def by_position(trials: Iterable[TrialRow], codes: Sequence[str]) -> list[list[int]]:
    """How often each condition counts at each place of the session."""
    counted = [trial for trial in trials if not trial.excluded and trial.trial]
    most = max((trial.trial for trial in counted), default=0)
    found = [[0] * most for _ in codes]
    for trial in counted:
        if trial.code in codes:
            found[codes.index(trial.code)][trial.trial - 1] += 1
    return found
