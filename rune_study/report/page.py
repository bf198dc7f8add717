"""The page of a study: HTML that stands alone, with its pictures as SVG; pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

from hub.values import dataclass
from rune_study.data.rows import TrialRow
from rune_study.estimate import Estimate
from rune_study.plan.checking import DesignReport, design_lines
from rune_study.report.comparison import (
    CensoredResult,
    Conditions,
    Contrast,
    MetricResult,
    corrected,
)
from rune_study.report.svg import COLOURS, Axis, Chart

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 62em; color: #181c22 }
table { border-collapse: collapse; margin: .6em 0 }
th, td { text-align: left; padding: .2em .7em; vertical-align: top }
td { border-bottom: 1px solid #c4c8cc }
td.number { text-align: right; font-variant-numeric: tabular-nums }
svg { width: 100%; display: block; margin: .5em 0 }
.pictures { display: grid; grid-template-columns: 1fr 1fr; gap: 1em }
pre { overflow-x: auto; background: #f2f3f5; padding: .6em }
h3 { margin-top: 2em; border-top: 1px solid #c4c8cc; padding-top: .6em }
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class MetricWords:
    """What a reader must know of a metric.

    Attributes:
        label: Its words and unit: "neglect tolerance [s]".
        meaning: Its definition in a sentence.
        better: "more", "less", or empty where neither is.
    """

    label: str
    meaning: str
    better: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyReport:
    """All that the page shows.

    Attributes:
        title: Of the study.
        digest: SHA-256 of the study's files.
        made: When the page was made, in words.
        design: The design in numbers.
        conditions: Codes and levels; of a blind study without levels.
        trials: All trials that were begun.
        primary: Metrics that were chosen to decide.
        results: Every metric.
        words: Of every metric.
        maps: SVG pictures of the arenas with the ways, by their title.
        source: How the figures can be computed again.
        once: Means of what was asked once per session, by metric.
        warnings: What is wrong with the data, a sentence each.
    """

    title: str
    digest: str
    made: str
    design: DesignReport
    conditions: Conditions
    trials: Sequence[TrialRow]
    primary: Sequence[str]
    results: Sequence[MetricResult]
    words: Mapping[str, MetricWords]
    maps: Mapping[str, str]
    source: str
    once: Mapping[str, Estimate]
    warnings: Sequence[str] = ()


def html_page(report: StudyReport) -> str:
    """The page."""
    parts = [
        f"<h1>{escape(report.title)}</h1>",
        f"<p>{escape(_summary(report))}</p>",
        "<h2>Design</h2>",
        _conditions(report),
        f"<pre>{escape(chr(10).join(design_lines(report.design)))}</pre>",
        *(f"<p>Note: {escape(each)}.</p>" for each in report.design.warnings),
        "<h2>Who did what</h2>",
        _sessions(report),
        *(f"<p>Note: {escape(each)}.</p>" for each in report.warnings),
        *_excluded(report.trials),
        "<h2>Results</h2>",
        *_primary_tests(report),
        *(part for result in report.results for part in _metric(report, result)),
        *_asked_once(report),
        *_maps(report.maps),
        "<h2>How to compute this again</h2>",
        f"<p>{escape(report.source)}</p>",
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8">'
        f"<title>{escape(report.title)}</title><style>{_STYLE}</style></head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def _summary(report: StudyReport) -> str:
    people = {trial.participant for trial in report.trials}
    counted = sum(not trial.excluded for trial in report.trials)
    return (
        f"{len(people)} of {report.design.participants} participants, {counted} trials that count "
        f"of {len(report.trials)} that were begun. Study {report.digest[:12]}, page made "
        f"{report.made}."
    )


def _conditions(report: StudyReport) -> str:
    if not any(report.conditions.levels):
        return "<p>Conditions appear by their codes only.</p>"
    names = list(dict.fromkeys(name for levels in report.conditions.levels for name in levels))
    rows = [
        [code, *(str(levels.get(name, "")) for name in names)]
        for code, levels in zip(report.conditions.codes, report.conditions.levels, strict=True)
    ]
    return _table(["condition", *names], rows)


def _sessions(report: StudyReport) -> str:
    most = max((trial.trial for trial in report.trials), default=0)
    rows = []
    for person in sorted({trial.participant for trial in report.trials}):
        own = [trial for trial in report.trials if trial.participant == person and trial.trial]
        cells = []
        for number in range(1, most + 1):
            attempts = [trial for trial in own if trial.trial == number]
            cells.append(" ".join(map(_attempt, attempts)) or "–")
        replaced = next((trial.replaces for trial in own if trial.replaces), 0)
        rows.append([f"{person}" + (f" (for {replaced})" if replaced else ""), *cells])
    heads = ["participant", *(f"trial {number}" for number in range(1, most + 1))]
    return _table(heads, rows)


def _attempt(trial: TrialRow) -> str:
    words = f"{trial.code} {_number(trial.seconds)} s"
    return f"({words})" if trial.excluded else words


def _excluded(trials: Sequence[TrialRow]) -> Iterator[str]:
    left_out = [trial for trial in trials if trial.excluded]
    if left_out:
        yield "<p>Trials in parentheses do not count:</p>"
        yield _table(
            ["participant", "trial", "attempt", "why"],
            [
                [str(each.participant), str(each.trial), str(each.attempt), each.excluded]
                for each in left_out
            ],
        )
    else:
        yield "<p>No trial was excluded.</p>"


def _primary_tests(report: StudyReport) -> Iterator[str]:
    yield from (f"<p>{escape(each)}</p>" for each in _untested(report))
    adjusted = corrected(report.results, report.primary) if _tested(report) else {}
    if not adjusted:
        return
    yield (
        "<p>Tests of the metrics that were chosen before the first participant; p-values after "
        "Greenhouse-Geisser, and after Holm over all of them.</p>"
    )
    yield _table(["metric and factor", "p (Holm)"], [[name, _p(p)] for name, p in adjusted.items()])


def _tested(report: StudyReport) -> bool:
    """Whether there are enough participants for tests."""
    return len({trial.participant for trial in report.trials if not trial.excluded}) > 1


def _untested(report: StudyReport) -> Iterator[str]:
    """Why metrics that were chosen to decide have no test, in sentences."""
    if not report.primary:
        yield "No metric was chosen to decide: all that follows is exploration."
    if not _tested(report):
        yield "It is too early for tests: they need trials that count of two participants or more."
        return
    for result in report.results:
        if result.metric not in report.primary or result.tests is not None:
            continue
        if result.censored is not None and result.censored.test is not None:
            yield f"{result.metric} has lower bounds among its values: its test stands below."
        elif not any(each.known for each in result.means):
            yield f"{result.metric} was chosen to decide, but no trial has a value of it."
        else:
            yield (
                f"{result.metric} was chosen to decide, but fewer than two participants have a "
                "value under each condition."
            )


def _metric(report: StudyReport, result: MetricResult) -> Iterator[str]:
    words = report.words.get(result.metric, MetricWords(label=result.metric, meaning=""))
    chosen = " (chosen to decide)" if result.metric in report.primary else ""
    yield f"<h3>{escape(words.label)}{chosen}</h3>"
    better = f" {words.better.capitalize()} is better." if words.better else ""
    yield f"<p>{escape(words.meaning)}{better}</p>"
    known = [each for each in result.means if each.known and math.isfinite(each.value)]
    if result.censored is not None:
        yield from _times(report, result, result.censored, words.label)
    elif known:
        effects = _effects_chart(result.contrasts, words.label)
        yield f'<div class="pictures">{_people_chart(report, result, words.label)}{effects}</div>'
        yield _table(
            ["condition", "mean", "95 % interval", "participants"],
            [
                [code, _number(each.value), _interval(each), str(each.n)]
                for code, each in zip(report.conditions.codes, result.means, strict=True)
            ],
        )
        tested = _tested(report)
        yield _contrasts(result.contrasts, tested=tested)
        yield from _tests(result) if tested else ()
    if result.reasons:
        reasons = "; ".join(f"{count} x {why}" for why, count in sorted(result.reasons.items()))
        yield f"<p>Trials without a value: {escape(reasons)}.</p>"
    elif not known:
        yield "<p>No trial has a value.</p>"


def _times(
    report: StudyReport, result: MetricResult, found: CensoredResult, label: str
) -> Iterator[str]:
    """Curves of times that are partly censored, with their medians and restricted means."""
    codes = report.conditions.codes
    chart = Chart(Axis(label, 0.0, 1.05 * found.tau or 1.0), Axis("share without it", 0.0, 1.02))
    for code, curve in found.curves.items():
        colour = COLOURS[codes.index(code) % len(COLOURS)]
        steps = [(0.0, 1.0), *zip(curve.times.tolist(), curve.survival.tolist(), strict=True)]
        kept = [(time, share) for time, share in steps if time <= found.tau]
        chart.steps([*kept, (found.tau, kept[-1][1])], colour)
        chart.text(found.tau, kept[-1][1], code, anchor="end")
    yield f'<div class="pictures">{chart.svg(f"share without {label} over time")}</div>'
    yield _table(
        ["condition", "median", f"mean up to {_number(found.tau)} s", "95 % interval", "seen", "n"],
        [
            [
                code,
                _number(found.curves[code].median.value),
                _number(mean.value),
                _interval(mean),
                str(int(found.curves[code].events.sum())),
                str(found.curves[code].n),
            ]
            for code, mean in zip(codes, result.means, strict=True)
            if code in found.curves
        ],
    )
    if found.test is not None and _tested(report):
        words = found.test.why or (
            f"Log-rank test within participants: chi-square {_number(found.test.square)} "
            f"with {found.test.df} degrees of freedom, p {_p(found.test.p)}"
        )
        yield f"<p>{escape(words)}.</p>"


def _people_chart(report: StudyReport, result: MetricResult, label: str) -> str:
    """A line for each participant, and the mean of each condition with its interval."""
    codes = report.conditions.codes
    ends = [end for each in result.means for end in (each.low, each.high)]
    y = Axis.around(label, [*result.values.ravel().tolist(), *ends])
    chart = Chart(Axis.of_names("condition", codes), y)
    for line in result.values:
        chart.line([(float(at), float(value)) for at, value in enumerate(line)], "#b4b8be", wide=1)
    for at, each in enumerate(result.means):
        colour = COLOURS[at % len(COLOURS)]
        for person in result.values[:, at]:
            chart.dot(at, float(person), "#8a8f96", size=2.5)
        chart.interval_up(at, each.low, each.high, colour)
        chart.dot(at, each.value, colour, size=5, title=f"{codes[at]}: {_number(each.value)}")
    return chart.svg(f"{label} of each participant, and means with 95 % intervals")


def _effects_chart(contrasts: Sequence[Contrast], label: str) -> str:
    """Differences with their intervals, around no difference."""
    if not contrasts:
        return ""
    ends = [end for each in contrasts for end in (each.effect.mean.low, each.effect.mean.high)]
    values = [each.effect.mean.value for each in contrasts]
    names = [f"{each.first} - {each.second}" for each in contrasts]
    x = Axis.around(f"difference of {label}", [*values, *ends, 0.0])
    chart = Chart(x, Axis.of_names("", names), height=max(160, 60 + 26 * len(names)))
    chart.upright(0.0, "#555b63")
    for at, each in enumerate(contrasts):
        mean = each.effect.mean
        chart.interval_across(mean.low, mean.high, at, COLOURS[0])
        chart.dot(mean.value, at, COLOURS[0], size=4.5, title=_number(mean.value))
    return chart.svg(f"differences of {label} with 95 % intervals")


def _contrasts(contrasts: Iterable[Contrast], *, tested: bool) -> str:
    rows = [
        [
            each.factor,
            f"{each.first} - {each.second}",
            _number(each.effect.mean.value),
            _interval(each.effect.mean),
            _number(each.effect.dz),
            str(each.effect.n),
            *((_p(each.effect.flips.p), _p(each.p_holm)) if tested else ()),
        ]
        for each in contrasts
    ]
    heads = ["factor", "difference", "mean", "95 % interval", "dz", "n"]
    return _table([*heads, *(("p (sign flips)", "p (Holm)") if tested else ())], rows)


def _tests(result: MetricResult) -> Iterator[str]:
    if result.tests is None:
        return
    rows = [
        [
            each.name,
            each.why or f"F({each.df1}, {each.df2}) = {_number(each.f)}",
            _number(each.epsilon),
            _p(each.p_corrected),
            _number(each.eta_generalized),
        ]
        for each in result.tests.effects
    ]
    yield _table(["effect", "test", "epsilon", "p (Greenhouse-Geisser)", "generalized η²"], rows)
    if result.tests.left_out:
        yield f"<p>Left out for missing values: {len(result.tests.left_out)} participants.</p>"


def _asked_once(report: StudyReport) -> Iterator[str]:
    if report.once:
        yield "<h2>Asked once per session</h2>"
        yield _table(
            ["score", "mean", "95 % interval", "participants"],
            [
                [
                    report.words[name].label if name in report.words else name,
                    _number(each.value),
                    _interval(each),
                    str(each.n),
                ]
                for name, each in report.once.items()
            ],
        )


def _maps(maps: Mapping[str, str]) -> Iterator[str]:
    if maps:
        yield "<h2>Ways</h2>"
        pictures = (f"<div><p>{escape(name)}</p>{svg}</div>" for name, svg in maps.items())
        yield f'<div class="pictures">{"".join(pictures)}</div>'


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(each)}</th>" for each in heads)
    lines = "".join(
        "<tr>" + "".join(f"<td{_class(cell)}>{escape(cell)}</td>" for cell in row) + "</tr>"
        for row in rows
    )
    return f"<table><tr>{head}</tr>{lines}</table>"


def _class(cell: str) -> str:
    try:
        float(cell.strip("<"))
    except ValueError:
        return ""
    return ' class="number"'


def _number(value: float) -> str:
    """A number with three digits; a dash where there is none."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def _interval(estimate: Estimate) -> str:
    if not estimate.has_interval:
        return "–"
    return f"{_number(estimate.low)} to {_number(estimate.high)}"


def _p(value: float) -> str:
    if math.isnan(value):
        return "–"
    return "<0.001" if value < 0.001 else f"{value:.3f}"
