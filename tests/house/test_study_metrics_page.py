"""The page of metrics says what their table and the numbers of a study declare.

After a wanted change, write it anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house
"""

from __future__ import annotations

import dataclasses
import doctest
import inspect
import os
from collections.abc import Iterator
from pathlib import Path

from rune_study.metrics import (
    awareness,
    bumps,
    coverage,
    driving,
    effectiveness,
    episodes,
    fan_out,
    latency,
    map_quality,
    neglect,
    questionnaires,
    shortest_path,
    steering,
    trial_time,
    victims,
)
from rune_study.metrics.registry import METRICS
from rune_study.metrics.trial import MeasureSpec
from rune_study.statistics import (
    bootstrap,
    holm,
    log_rank,
    means,
    paired,
    ranks,
    repeated_measures,
    sign_flips,
    survival,
)
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
  known, the study says why instead. An interval ends where the metric does: a share at 0 and 1.
- **Neglect tolerance is censored.** Most neglects end because the operator returns, and the robot
  would have worked on. Their mean would be far too low. The study takes the Kaplan-Meier curve
  of all neglects, and names the bound of each restricted mean.
- **It needs drops that are seen.** If less than a third of the neglects end with one, neglect
  tolerance and what follows from it are "not identifiable". An operator who foresees drops makes
  the tolerance too long. Neglect probes help: the console withholds control until the drop. In a
  model who foresees half of the drops, 51 % are seen, and the median is 28.4 s in place of 21.7 s.
  With probes in half of the neglects it is 74 % and 24.4 s.
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

### Rules where packages differ

| where | the rule |
| --- | --- |
| an event and a censoring at one time | the event comes first |
| S is 0.5 exactly | the median is that time; R takes the middle up to the next event |
| S falls to 0 | its limits are 0; R has none there. The upper end of the median is then infinite |
| a restricted mean beyond the last observation | the curve stays as it is, and a note says so |
| tied events of a log-rank test | the hypergeometric variance, as in R's `survdiff` |
| sums of sign flips | two-sided; equal up to 1e-12 of all differences; a difference of 0 stays |
| equal values in ranks | their mean rank |
| fewer than 6 differences | the 95 % interval of ranks is the whole line, and a note says so |
| Greenhouse-Geisser's epsilon | always applied, without a test of sphericity before |
| participants do not differ in an effect | F is infinite and p is 0 |
| missing values | a participant with one is left out of that comparison whole |
| Holm | a test that could not be made (NaN) does not count, as in R's `p.adjust` |
| bounds of metrics | a pause of 2 s, 1 m, 10 cm and 15 deg are within, up to 1e-9 |
"""
_ALONE = """## On your own numbers

All functions take plain lists or arrays. `help(kaplan_meier)` in Python lists the arguments with
their units. What cannot be known is an `Estimate` with `why` in words, or NaN where the function
says so. Data of a wrong shape or range raise a `DataError`.

```python
>>> from rune_study.statistics.survival import kaplan_meier
>>> weeks = [6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35]
>>> relapsed = [1, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0]
>>> curve = kaplan_meier(weeks, relapsed)
>>> curve.median.value, curve.median.low, curve.median.high
(23.0, 13.0, inf)
>>> round(curve.at(10), 4), round(curve.restricted_mean(tau=35).value, 3)
(0.7529, 23.287)

>>> from rune_study.statistics.log_rank import log_rank
>>> placebo = [1, 1, 2, 2, 3, 4, 4, 5, 5, 8, 8, 8, 8, 11, 11, 12, 12, 15, 17, 22, 23]
>>> test = log_rank(weeks + placebo, relapsed + [1] * 21, ["drug"] * 21 + ["placebo"] * 21)
>>> round(test.square, 2), test.df
(16.79, 1)

>>> from rune_study.statistics.paired import paired_effect
>>> drug_1 = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
>>> drug_2 = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]
>>> effect = paired_effect(drug_1, drug_2)
>>> round(effect.mean.value, 2), round(effect.mean.low, 2), round(effect.mean.high, 2)
(-1.58, -2.46, -0.7)
>>> round(effect.t, 4), effect.df, round(effect.p, 6), effect.flips.p
(-4.0621, 9, 0.002833, 0.00390625)

>>> from rune_study.statistics.repeated_measures import rm_anova
>>> rows = [[10, 8, 8], [12, 9, 8], [11, 10, 9], [11, 10, 8], [10, 8, 9], [11, 9, 7]]
>>> test = rm_anova(rows).effects[0]
>>> round(test.f, 4), test.df1, test.df2, round(test.epsilon, 4), round(test.p_corrected, 5)
(19.7059, 2, 10, 0.7983, 0.00112)

>>> from rune_study.statistics.sign_flips import sign_flips
>>> sign_flips([49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48]).p
0.05267333984375

>>> from rune_study.statistics.holm import holm
>>> holm([0.01, 0.04, 0.03]).round(3).tolist()
[0.03, 0.06, 0.06]
```

