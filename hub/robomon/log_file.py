"""One module's log file: it rotates, and survives full disks, deleted files and lost folders."""

from __future__ import annotations

import contextlib
import itertools
import logging
import math
import os
from pathlib import Path

_logger = logging.getLogger(__name__)

FILE_BYTES = 2_000_000
"""Size at which a new file starts."""
FILES = 3
"""Number of older files of each module, beside the present one."""
RETRY_S = 1.0
"""Pause before the next attempt at a file that could not be written [s]."""


class LogFile:
    """A file of whole lines; lines that cannot be written are lost and counted.

    A line at their place gives the number of lost lines, as soon as there is room. Older files have
    a number behind their name, 1 for the last.

    Attributes:
        lost: Lines lost since the start.
        reason: Reason for the last loss.
    """

    def __init__(self, path: Path) -> None:
        """Write to this path, without opening a file yet."""
        self._path = path
        self._file = -1
        self._room = 0
        self._retry_at = -math.inf
        self._missing = 0
        self.lost = 0
        self.reason = ""

    def write(self, text: str, now: float) -> None:
        """Add these lines; they are lost if the file has just failed."""
        lines = text.count("\n")
        if now < self._retry_at:
            self._lose(lines)
            return
        try:
            self._add(self._notice() + text)
        except OSError as error:
            self.close()
            self._retry_at = now + RETRY_S
            if not self._missing:
                _logger.error("the log file %s cannot be written: %s", self._path, error.strerror)
            self.reason = error.strerror or str(error)
            self._lose(lines)
        else:
            self._missing = 0

    def retry(self, now: float) -> None:
        """Write the pending notice of lost lines, if there is room at `now` [s]."""
        if self._missing:
            self.write("", now)

    def _lose(self, lines: int) -> None:
        self._missing += lines
        self.lost += lines

    def _notice(self) -> str:
        """A line with the number of lines lost before it; empty: none."""
        if not self._missing:
            return ""
        subject = f"{self._missing} lines were" if self._missing > 1 else "a line was"
        return f"({subject} lost here: {self.reason})\n"

    def _add(self, text: str) -> None:
        """Write the whole text or, after an error, nothing."""
        data = text.encode(errors="replace")
        self._prepare(len(data))
        written = 0
        try:
            while written < len(data):
                written += os.write(self._file, data[written:])
        except OSError:
            self._take_back(written)
            raise
        self._room -= written

    def _take_back(self, written: int) -> None:
        """Remove a partial text, so that the file ends with a whole line."""
        with contextlib.suppress(OSError):  # a pipe, or a file that is gone
            if written:
                os.ftruncate(self._file, os.fstat(self._file).st_size - written)

    def close(self) -> None:
        """Close the file."""
        if self._file >= 0:
            with contextlib.suppress(OSError):  # the failed write is reported already
                os.close(self._file)
            self._file = -1

    def _prepare(self, length: int) -> None:
        """Open a file with room, even after its removal."""
        if self._file >= 0 and os.fstat(self._file).st_nlink == 0:
            self.close()
        if self._file < 0:
            self._open()
        if length > self._room:
            self.close()
            self._rotate()
            self._open()

    def _open(self) -> None:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC | os.O_NONBLOCK
        self._file = os.open(self._path, flags, 0o666)
        self._room = FILE_BYTES - os.fstat(self._file).st_size

    def _rotate(self) -> None:
        names = [self._path, *(Path(f"{self._path}.{n}") for n in range(1, FILES + 1))]
        for newer, older in reversed(list(itertools.pairwise(names))):
            with contextlib.suppress(FileNotFoundError):
                newer.replace(older)
