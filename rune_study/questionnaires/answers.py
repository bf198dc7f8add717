"""Answers of one person: each is on the disk before the next question is shown."""

from __future__ import annotations

import math
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from hub.errors import MapFileError, MissionFileError
from hub.missions import journal_file
from hub.values import dataclass
from rune_study.errors import AnswersError
from rune_study.questionnaires.items import Answer, ComparedItem, Item
from rune_study.questionnaires.questionnaire import Questionnaire


@dataclass(frozen=True, slots=True, kw_only=True)
class GivenAnswer:
    """An answer.

    Attributes:
        questionnaire: The questionnaire's name.
        occasion: When in the session it was asked, such as "t3".
        item: The item's id.
        value: The answer, as the item's kind has it; None: the person does not know.
        at: When it was given [s since 1970].
        seconds: Time between the question and the answer [s].
        moment: When it was given, on the monotonic clock of the machine [s].
    """

    questionnaire: str
    occasion: str
    item: str
    value: Answer | None
    at: float
    seconds: float
    moment: float = math.nan


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

    def of(self, questionnaire: Questionnaire, occasion: str) -> dict[str, Answer | None]:
        """The answers that are there, by item; None: the person does not know.

        Raises:
            AnswersError: One does not fit its item: the questionnaire was changed.
        """
        found: dict[str, Answer | None] = {}
        for item in questionnaire.items:
            given = self._given.get((questionnaire.name, occasion, item.id))
            if given is not None:
                if not _fits(item, given.value):
                    text = (
                        f"{self._path}: {given.value!r} is no answer to {item.id} of "
                        f"{questionnaire.name}; was the questionnaire changed?"
                    )
                    raise AnswersError(text)
                found[item.id] = given.value
        return found

    def all(self) -> list[GivenAnswer]:
        """Every answer, in the order in which they were given first."""
        return list(self._given.values())

    def give(
        self,
        questionnaire: Questionnaire,
        occasion: str,
        item: Item,
        value: Answer | None,
        seconds: float,
    ) -> GivenAnswer:
        """Write an answer, which it returns; it is on the disk then.

        Raises:
            AnswersError: The disk refuses, or the value is no answer to the item.
        """
        if not _fits(item, value):
            text = f"{value!r} is no answer to {item.id} of {questionnaire.name}"
            raise AnswersError(text)
        given = GivenAnswer(
            questionnaire=questionnaire.name,
            occasion=occasion,
            item=item.id,
            value=value,
            at=time.time(),
            seconds=round(seconds, 3),
            moment=time.monotonic(),
        )
        record = {name: getattr(given, name) for name in GivenAnswer.__dataclass_fields__}
        try:
            self._file.append([record])
        except MissionFileError as fault:
            text = f"{self._path}: {fault}"
            raise AnswersError(text) from fault
        self._take(record)
        return given

    def _take(self, record: dict[str, Any]) -> None:
        """Take one record of the file; others' records are left out."""
        given = _given(record)
        if given is not None:
            self._given[given.questionnaire, given.occasion, given.item] = given


def read_answers(path: Path) -> list[GivenAnswer]:
    """The answers of a file that another process may be writing; the last of each item counts.

    Raises:
        AnswersError: It cannot be read.
    """
    given: dict[tuple[str, str, str], GivenAnswer] = {}

    def take(record: dict[str, Any]) -> None:
        each = _given(record)
        if each is not None:
            given[each.questionnaire, each.occasion, each.item] = each

    try:
        journal_file.read(path, take)
    except (MissionFileError, MapFileError, OSError) as fault:
        text = f"{path}: {fault}"
        raise AnswersError(text) from fault
    return list(given.values())


def _given(record: dict[str, Any]) -> GivenAnswer | None:
    """The answer of a record; None: it is none. JSON has places as lists."""
    value = record.get("value")
    own = {**record, "value": tuple(value)} if isinstance(value, list) else record
    words = ("questionnaire", "occasion", "item")
    try:
        given = GivenAnswer(**own)
    except TypeError:
        return None
    whole = all(isinstance(getattr(given, name), str) for name in words)
    timed = all(isinstance(each, int | float) for each in (given.at, given.seconds, given.moment))
    return given if whole and timed else None


def _fits(item: Item, value: object) -> bool:
    """Whether a value answers an item; who does not know a truth may say so."""
    unknown = value is None and isinstance(item, ComparedItem) and bool(item.truth)
    return unknown or item.accepts(value)
