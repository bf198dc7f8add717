"""The queue of a mission's records for the disk."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from hub.missions import room
from hub.missions.journal import encode
from hub.missions.journal_file import JournalFile
from hub.missions.records import Marked, Record, SheetBegun, to_json

MAX_PENDING = 2000
"""Length of the queue; beyond, only sheets, frames and the begin are taken."""
_MOST_NAMED = 10
"""Largest number of marks that a text lists."""


class Pending:
    """The records in memory only, in their order."""

    def __init__(self) -> None:
        self._records: list[Record] = []
        self._bytes = 0

    def __len__(self) -> int:
        return len(self._records)

    @property
    def marks(self) -> frozenset[int]:
        """Numbers of the marks in the queue."""
        return frozenset(r.point.number for r in self._records if isinstance(r, Marked))

    def refusal(self, record: Record, journal: JournalFile | None, fault: str) -> str:
        """Why a record is refused; empty: it is not.

        Args:
            record: The record.
            journal: The journal; None: it is not made yet.
            fault: Why records wait.
        """
        if room.always_taken(record):
            return ""
        if len(self._records) >= MAX_PENDING:
            return f"too much waits for the disk: {fault}"
        size = (journal.size if journal else 0) + self._bytes + _length(record)
        count = (journal.count if journal else 0) + len(self._records) + 1
        if room.fits(record, size, count):
            return ""
        return "the journal of this mission has no room for it: end the mission and begin another"

    def add(self, records: Sequence[Record]) -> None:
        """Add records to the queue.

        Beyond its length a sheet replaces the sheet before it: there are no marks between them.
        """
        for record in records:
            last = self._records[-1] if len(self._records) >= MAX_PENDING else None
            added = record
            if isinstance(record, SheetBegun) and isinstance(last, SheetBegun):
                self._bytes -= _length(self._records.pop())
                added = dataclasses.replace(record, carries=record.carries and last.carries)
            self._records.append(added)
            self._bytes += _length(added)

    def write(self, journal: JournalFile) -> None:
        """Write the queue, all or nothing.

        Raises:
            MissionFileError: It cannot be written, and is kept.
        """
        if self._records:
            journal.append([to_json(record) for record in self._records])
            self.clear()

    def clear(self) -> None:
        """Clear the queue."""
        self._records.clear()
        self._bytes = 0


def marks_text(numbers: frozenset[int]) -> str:
    """Numbers of marks for people, the first ones if there are many; empty if there are none."""
    if not numbers:
        return ""
    text = ", ".join(map(str, sorted(numbers)[:_MOST_NAMED]))
    return f" (marks {text}{' and more' if len(numbers) > _MOST_NAMED else ''})"


def _length(record: Record) -> int:
    """Of a record in the journal [bytes]."""
    return len(encode(to_json(record)))
