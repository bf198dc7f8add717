"""The journal of a session: what was begun, done and noted; it says where a session goes on.

| record | when |
| --- | --- |
| `session` | first of all: the study's checksum, the participant |
| `begin` | a step begins; `attempt` counts from 1 |
| `done` | the step is done; its result |
| `declined` | the participant does not agree to take part: the session is over |
| any other | within the step that was begun last |

Each record is on the disk before the next action. A line that a crash cut short counts as not
written, so its step begins again as a further attempt; the files of earlier attempts stay.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from hub.errors import MissionFileError
from hub.missions import journal_file
from hub.values import dataclass
from rune_study.errors import ChangedStudyError, StudyError
from rune_study.plan.folder import participant_folder
from rune_study.plan.study_spec import MOST_PARTICIPANTS, StudySpec

JOURNAL = "journal.log"
SESSION, BEGIN, DONE, DECLINED = "session", "begin", "done", "declined"
_SAME = {"what", "at", "moment"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """A line of a journal.

    Attributes:
        what: Its kind.
        at: When [s since 1970].
        moment: The same on the monotonic clock of this machine [s].
        data: The rest.
    """

    what: str
    at: float
    moment: float
    data: dict[str, Any]


class Journal:
    """The open journal of a participant, which one process writes.

    Attributes:
        path: Its file.
        records: All records so far, in their order.
    """

    def __init__(self, path: Path) -> None:
        """Open or create it, and remove what a crash left of the last line.

        Raises:
            StudyError: It cannot be used.
        """
        self.path = path
        self.records: list[Record] = []
        self._listeners: list[Callable[[Record], None]] = []
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._lock = _locked(path.parent)
        except OSError as fault:
            text = f"{path}: {fault}"
            raise StudyError(text) from fault
        try:
            reading = journal_file.read(path, self._take) if path.exists() else None
            self._file = journal_file.JournalFile(path, reading)
        except (MissionFileError, OSError) as fault:
            os.close(self._lock)
            text = f"{path}: {fault}"
            raise StudyError(text) from fault

    @classmethod
    def of(cls, study: StudySpec, participant: int, replaces: int = 0) -> Self:
        """The journal of a participant; a new one begins with the study's checksum.

        Raises:
            ChangedStudyError: A session of the study began with another version of it, or this
                one as another replacement, or the folder is that of another participant.
            StudyError: It cannot be used.
        """
        journal = cls(participant_folder(study.folder, participant) / JOURNAL)
        begun = head_of(journal.records)
        try:
            if begun is None:
                _refuse_changed(study, participant)
                head = {"study": study.digest, "participant": participant, "replaces": replaces}
                journal.put(SESSION, **head)
            else:
                _refuse_other(begun, study, participant, replaces)
        except StudyError:
            journal.close()
            raise
        return journal

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def replaces(self) -> int:
        """The participant whose order this one took over; 0: none."""
        return next(
            (int(each.data["replaces"]) for each in self.records if each.what == SESSION), 0
        )

    @property
    def declined(self) -> bool:
        """Whether the participant did not agree to take part."""
        return has_declined(self.records)

    def done(self) -> set[int]:
        """Numbers of the steps that are done."""
        return {int(each.data["n"]) for each in self.records if each.what == DONE}

    def attempts(self, number: int) -> int:
        """How often a step was begun."""
        return sum(each.what == BEGIN and each.data["n"] == number for each in self.records)

    def put(self, what: str, **data: Any) -> None:  # noqa: ANN401 - what JSON has
        """Add a record; it is on the disk when this returns.

        Raises:
            StudyError: The disk refuses.
        """
        line = {"what": what, "at": time.time(), "moment": time.monotonic(), **data}
        try:
            self._file.append([line])
        except (MissionFileError, ValueError) as fault:
            text = f"{fault}; free some space, then run the session again"
            raise StudyError(text) from fault
        self._take(line)
        for each in self._listeners:
            each(self.records[-1])

    @contextlib.contextmanager
    def heard_by(self, listener: Callable[[Record], None]) -> Iterator[None]:
        """Call a function with each record that is put within the context."""
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    def close(self) -> None:
        """Close the file, so that another process may go on."""
        self._file.close()
        os.close(self._lock)

    def _take(self, line: dict[str, Any]) -> None:
        record = record_of(line)
        if record is not None:
            self.records.append(record)


def participants_of(study: StudySpec) -> list[int]:
    """Participants who have a journal."""
    found = (path.name.removeprefix("sub-") for path in study.folder.glob("sub-*"))
    numbers = (int(each) for each in found if each.isdecimal() and len(each) < 6)
    inside = (each for each in numbers if 1 <= each <= MOST_PARTICIPANTS)
    return sorted(each for each in inside if journal_path(study.folder, each).exists())


def journal_path(folder: Path, participant: int) -> Path:
    """The journal of a participant."""
    return participant_folder(folder, participant) / JOURNAL


def head_of(records: Sequence[Record]) -> Record | None:
    """The record with which a session began; None: it has not begun."""
    return next((each for each in records if each.what == SESSION), None)


def has_declined(records: Sequence[Record]) -> bool:
    """Whether the participant did not agree to take part."""
    return any(each.what == DECLINED for each in records)


def pauses_of(records: Sequence[Record]) -> list[tuple[float, float]]:
    """Begin and end of the freezes and pauses of a trial that are over [s, monotonic clock]."""
    pauses: list[tuple[float, float]] = []
    since: float | None = None
    for each in records:
        order = each.data.get("do") if each.what == "order" else None
        if each.what == "frozen" or order == "pause":
            since = each.moment
        elif (each.what == "unfrozen" or order == "begin") and since is not None:
            pauses.append((since, each.moment))
            since = None
    return pauses


def _locked(folder: Path) -> int:
    """A handle that locks a folder until it is closed, or this process ends.

    Raises:
        StudyError: Another process has it.
    """
    handle = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as fault:
        os.close(handle)
        text = f"the session in {folder} runs in another terminal; go on there, or end it first"
        raise StudyError(text) from fault
    return handle


def read_journal(path: Path) -> list[Record]:
    """The records of a journal that another process may be writing.

    Raises:
        StudyError: It cannot be read.
    """
    found: list[Record] = []

    def take(line: dict[str, Any]) -> None:
        record = record_of(line)
        if record is not None:
            found.append(record)

    try:
        journal_file.read(path, take)
    except MissionFileError as fault:
        raise StudyError(str(fault)) from fault
    return found


def damaged_lines(path: Path) -> int:
    """How many lines of a journal, or of another file of its form, cannot be read.

    Raises:
        StudyError: The file cannot be read.
    """
    try:
        return journal_file.read(path, lambda _: None).damaged
    except MissionFileError as fault:
        raise StudyError(str(fault)) from fault


def record_of(line: dict[str, Any]) -> Record | None:
    """The record of a line; None: it is none."""
    what, at, moment = (line.get(name) for name in ("what", "at", "moment"))
    if not (isinstance(what, str) and isinstance(at, float) and isinstance(moment, float)):
        return None
    data = {name: value for name, value in line.items() if name not in _SAME}
    numbers = ("n", "attempt") if what == BEGIN else ("n",)
    numbered = all(isinstance(data.get(name), int) for name in numbers)
    headed = isinstance(data.get("study"), str) and isinstance(data.get("replaces"), int)
    if (what in (BEGIN, DONE) and not numbered) or (what == SESSION and not headed):
        return None
    return Record(what=what, at=at, moment=moment, data=data)


def _refuse_changed(study: StudySpec, participant: int) -> None:
    """Refuse a first session with a study that others began differently."""
    for other in participants_of(study):
        head = None
        with contextlib.suppress(StudyError):  # `status` says what is wrong with that file
            head = head_of(read_journal(journal_path(study.folder, other)))
        if other != participant and head is not None and head.data["study"] != study.digest:
            text = (
                f"the study was changed after the session of participant {other} began; "
                f"undo the change, or move the earlier sessions out of {study.folder}"
            )
            raise ChangedStudyError(text)


def _refuse_other(begun: Record, study: StudySpec, participant: int, replaces: int) -> None:
    if begun.data.get("participant", participant) != participant:
        text = (
            f"{participant_folder(study.folder, participant)} has the session of participant "
            f"{begun.data['participant']}; give the folder its own name again"
        )
        raise ChangedStudyError(text)
    if begun.data["study"] != study.digest:
        text = (
            f"the study was changed after the session of participant {participant} began; undo "
            "the change, or copy the folder and begin a study of its own"
        )
        raise ChangedStudyError(text)
    if replaces not in (0, begun.data["replaces"]):
        text = f"participant {participant} began in the place of {begun.data['replaces'] or 'none'}"
        raise ChangedStudyError(text)
