"""What is wrong with the files of participants, and does not stop the work."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from rune_study.plan.folder import participant_folder
from rune_study.plan.study_spec import StudySpec
from rune_study.session.freezing import ANSWERS
from rune_study.session.journal import JOURNAL, damaged_lines, head_of, read_journal

PRIVATE = "private.log"
"""Answers that stay out of the study's data, such as consent."""


def warnings_of(study: StudySpec, participants: Iterable[int]) -> Iterator[str]:
    """Damaged lines, other studies and other participants in these participants' files.

    Yields:
        A sentence each.

    Raises:
        StudyError: A file cannot be read.
    """
    for participant in participants:
        folder = participant_folder(study.folder, participant)
        files = [folder / name for name in (JOURNAL, ANSWERS, PRIVATE)]
        yield from (line for path in files if path.exists() for line in _damage(path))
        head = head_of(read_journal(folder / JOURNAL)) if (folder / JOURNAL).exists() else None
        if head is not None and head.data["study"] != study.digest:
            yield (
                f"participant {participant} began with another version of the study: its data and "
                "those of others may not be comparable"
            )
        if head is not None and head.data.get("participant", participant) != participant:
            yield f"{folder} has the session of participant {head.data['participant']}"


def _damage(path: Path) -> Iterator[str]:
    damaged = damaged_lines(path)
    if damaged:
        lines = "1 line of {} is" if damaged == 1 else f"{damaged} lines of {{}} are"
        yield f"{lines.format(path)} damaged, and left out"
