"""The page of metrics says what their table and the numbers of a study declare.

After a wanted change, write it anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from pathlib import Path

from rune_study.metrics.registry import METRICS
from rune_study.metrics.trial import MeasureSpec
from tests.house.test_plain_words import avoided_words, long_sentences
from tests.support.docstrings import meanings

_PAGE = Path(__file__).parents[2] / "docs" / "study-metrics.md"
_HEAD = """# Metrics of a study

A study computes these numbers from the recordings and answers of each trial. `rune_study/metrics/`
holds the functions, with the source of each formula; they also work alone, on plain arrays.

## What to know before you read a number

- Times count from the first moment of control to the end of the trial. Freezes and pauses are cut
  out.
- A number comes with its 95 % interval and the count of what it stands on. Where it cannot be
  known, the study says why instead.
- **Neglect tolerance is censored.** Most neglects end because the operator returns, and the robot
  would have worked on. Their mean would be far too low. The study takes the Kaplan-Meier curve
  of all neglects, and names the bound of each restricted mean.
- **It needs drops that are seen.** If less than a third of the neglects end with one, neglect
  tolerance and what follows from it are "not identifiable". An operator who foresees drops makes
  the tolerance too long. Neglect probes help: the console withholds control until the drop.
- A robot that stops when its operator releases the stick has next to no neglect tolerance, in any
  layout. Its fan-out is 1.
- The median is the first time at which at most half is left (S <= 0.5 + 1e-12). Where the curve is
  0.5 exactly, R takes the middle up to the next event.
- Choose what progress is, and which metrics decide, before the first participant.
"""
_NUMBERS = """## Numbers that a study fixes

`rune_study/metrics/trial.py` holds them. They apply to all trials of a study.
"""
_STATISTICS = """## Statistics

`rune_study/statistics/` compares conditions within participants. Participants with a missing value
are left out of that comparison and named.

| what | how |
| --- | --- |
| an effect of two conditions | mean difference with Student's interval, dz |
| the same without a distribution | Hodges-Lehmann estimate with the exact interval of ranks |
| its p-value | all sign flips up to 20 participants, 100,000 drawn ones beyond |
| several conditions or factors | analysis of variance, always corrected by Greenhouse-Geisser |
| their effect | generalized eta squared |
| several conditions, by ranks | Friedman's test |
| times that are censored | Kaplan-Meier with log-log limits, restricted mean |
| their difference | log-rank test, by participant if wanted |
| any other number | bootstrap over participants: BCa or percentile, with a seed |
| several tests | Holm's correction over the metrics that were registered before |
"""


def _page() -> str:
    return (
        "\n".join([_HEAD, *_metrics(), "", _NUMBERS, *_numbers(), "", _STATISTICS]).rstrip() + "\n"
    )


def _metrics() -> Iterator[str]:
    yield "## All metrics"
    yield ""
    yield "| metric | unit | better | meaning |"
    yield "| --- | --- | --- | --- |"
    for each in METRICS.values():
        yield f"| `{each.name}` | {each.unit} | {each.better} | {each.words} |"


def _numbers() -> Iterator[str]:
    said = meanings(MeasureSpec)
    yield "| number | default | meaning |"
    yield "| --- | --- | --- |"
    for each in dataclasses.fields(MeasureSpec):
        yield f"| `{each.name}` | {each.default:.3g} | {said[each.name]} |"


def test_page_of_metrics_is_that_of_their_table() -> None:
    wanted = _page()
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        _PAGE.write_text(wanted)
    assert _PAGE.read_text() == wanted, "write it anew, as this file's docstring says"


def test_its_words_are_plain() -> None:
    assert long_sentences(_PAGE.read_text()) == []
    assert avoided_words(_PAGE.read_text()) == []
    for each in METRICS.values():
        assert long_sentences(each.words) == []
