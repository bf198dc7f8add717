"""Answers of one person: each is on the disk before the next question is shown."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from hub.errors import MapFileError, MissionFileError
from hub.missions import journal_file
from hub.values import dataclass
from rune_study.errors import AnswersError
from rune_study.questionnaires.items import Answer, Item
from rune_study.questionnaires.questionnaire import Questionnaire


@dataclass(frozen=True, slots=True, kw_only=True)
class GivenAnswer:
    """An answer.

    Attributes:
        questionnaire: The questionnaire's name.
        occasion: When in the session it was asked, such as "t3".
        item: The item's id.
        value: The answer, as the item's kind has it.
        at: When it was given [s since 1970].
        seconds: Time between the question and the answer [s].
    """

    questionnaire: str
    occasion: str
    item: str
    value: Answer
    at: float
    seconds: float


class Answers:
    """An open file of answers, which one process writes."""

    def __init__(self, path: Path) -> None:
        """Open or create it; what a crash left of the last answer is removed.

        Raises:
            AnswersError: It cannot be used.
        """
        self._path = path
        self._given: dict[tuple[str, str, str], GivenAnswer] = {}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            reading = journal_file.read(path, self._take) if path.exists() else None
            self._file = journal_file.JournalFile(path, reading)
        except (MissionFileError, OSError) as fault:
            text = f"{path}: {fault}"
            raise AnswersError(text) from fault

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()

    def of(self, questionnaire: Questionnaire, occasion: str) -> dict[str, Answer]:
        """The answers that are there, by item.

        Raises:
            AnswersError: One does not fit its item: the questionnaire was changed.
        """
        found: dict[str, Answer] = {}
        for item in questionnaire.items:
            given = self._given.get((questionnaire.name, occasion, item.id))
            if given is not None:
                if not item.accepts(given.value):
                    text = (
                        f"{self._path}: {given.value!r} is no answer to {item.id} of "
                        f"{questionnaire.name}; was the questionnaire changed?"
                    )
                    raise AnswersError(text)
                found[item.id] = given.value
        return found

    def all(self) -> list[GivenAnswer]:
        """Every answer, in the order in which they were given."""
        return sorted(self._given.values(), key=lambda given: given.at)

    def give(
        self,
        questionnaire: Questionnaire,
        occasion: str,
        item: Item,
        value: Answer,
        seconds: float,
    ) -> None:
        """Write an answer; it is on the disk when this returns.

        Raises:
            AnswersError: The disk refuses, or the value is no answer to the item.
        """
        if not item.accepts(value):
            text = f"{value!r} is no answer to {item.id} of {questionnaire.name}"
            raise AnswersError(text)
        given = GivenAnswer(
            questionnaire=questionnaire.name,
            occasion=occasion,
            item=item.id,
            value=value,
            at=time.time(),
            seconds=round(seconds, 3),
        )
        record = {name: getattr(given, name) for name in GivenAnswer.__dataclass_fields__}
        try:
            self._file.append([record])
        except MissionFileError as fault:
            text = f"{self._path}: {fault}"
            raise AnswersError(text) from fault
        self._take(record)

    def _take(self, record: dict[str, Any]) -> None:
        """Take one record of the file; others' records are left out."""
        try:
            given = GivenAnswer(**record)
        except TypeError:
            return
        self._given[given.questionnaire, given.occasion, given.item] = given


def read_answers(path: Path) -> list[GivenAnswer]:
    """The answers of a file that another process may be writing; the last of each item counts.

    Raises:
        AnswersError: It cannot be read.
    """
    given: dict[tuple[str, str, str], GivenAnswer] = {}

    def take(record: dict[str, Any]) -> None:
        with contextlib.suppress(TypeError):
            each = GivenAnswer(**record)
            given[each.questionnaire, each.occasion, each.item] = each

    try:
        journal_file.read(path, take)
    except (MissionFileError, MapFileError, OSError) as fault:
        text = f"{path}: {fault}"
        raise AnswersError(text) from fault
    return list(given.values())
