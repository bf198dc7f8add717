"""The page of a study is well-formed, stands alone, and says what is missing."""

from __future__ import annotations

import dataclasses
import math
import re
from html.parser import HTMLParser

import numpy as np

from rune_study.data.rows import MetricRow, TrialRow
from rune_study.plan.design_report import DesignReport
from rune_study.report.comparison import Conditions, compare
from rune_study.report.page import StudyReport, html_page
from rune_study.report.results import MetricWords, Results

CONDITIONS = Conditions(codes=("A", "B"), levels=({"layout": "search"}, {"layout": "robobot-2004"}))
DESIGN = DesignReport(
    rows=2,
    participants=4,
    codes=("A", "B"),
    positions=((2, 2), (2, 2)),
    carry_over=((0, 2), (2, 0)),
    orders={"AB": (1, 3), "BA": (2, 4)},
    kept=0,
    kept_each={},
    tries=0,
    minutes=30.0,
    minutes_of={"trial": 30.0},
    warnings=(),
)


def report(conditions: Conditions = CONDITIONS) -> StudyReport:
    random = np.random.default_rng(1)
    rows, trials = [], []
    for person in range(1, 5):
        for trial, code in enumerate("AB" if person % 2 else "BA", 1):
            value = 10 + 2 * (code == "B") + float(random.normal())
            lost = person == 4 and code == "B"
            trials.append(
                TrialRow(
                    participant=person,
                    trial=trial,
                    code=code,
                    seconds=600.0,
                    excluded="the hub's recording is cut" if lost else "",
                )
            )
            rows.append(
                MetricRow(
                    participant=person,
                    trial=trial,
                    code=code,
                    metric="IE",
                    value=math.nan if lost else value,
                    why="the trial does not count" if lost else "",
                )
            )
    return StudyReport(
        title="Layouts <2026>",
        digest="f" * 64,
        made="today",
        design=DESIGN,
        results=Results(
            conditions=conditions,
            trials=trials,
            primary=("IE",),
            results=compare(rows, conditions, ["IE", "NT"]),
            words={
                "IE": MetricWords(label="interaction effort [s]", meaning="Mean.", better="less")
            },
            once={},
        ),
        fixed={"primary": ("IE", "what decides")},
        maps={},
        colours={},
        source="rune study report",
        software={"NumPy": "2"},
        sessions={},
    )


def changed(whole: StudyReport, **fields: object) -> StudyReport:
    """The report with other results."""
    return dataclasses.replace(whole, results=dataclasses.replace(whole.results, **fields))


class Balance(HTMLParser):
    """Counts tags that are open."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag != "meta":
            self.open.append(tag)
        self.addresses += [value or "" for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def words_of(page: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))


def test_the_page_is_balanced_and_needs_nothing_from_elsewhere() -> None:
    page = html_page(report())
    balance = Balance()
    balance.feed(page)
    assert balance.open == []
    assert balance.addresses == []
    assert "<script" not in page
    assert "Layouts &lt;2026&gt;" in page


def test_it_says_who_was_left_out_and_why() -> None:
    words = words_of(html_page(report()))
    assert "7 trials that count of 8 that were begun" in words
    assert "the hub's recording is cut" in words.replace("&#x27;", "'")
    assert "1 x the trial does not count" in words
    assert "The analysis of variance has the 3 complete participants; participant 4 had" in words


def test_effects_come_with_intervals_and_before_tests() -> None:
    page = html_page(report())
    assert page.index("95 % interval") < page.index("p (sign flips)") < page.index("epsilon")
    assert "p (Holm)" in page


def test_differences_of_chosen_metrics_come_first_and_without_empty_rows() -> None:
    page = html_page(changed(report(), primary=("NT", "IE")))
    table = page[page.index("differences</caption>") :]
    first = words_of(table[: table.index("</table>")])
    assert "interaction effort [s]" in first
    assert "NT" not in first
    assert "learning, or fatigue" in page


def test_a_metric_without_values_says_so() -> None:
    assert "No trial has a value." in html_page(report())


def test_each_reason_for_no_test_has_its_own_sentence() -> None:
    whole = report()
    first = [trial for trial in whole.results.trials if trial.participant == 1]
    none = words_of(html_page(changed(whole, primary=())))
    empty = words_of(html_page(changed(whole, primary=("NT",))))
    early = words_of(html_page(changed(whole, trials=first)))
    assert "No metric was chosen to decide" in none
    assert "No trial has a value of &#x27;NT&#x27;, which was chosen to decide." in empty
    assert "It is too early for tests" in early
    assert "p (" not in early
    assert "No metric was chosen" not in empty + early
    assert "which was chosen to decide" not in words_of(html_page(whole))


def test_a_blind_page_names_no_condition() -> None:
    assert "robobot" not in html_page(report(CONDITIONS.blinded()))
    assert "robobot" in html_page(report())


def test_times_with_lower_bounds_are_drawn_as_curves() -> None:
    rows = [
        MetricRow(
            participant=person,
            trial=trial,
            code=code,
            metric="first_victim",
            value=100.0 * person * trial,
            censored=int(code == "B"),
        )
        for person in range(1, 4)
        for trial, code in enumerate("AB", 1)
    ]
    results = compare(rows, CONDITIONS, ["first_victim"])
    page = html_page(changed(report(), results=results))
    words = words_of(page)
    assert "mean up to 300 s" in words
    assert "Log-rank test within participants" in words
    balance = Balance()
    balance.feed(page)
    assert balance.open == []
