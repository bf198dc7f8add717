"""Questions of freezes with their answers and truths, from a participant's journal and answers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from hub.values import dataclass
from rune_study.data.rows import ProbeRow
from rune_study.errors import DataError
from rune_study.metrics.awareness import AnswerKind, Query
from rune_study.questionnaires.answers import GivenAnswer
from rune_study.questionnaires.items import Answer
from rune_study.session.freezing import FROZEN, AskedQuery, occasion_of
from rune_study.session.journal import Record


@dataclass(frozen=True, slots=True, kw_only=True)
class Probe:
    """A question of a freeze, and what became of it.

    Attributes:
        freeze: Number of the freeze in the trial, from 1.
        asked: The question, with the right answer.
        given: The answer; None: the freeze was left before.
        query: The same as metrics take it.
    """

    freeze: int
    asked: AskedQuery
    given: GivenAnswer | None
    query: Query

    @property
    def value(self) -> Answer | None:
        """The answer; None: there is none."""
        return self.given.value if self.given is not None else None


def probes_of(
    records: Sequence[Record], step: str, attempt: int, answers: Sequence[GivenAnswer]
) -> list[Probe]:
    """The questions of all freezes of an attempt at a trial.

    Args:
        records: Of the journal, of this attempt.
        step: Name of the trial.
        attempt: Its number.
        answers: All answers of the participant.

    Raises:
        DataError: A record has another form.
    """
    given = {(each.occasion, each.item): each for each in answers}
    found = []
    for record in records:
        if record.what != FROZEN:
            continue
        freeze = record.data.get("number")
        if not isinstance(freeze, int):
            raise _wrong()
        for asked in _asked(record):
            occasion = occasion_of(step, attempt, freeze)
            answer = given.get((occasion, asked.id))
            found.append(
                Probe(
                    freeze=freeze,
                    asked=asked,
                    given=answer,
                    query=asked.query(answer.value if answer is not None else None),
                )
            )
    return found


def rows_of(own: dict[str, Any], begin: float, probes: Sequence[Probe]) -> Iterator[ProbeRow]:
    """Questions as rows of a table.

    Args:
        own: Participant, trial, attempt and code.
        begin: Begin of the trial on the monotonic clock [s].
        probes: The questions.
    """
    for each in probes:
        answered = each.given.moment - begin if each.given is not None else math.nan
        seconds = each.given.seconds if each.given is not None else math.nan
        yield ProbeRow(
            **own,
            freeze=each.freeze,
            robot=each.asked.robot,
            id=each.asked.id,
            about=each.asked.truth,
            level=each.asked.level,
            asked=round(answered - seconds, 3),
            answered=round(answered, 3),
            answer=in_words(each.value),
            truth=in_words(each.asked.right),
            tolerance=each.asked.tolerance,
            correct=int(each.query.right),
            seconds=seconds,
        )


def in_words(value: Answer | None) -> str:
    """An answer or a truth in a cell: a place as x and y with a blank between; empty: none."""
    if value is None:
        return ""
    return " ".join(map(repr, value)) if isinstance(value, tuple) else str(value)


def _asked(record: Record) -> Iterator[AskedQuery]:
    listed = record.data.get("queries", [])
    if not isinstance(listed, list):
        raise _wrong()
    for each in listed:
        try:
            right = each["right"]
            asked = AskedQuery(
                **{**each, "right": tuple(right) if isinstance(right, list) else right}
            )
            fits = asked.kind in tuple(AnswerKind) and asked.level in (1, 2, 3)
            fits &= isinstance(asked.id, str)
        except (TypeError, KeyError) as fault:
            raise _wrong() from fault
        if not fits or not isinstance(asked.tolerance, int | float):
            raise _wrong()
        yield asked


def _wrong() -> DataError:
    return DataError("the truths of a freeze have another form; was the journal changed?")
