"""The design of a study in numbers: orders, balance, rules, minutes."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence

from hub.plain_text import counted
from hub.values import dataclass
from rune_study.plan.conditions import shared_words
from rune_study.plan.orders import BY_LOT, MOST_TRIES, ROWS, balance, counts_kept
from rune_study.plan.steps import (
    BREAK,
    PRACTICE,
    SECONDARY,
    TRIAL,
    Step,
    base_row,
    codes,
    order_of,
    plan,
    rules,
)
from rune_study.plan.study_spec import StudySpec

_MINUTES = {TRIAL: 1.0, "consent": 3.0, "demographics": 2.0}
"""What steps take besides their own time; a trial has to be begun [min]."""
_OTHER_MINUTES = 2.0
_MOST_ORDERS = 24
"""Orders that are listed for people."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignReport:
    """A design in numbers.

    Attributes:
        rows: Number of different orders of the design; 0: each participant has an own one.
        participants: Number of participants.
        codes: Of the conditions.
        orders: Participants with each order, by the codes of its trials.
        positions: How often each condition is at each position.
        carry_over: How often each condition comes right after each.
        kept: Of `tries` orders by lot, how many keep the rules.
        kept_each: The same for each rule by itself, by its words.
        tries: Orders that were tried; 0: none by lot.
        minutes: Expected length of a session [min].
        minutes_of: The same of its parts, by their names.
        warnings: What to think about, a sentence each.
        shared: What robots may do by themselves in all conditions; empty: conditions say it.
    """

    rows: int
    participants: int
    codes: tuple[str, ...]
    orders: Mapping[str, tuple[int, ...]]
    positions: tuple[tuple[int, ...], ...]
    carry_over: tuple[tuple[int, ...], ...]
    kept: int
    kept_each: Mapping[str, int]
    tries: int
    minutes: float
    minutes_of: Mapping[str, float]
    warnings: tuple[str, ...]
    shared: str = ""


def design_report(study: StudySpec) -> DesignReport:
    """The design of a study in numbers."""
    by_lot = study.design.order in BY_LOT
    of_rules = rules(study) if by_lot else {}
    kept, tries, each = 0, 0, [0] * len(of_rules)
    if of_rules:
        tries = MOST_TRIES
        items, blocks = base_row(study)
        kept, each = counts_kept(items, blocks, list(of_rules.values()), study.seed, tries)
    reachable = not tries or kept > 0
    participants = range(1, study.participants + 1)
    orders = [order_of(study, each) for each in participants] if reachable else []
    found = balance(orders, len(study.conditions))
    rows = 0 if by_lot else len(ROWS[study.design.order](len(study.conditions)))
    letters = codes(study)
    groups: dict[str, list[int]] = {}
    for participant, order in enumerate(orders, 1):
        groups.setdefault("".join(letters[index] for index in order), []).append(participant)
    minutes: dict[str, float] = {}
    for step in plan(study, 1) if reachable else ():
        minutes[step.kind] = minutes.get(step.kind, 0.0) + minutes_of(step)
    kept_each = dict(zip(of_rules, each, strict=True))
    return DesignReport(
        rows=rows,
        participants=study.participants,
        codes=letters,
        orders={order: tuple(people) for order, people in groups.items()},
        positions=found.positions,
        carry_over=found.carry_over,
        kept=kept,
        kept_each=kept_each,
        tries=tries,
        minutes=sum(minutes.values()),
        minutes_of=minutes,
        warnings=tuple(_warnings(study, rows, kept, tries)),
        shared=shared_words(study),
    )


def minutes_of(step: Step) -> float:
    """Expected length of a step [min]; of practice, its longest."""
    if step.kind in (BREAK, PRACTICE, SECONDARY):
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
    those = counted(report.rows, "order") if report.rows else "an order by lot for each"
    people, codes = report.participants, len(report.codes)
    yield f"{counted(people, 'participant')}, {counted(codes, 'condition')}, {those}"
    if report.shared:
        yield f"all conditions: {report.shared}"
    if report.minutes_of:
        parts = ", ".join(f"{name} {minutes:.0f}" for name, minutes in report.minutes_of.items())
        every = _long(report.participants * report.minutes)
        yield f"a session takes about {_long(report.minutes)}, all of them {every}"
        yield f"  minutes of a session: {parts}"
    if report.tries:
        yield f"{report.kept} of {report.tries} orders by lot keep the rules"
        for name, kept in report.kept_each.items():
            yield f"  {name}, by itself: {kept}"
    if report.orders:
        yield from _orders(report.orders)
    if any(map(sum, report.positions)):
        places = [str(place) for place in range(1, len(report.positions[0]) + 1)]
        yield from _table("how often at each position", report.codes, places, report.positions)
        title = "how often right after each condition"
        yield from _table(title, report.codes, report.codes, report.carry_over)


def _long(minutes: float) -> str:
    """A length in words: minutes, from two hours on hours."""
    if minutes < 120.0:
        return counted(max(1, round(minutes)), "minute")
    return counted(round(minutes / 60.0), "hour")


def _orders(orders: Mapping[str, Sequence[int]]) -> Iterator[str]:
    yield ""
    yield "order and participants"
    for order, people in itertools.islice(sorted(orders.items()), _MOST_ORDERS):
        yield f" {' '.join(order)}   {' '.join(map(str, people))}"
    if len(orders) > _MOST_ORDERS:
        yield f" and {len(orders) - _MOST_ORDERS} more; `rune study plan` shows all"


def _table(
    title: str, rows: Sequence[str], columns: Sequence[str], cells: Sequence[Sequence[int]]
) -> Iterator[str]:
    yield ""
    yield title
    widest = max(3, *(len(str(cell)) for cell in itertools.chain(*cells)))
    yield "   " + " ".join(f"{column:>{widest}}" for column in columns)
    for name, row in zip(rows, cells, strict=True):
        yield f"{name:>2} " + " ".join(f"{cell:>{widest}}" for cell in row)


def as_data(report: DesignReport) -> dict[str, object]:
    """The report as what JSON has."""
    return dataclasses.asdict(report)
