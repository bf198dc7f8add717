"""The page of a study: HTML that stands alone, with its pictures as SVG; pure."""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterator, Mapping, Sequence

from hub.plain_text import counted, markup
from hub.values import dataclass
from rune_study.data.rows import TrialRow
from rune_study.plan.design_report import DesignReport, design_lines
from rune_study.report.html import number, page, paragraph, table
from rune_study.report.maps import ConditionMap
from rune_study.report.results import Results, by_position, results_section


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyReport:
    """All that the page shows.

    Attributes:
        title: Of the study.
        digest: SHA-256 of the study's files.
        made: When the page was made, in words.
        design: The design in numbers.
        results: Conditions, trials and metrics.
        fixed: What the study's file says of metrics, by its keys: value and meaning.
        maps: Maps of the conditions, by their title.
        colours: Of each participant on maps.
        source: How the figures can be computed again.
        software: Names and versions of what computed it; files and their checksums.
        sessions: How far each participant came, where that is more than trials, by number.
        warnings: What is wrong with the data, a sentence each.
    """

    title: str
    digest: str
    made: str
    design: DesignReport
    results: Results
    fixed: Mapping[str, tuple[str, str]]
    maps: Mapping[str, ConditionMap]
    colours: Mapping[int, str]
    source: str
    software: Mapping[str, str]
    sessions: Mapping[int, str]
    warnings: Sequence[str] = ()


def html_page(report: StudyReport) -> str:
    """The page."""
    return page(
        report.title,
        [
            f"<h1>{markup(report.title)}</h1>",
            paragraph(_summary(report)),
            "<h2>Design</h2>",
            *_design(report),
            "<h2>Who did what</h2>",
            _sessions(report),
            *(paragraph(f"Note: {each}.") for each in report.warnings),
            *_excluded(report.results.trials),
            *_balance(report),
            *results_section(report.results),
            *_maps(report),
            "<h2>How to compute this again</h2>",
            paragraph(report.source),
            table(["what", "which"], [[name, text] for name, text in report.software.items()])
            if report.software
            else "",
        ],
    )


def _summary(report: StudyReport) -> str:
    trials = report.results.trials
    people = {trial.participant for trial in trials}
    count = sum(not trial.excluded for trial in trials)
    begins = [trial.begin for trial in trials if math.isfinite(trial.begin)]
    days = sorted(
        {f"{datetime.datetime.fromtimestamp(each).astimezone():%Y-%m-%d}" for each in begins}
    )
    when = f" Trials from {days[0]} to {days[-1]}." if days else ""
    return (
        f"{len(people)} of {counted(report.design.participants, 'participant')}, "
        f"{counted(count, 'trial')} that {'counts' if count == 1 else 'count'} of {len(trials)} "
        f"that were begun. Study {report.digest[:12]}, page made "
        f"{report.made}.{when}"
    )


def _design(report: StudyReport) -> Iterator[str]:
    yield _conditions(report)
    yield f"<pre>{markup(chr(10).join(design_lines(report.design)))}</pre>"
    yield from (paragraph(f"Note: {each}.") for each in report.design.warnings)
    if report.fixed:
        rows = [[name, text, meaning] for name, (text, meaning) in report.fixed.items()]
        heads = ["key of [metrics]", "value", "meaning"]
        yield table(heads, rows, caption="Fixed in the study's file")
        yield paragraph(
            "Each session keeps the checksum of the study's files from its begin; a session that "
            "began with other files is named below."
        )


def _conditions(report: StudyReport) -> str:
    conditions = report.results.conditions
    if not any(conditions.levels):
        return paragraph("Conditions appear by their codes only.")
    names = list(dict.fromkeys(name for levels in conditions.levels for name in levels))
    rows = [
        [code, *(str(levels.get(name, "")) for name in names)]
        for code, levels in zip(conditions.codes, conditions.levels, strict=True)
    ]
    return table(["condition", *names], rows)


def _sessions(report: StudyReport) -> str:
    trials = report.results.trials
    most = max((trial.trial for trial in trials), default=0)
    rows = []
    for person in sorted({*(trial.participant for trial in trials), *report.sessions}):
        own = [trial for trial in trials if trial.participant == person and trial.trial]
        cells = []
        for count in range(1, most + 1):
            attempts = [trial for trial in own if trial.trial == count]
            cells.append(" ".join(map(_attempt, attempts)) or "–")
        replaced = next((trial.replaces for trial in own if trial.replaces), 0)
        name = f"{person}" + (f" (for {replaced})" if replaced else "")
        rows.append([name, *cells, *([report.sessions.get(person, "")] if report.sessions else [])])
    heads = ["participant", *(f"trial {count}" for count in range(1, most + 1))]
    return table([*heads, *(["session"] if report.sessions else [])], rows)


def _attempt(trial: TrialRow) -> str:
    words = f"{trial.code}\N{NO-BREAK SPACE}{number(trial.seconds)}\N{NO-BREAK SPACE}s"
    return f"({words})" if trial.excluded else words


def _excluded(trials: Sequence[TrialRow]) -> Iterator[str]:
    left_out = [trial for trial in trials if trial.excluded]
    if left_out:
        yield "<p>Trials in parentheses do not count:</p>"
        yield table(
            ["participant", "trial", "attempt", "condition", "why"],
            [
                [
                    str(each.participant),
                    str(each.trial),
                    str(each.attempt),
                    each.code,
                    each.excluded,
                ]
                for each in left_out
            ],
        )
    else:
        yield "<p>No trial was excluded.</p>"


def _balance(report: StudyReport) -> Iterator[str]:
    codes = report.results.conditions.codes
    found = by_position(report.results.trials, codes)
    if found and found[0]:
        rows = [
            [code, *map(str, counts), str(sum(counts))]
            for code, counts in zip(codes, found, strict=True)
        ]
        heads = ["condition", *(f"trial {n}" for n in range(1, len(found[0]) + 1)), "all"]
        yield table(heads, rows, caption="Trials that count, by their place in the session")


def _maps(report: StudyReport) -> Iterator[str]:
    if not report.maps:
        return
    yield "<h2>Maps</h2>"
    yield paragraph(
        "Paths are thin lines, bumps crosses, marks without a victim diamonds; each in the colour "
        "of its participant. A circle is a victim; it says in how many trials it was found. Ground "
        "is darker the longer robots were there; the scale is the same on all maps."
    )
    swatches = "".join(
        f'<li><span style="background:{colour}"></span> participant {person}</li>'
        for person, colour in report.colours.items()
    )
    yield f'<ul class="legend">{swatches}</ul>'
    yield table(
        ["map", "trials", "driven [m]", "bumps", "victims found", "marks without a victim"],
        [
            [
                title,
                str(each.trials),
                number(each.driven),
                str(each.bumps),
                f"{each.found} of {each.victims}" if each.victims else "not known",
                str(each.false),
            ]
            for title, each in report.maps.items()
        ],
    )
    pictures = (
        f"<figure><figcaption>{markup(title)}</figcaption>{each.svg}</figure>"
        for title, each in report.maps.items()
    )
    yield f'<div class="pictures">{"".join(pictures)}</div>'