Sign flips of signed ranks are F. Wilcoxon's test. Half of the p-value is that of one side.

```python
>>> from rune_study.metrics.episodes import episodes
>>> [(each.begin, each.end) for each in episodes([10, 10.5, 11, 14, 30], [9, 13.5])]
[(9.0, 11.0), (13.5, 14.5), (30.0, 30.5)]

>>> from rune_study.metrics.fan_out import attention_demand, fan_out, free_time
>>> attention_demand(10, 30), free_time(10, 30), fan_out(10, 30)
(0.25, 0.75, 4.0)

>>> from rune_study.metrics.victims import Mark, victims_found
>>> places = [(1, 1), (5, 5), (8, 2), (3, 9)]
>>> marks = [Mark(time=9, x=1.2, y=1), Mark(time=20, x=1, y=1.3),
...          Mark(time=31, x=5.6, y=5.8), Mark(time=40, x=8, y=3.1)]
>>> found = victims_found(marks, places)
>>> found.found, found.false, found.fraction, found.precision, round(found.error, 3)
(2, 2, 0.5, 0.5, 0.6)

>>> from rune_study.metrics.questionnaires import TLX_SCALES, raw_tlx, sus, weighted_tlx
>>> sus([4, 1, 5, 2, 5, 1, 4, 2, 3, 1])
85.0
>>> ratings = dict(zip(TLX_SCALES, [100, 80, 60, 40, 20, 0]))
>>> chosen = ["mental"] * 5 + ["physical"] * 4 + ["temporal"] * 3 + ["performance"] * 2 + ["effort"]
>>> raw_tlx(ratings), round(weighted_tlx(ratings, chosen), 2)
(50.0, 73.33)
```

All metrics of a trial at once come from its data. What is left out is not known:

```python
>>> from rune_study.metrics.registry import measure
>>> from rune_study.metrics.trial import RobotData, TrialData
>>> import numpy as np
>>> robot = RobotData(name="rover", inputs=np.array([5, 6.5, 8, 34, 35]), selections=np.array([33]))
>>> found = measure(TrialData(length=100.0, robots=(robot,)))
>>> found["ie_mean"].value, found["episodes"].value, found["rad_mission"].value
(2.5, 2, 0.05)
>>> found["nt_median"].why
'no progress was recorded'
```
"""
_FUNCTIONS = (
    survival, log_rank, paired, repeated_measures, sign_flips, ranks, bootstrap, holm, means,
    episodes, effectiveness, neglect, fan_out, trial_time, victims, coverage, map_quality, bumps,
    driving, shortest_path, steering, latency, awareness, questionnaires,
)  # fmt: skip
"""Modules whose functions the page lists."""


def _page() -> str:
    return (
        "\n".join(
            [
                *[_HEAD, *_metrics(), "", _NUMBERS, *_numbers(), ""],
                *[_STATISTICS, _ALONE, *_functions()],
            ]
        )
        + "\n"
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


def _functions() -> Iterator[str]:
    yield "### All functions"
    yield ""
    yield "| function | what it gives |"
    yield "| --- | --- |"
    for module in _FUNCTIONS:
        place = module.__name__.removeprefix("rune_study.")
        for name, function in inspect.getmembers(module, inspect.isfunction):
            if function.__module__ == module.__name__ and not name.startswith("_"):
                words = inspect.getdoc(function) or ""
                yield f"| `{place}.{name}` | {words.partition(chr(10))[0]} |"


def test_its_examples_give_what_it_says() -> None:
    words = "\n".join(line for line in _ALONE.splitlines() if not line.startswith("```"))
    examples = doctest.DocTestParser().get_doctest(words, {}, "study-metrics.md", str(_PAGE), 0)
    assert len(examples.examples) > 30
    said: list[str] = []
    doctest.DocTestRunner(verbose=False).run(examples, out=said.append)
    assert said == []


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
