"""The tables of a study's data: a dataclass for each, whose fields are the columns."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from hub.values import dataclass
from rune_study.estimate import Estimate


def column(meaning: str, unit: str = "", default: Any = dataclasses.MISSING) -> Any:  # noqa: ANN401 - what dataclasses want for a field
    """The field of a table's column.

    Args:
        meaning: For people.
        unit: Its unit; empty: none.
        default: The value where it has none.
    """
    return dataclasses.field(default=default, metadata={"meaning": meaning, "unit": unit})


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialRow:
    """A trial that was begun; `trials.csv`."""

    participant: int = column("number of the participant")
    replaces: int = column("the participant whose order this one took over; 0: none", default=0)
    trial: int = column("number of the trial in the session, from 1; 0: practice")
    attempt: int = column("which attempt at this trial, from 1", default=1)
    code: str = column("code of the condition")
    begin: float = column("begin of the trial since 1970", "s", math.nan)
    seconds: float = column("its length without freezes and pauses", "s", math.nan)
    ended: str = column("what ended it", default="")
    excluded: str = column("why it does not count; empty: it counts", default="")
    partial: str = column("what its recordings lack; empty: they are whole", default="")


@dataclass(frozen=True, slots=True, kw_only=True)
class MetricRow:
    """A metric of a trial, or of a session; `metrics.csv`."""

    participant: int = column("number of the participant")
    trial: int = column("number of the trial in the session, from 1; 0: asked once per session")
    attempt: int = column("which attempt at this trial, from 1", default=1)
    code: str = column("code of the condition; empty: of the whole session")
    robot: str = column("the robot; empty: all robots together", default="")
    metric: str = column("name of the metric, see the dictionary")
    value: float = column("its value; empty where there is none", default=math.nan)
    low: float = column("lower end of its interval", default=math.nan)
    high: float = column("upper end of its interval", default=math.nan)
    n: int = column("observations that it stands on", default=0)
    censored: int = column("1: the value is only a lower bound, the trial ended first", default=0)
    why: str = column("why there is no value", default="")
    note: str = column("what to know beside the value", default="")


@dataclass(frozen=True, slots=True, kw_only=True)
class EventRow:
    """An event of a session; `events.tsv`, with the columns that BIDS asks for.

    In a dataset of BIDS each trial has a file of its own, whose onsets count from its begin.
    """

    onset: float = column("begin since the begin of the session", "s")
    duration: float = column("length; 0: a moment", "s", 0.0)
    trial_type: str = column("what happened")
    trial: int = column("number of the trial in the session, from 1; 0: outside", default=0)
    attempt: int = column("which attempt at this step, from 1; 0: outside", default=0)
    robot: str = column("the robot; empty: none", default="")
    value: str = column("what belongs to it, in words", default="")


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbeRow:
    """A question of a freeze that has a truth; `probes.csv`."""

    participant: int = column("number of the participant")
    trial: int = column("number of the trial in the session, from 1")
    attempt: int = column("which attempt at this trial, from 1", default=1)
    code: str = column("code of the condition")
    freeze: int = column("number of the freeze in the trial, from 1")
    robot: int = column("number of the robot in the layout, from 1", default=1)
    id: str = column("the question, by its name in the questionnaire")
    about: str = column("what the question asks for, by its name in docs/study-questions.md")
    level: int = column("1: perception, 2: comprehension, 3: projection")
    asked: float = column("when it was shown, since the begin of the trial", "s", math.nan)
    answered: float = column("when it was answered, since the begin of the trial", "s", math.nan)
    answer: str = column("the answer; a place as x and y in `map` [m]; empty: none", default="")
    truth: str = column("the right answer, in the same form")
    tolerance: float = column("largest error that is right, in the unit of the truth", default=0.0)
    correct: int = column("1: the answer is right; 0: it is wrong, or there is none", default=0)
    seconds: float = column("time from the question to the answer", "s", math.nan)


TABLES: dict[str, type[Any]] = {
    "trials.csv": TrialRow,
    "metrics.csv": MetricRow,
    "events.tsv": EventRow,
    "probes.csv": ProbeRow,
}
"""Tables by their file."""


def metric_rows(own: Mapping[str, Any], found: Mapping[str, Estimate]) -> list[MetricRow]:
    """The metrics of a trial as rows.

    Args:
        own: Participant, trial, attempt and code.
        found: The metrics by name.
    """
    return [
        MetricRow(
            **own,
            metric=name,
            value=float(each.value),
            low=each.low,
            high=each.high,
            n=each.n,
            censored=int(each.censored),
            why=each.why,
            note=each.note,
        )
        for name, each in found.items()
    ]
