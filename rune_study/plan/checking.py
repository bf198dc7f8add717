"""What `rune study check` says of a study: its design in numbers, and what is missing."""

from __future__ import annotations

import dataclasses
import itertools
import json
from collections.abc import Iterator, Sequence

from hub.nearest import did_you_mean
from hub.values import dataclass
from rune_study.metrics.registry import METRICS
from rune_study.plan.folder import (
    condition_problems,
    questionnaire_path,
    questionnaire_problems,
    text_path,
)
from rune_study.plan.orders import BY_LOT, MOST_TRIES, ROWS, balance, share_kept
from rune_study.plan.steps import (
    BREAK,
    PRACTICE,
    TRIAL,
    Step,
    base_row,
    codes,
    order_of,
    plan,
    rules,
)
from rune_study.plan.study_spec import StudySpec
from rune_study.trial_data.measured import EFFECTIVENESS

_MINUTES = {TRIAL: 1.0, "consent": 3.0, "demographics": 2.0}
"""What steps take besides their own time; a trial has to be begun [min]."""
_OTHER_MINUTES = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignReport:
    """A design in numbers.

    Attributes:
        rows: Number of different orders of the design; 0: each participant has an own one.
        participants: Number of participants.
        codes: Of the conditions.
        positions: How often each condition is at each position.
        carry_over: How often each condition comes right after each.
        kept: Of `tries` orders by lot, how many keep the rules.
        tries: Orders that were tried; 0: none by lot.
        minutes: Expected length of a session [min].
        warnings: What to think about, a sentence each.
    """

    rows: int
    participants: int
    codes: tuple[str, ...]
    positions: tuple[tuple[int, ...], ...]
    carry_over: tuple[tuple[int, ...], ...]
    kept: int
    tries: int
    minutes: float
    warnings: tuple[str, ...]


def design_report(study: StudySpec) -> DesignReport:
    """The design of a study in numbers."""
    by_lot = study.design.order in BY_LOT
    kept = tries = 0
    if by_lot and rules(study):
        tries = MOST_TRIES
        items, blocks = base_row(study)
        kept = share_kept(items, blocks, rules(study), study.seed, tries)
    reachable = not tries or kept > 0
    participants = range(1, study.participants + 1)
    orders = [order_of(study, each) for each in participants] if reachable else []
    found = balance(orders, len(study.conditions))
    rows = 0 if by_lot else len(ROWS[study.design.order](len(study.conditions)))
    return DesignReport(
        rows=rows,
        participants=study.participants,
        codes=codes(study),
        positions=found.positions,
        carry_over=found.carry_over,
        kept=kept,
        tries=tries,
        minutes=sum(map(minutes_of, plan(study, 1))) if reachable else 0.0,
        warnings=tuple(_warnings(study, rows, kept, tries)),
    )


def minutes_of(step: Step) -> float:
    """Expected length of a step [min]; of practice, its longest."""
    if step.kind in (BREAK, PRACTICE):
        return step.seconds / 60.0
    return step.seconds / 60.0 + _MINUTES.get(step.kind, _OTHER_MINUTES)


def _warnings(study: StudySpec, rows: int, kept: int, tries: int) -> Iterator[str]:
    if tries and not kept:
        yield f"none of {tries} orders keeps the rules: 'apart' or 'longest_run' asks too much"
    elif kept < tries / 100:
        yield f"only {kept} of {tries} orders keep the rules, so the orders are much alike"
    if rows and study.participants % rows:
        more = -study.participants % rows
        yield (
            f"{study.participants} participants are no multiple of the {rows} orders, so the "
            f"design is not balanced; {more} more would do"
        )
    if not study.metrics.primary:
        yield "[metrics] names no 'primary' metric; choose it before the first participant"


def design_lines(report: DesignReport) -> Iterator[str]:
    """The report for people."""
    those = f"{report.rows} orders" if report.rows else "an order by lot for each"
    yield f"{report.participants} participants, {len(report.codes)} conditions, {those}"
    yield f"a session takes about {report.minutes:.0f} minutes"
    if report.tries:
        yield f"{report.kept} of {report.tries} orders by lot keep the rules"
    if any(map(sum, report.positions)):
        places = [str(place) for place in range(1, len(report.positions[0]) + 1)]
        yield from _table("how often at each position", report.codes, places, report.positions)
        title = "how often right after each condition"
        yield from _table(title, report.codes, report.codes, report.carry_over)


def _table(
    title: str, rows: Sequence[str], columns: Sequence[str], cells: Sequence[Sequence[int]]
) -> Iterator[str]:
    yield ""
    yield title
    widest = max(3, *(len(str(cell)) for cell in itertools.chain(*cells)))
    yield "   " + " ".join(f"{column:>{widest}}" for column in columns)
    for name, row in zip(rows, cells, strict=True):
        yield f"{name:>2} " + " ".join(f"{cell:>{widest}}" for cell in row)


def missing(study: StudySpec) -> list[str]:
    """Files and names that the study names and that cannot be used, a sentence each."""
    names = {step.kind for step in plan(study, 1)} - {TRIAL, PRACTICE, BREAK}
    if study.freeze is not None:
        names.add(study.freeze.questions)
    steps = (
        f"there is no step {name!r}: write texts/{name}.md or questionnaires/{name}.toml"
        for name in names
        if text_path(study, name) is None and questionnaire_path(study, name) is None
    )
    conditions = (
        problem for spec in set(study.conditions) for problem in condition_problems(study, spec)
    )
    return sorted({*steps, *questionnaire_problems(study, names), *conditions, *_metrics(study)})


def _metrics(study: StudySpec) -> Iterator[str]:
    chosen = study.metrics
    for name in (*chosen.primary, *chosen.secondary):
        if name not in METRICS:
            yield f"[metrics]: {name!r} is no metric{did_you_mean(name, METRICS)}"
    if chosen.effectiveness not in EFFECTIVENESS:
        known = " or ".join(EFFECTIVENESS)
        yield f"[metrics]: {chosen.effectiveness!r} is no effectiveness; write {known}"


def as_json(report: DesignReport) -> str:
    """The report for machines, in one line."""
    return json.dumps(dataclasses.asdict(report))
