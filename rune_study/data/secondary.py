"""The secondary task of a trial, and that of the session without a robot, from the journal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from hub.values import dataclass
from rune_study.metrics.trial import Secondary
from rune_study.plan.steps import SECONDARY, Step
from rune_study.session.journal import BEGIN, DONE, Record
from rune_study.session.secondary import ANSWERED


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskScore:
    """How a person did in the secondary task.

    Attributes:
        seconds: Time in which it asked [s].
        asked: Questions that could be answered.
        correct: Correct answers.
        missed: Questions without an answer.
        times: Time from a question to its correct answer [s].
    """

    seconds: float = 0.0
    asked: int = 0
    correct: int = 0
    missed: int = 0
    times: tuple[float, ...] = ()


def score_of(records: Sequence[Record], seconds: float) -> TaskScore:
    """The questions of a part of a session.

    Args:
        records: Of the journal.
        seconds: Length of the part without pauses [s].
    """
    asked = [
        each.data
        for each in records
        if each.what == ANSWERED and each.data.get("counts", True) is True
    ]
    right = [each for each in asked if each.get("correct") is True]
    times = (each.get("seconds") for each in right)
    return TaskScore(
        seconds=seconds,
        asked=len(asked),
        correct=len(right),
        missed=sum(each.get("key") is None for each in asked),
        times=tuple(float(each) for each in times if isinstance(each, int | float)),
    )


def alone_of(records: Sequence[Record], steps: Mapping[int, Step]) -> TaskScore:
    """All steps of a session with the task alone that were completed, together."""
    seconds, own = 0.0, list[Record]()
    part: list[Record] = []
    for each in records:
        step = steps.get(int(each.data["n"])) if isinstance(each.data.get("n"), int) else None
        if step is None or step.kind != SECONDARY:
            continue
        if each.what == BEGIN:
            part = []
        elif each.what == DONE:
            length = each.data.get("result", {}).get("seconds", math.nan)
            if isinstance(length, int | float) and length > 0.0:
                seconds += length
                own += part
        else:
            part.append(each)
    return score_of(own, seconds)


def secondary_of(beside: TaskScore, alone: TaskScore) -> Secondary | None:
    """What metrics take; None: nothing was asked beside the robot."""
    if not beside.asked:
        return None
    return Secondary(
        correct=beside.correct,
        seconds=beside.seconds,
        correct_alone=alone.correct,
        seconds_alone=alone.seconds,
        asked=beside.asked,
        missed=beside.missed,
        times=beside.times,
    )
