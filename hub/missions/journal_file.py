"""A journal on the disk: records are added at its end, and are there after a crash."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from hub import files
from hub.errors import MapFileError, MissionFileError
from hub.missions import journal

MAX_BYTES = 64 << 20
"""Largest size of a journal; a larger one is neither written nor read."""
MAX_RECORDS = 100_000
"""The same; a reader needs a few seconds for the largest number."""


class JournalFile:
    """An open journal, which one process writes.

    Attributes:
        count: Records in it, and stretches that are damaged.
    """

    def __init__(
        self, path: Path, reading: journal.Reading | None = None, *, sync: bool = True
    ) -> None:
        """Open or create it, and remove an unfinished line of a crash.

        Args:
            path: The file; its folder has to be there.
            reading: What the file holds; None: it is read here.
            sync: Whether each `append` waits for the disk; else `sync` does.

        Raises:
            MissionFileError: It cannot be opened or read.
        """
        self._path = path
        self._waits = sync
        if reading is None:
            reading = read(path, _drop) if path.exists() else journal.NOTHING
        self.count, self._length = reading.count + reading.damaged, reading.end
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as fault:
            raise MissionFileError(_problem(path, fault)) from fault
        try:
            self._repair()
        except OSError as fault:
            self.close()
            raise MissionFileError(_problem(path, fault)) from fault
        files.sync_folder(path.parent)

    def append(self, records: Sequence[dict[str, Any]]) -> None:
        """Add records, all or none; they are on the disk when this returns.

        Raises:
            MissionFileError: They cannot be written; what is in the journal already stays.
            ValueError: One of them is no record of a journal.
        """
        lines = b"".join(map(journal.encode, records))
        full = self._length + len(lines) > MAX_BYTES or self.count + len(records) > MAX_RECORDS
        if full:
            text = (
                f"{self._path} is full: a journal has {MAX_BYTES >> 20} MB"
                f" and {MAX_RECORDS} records at most"
            )
            raise MissionFileError(text)
        try:
            rest = memoryview(lines)
            at = self._length
            while rest:
                written = os.pwrite(self._file, rest, at)
                rest, at = rest[written:], at + written
            if self._waits:
                os.fsync(self._file)
        except OSError as fault:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._length)
            raise MissionFileError(_problem(self._path, fault)) from fault
        self._length += len(lines)
        self.count += len(records)

    def sync(self) -> None:
        """Wait until all records are on the disk.

        Raises:
            MissionFileError: The disk refuses.
        """
        try:
            os.fsync(self._file)
        except OSError as fault:
            raise MissionFileError(_problem(self._path, fault)) from fault

    @property
    def size(self) -> int:
        """Of the file [bytes]."""
        return self._length

    def close(self) -> None:
        """Close the file."""
        with contextlib.suppress(OSError):
            os.close(self._file)

    def _repair(self) -> None:
        """Remove an unfinished line at the end, and end the last line if that was cut."""
        if os.fstat(self._file).st_size > self._length:
            os.ftruncate(self._file, self._length)
        if self._length and os.pread(self._file, 1, self._length - 1) != b"\n":
            os.pwrite(self._file, b"\n", self._length)
            self._length += 1


def read(path: Path, take: Callable[[dict[str, Any]], object]) -> journal.Reading:
    """Read a journal record by record.

    Args:
        path: The file.
        take: Called with each readable record, in order.

    Raises:
        MissionFileError: It cannot be read, is no regular file of at most `MAX_BYTES`, or has
            more than `MAX_RECORDS`.
    """
    try:
        raw = files.read(path, MAX_BYTES)
    except MapFileError as error:
        raise MissionFileError(str(error)) from error
    try:
        return journal.decode(raw, take, MAX_RECORDS)
    except MissionFileError as error:
        text = f"{path} {error}"
        raise MissionFileError(text) from error


def _drop(record: dict[str, Any]) -> None:
    """Ignore a record."""


def _problem(path: Path, fault: OSError) -> str:
    return f"{path} cannot be written: {fault.strerror or fault}"
