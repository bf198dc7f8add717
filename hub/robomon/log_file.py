"""One module's log file: rotates, and outlives full disks, deleted files and lost folders."""

from __future__ import annotations

import contextlib
import itertools
import logging
import math
import os
from pathlib import Path

_logger = logging.getLogger(__name__)

FILE_BYTES = 2_000_000
"""Size from which on a new file is begun."""
FILES = 3
"""Older files that are kept of each module, beside the present one."""
RETRY_S = 1.0
"""Pause before a file that could not be written is tried again [s]."""


class LogFile:
    """A file that text is added to; what cannot be written is lost, and that is said once.

    The older ones have a number behind their name, 1 for the last.
    """

    def __init__(self, path: Path) -> None:
        """Write to this path; nothing is opened yet."""
        self._path = path
        self._file = -1
        self._room = 0
        self._retry_at = -math.inf
        self._failed = False

    def write(self, text: str, now: float) -> None:
        """Add this, unless the file could not be written a moment ago [s]."""
        if now < self._retry_at:
            return
        data = text.encode(errors="replace")
        try:
            self._prepare(len(data))
            self._room -= os.write(self._file, data)
        except OSError as error:
            self.close()
            self._retry_at = now + RETRY_S
            if not self._failed:
                self._failed = True
                _logger.error("the log file %s cannot be written: %s", self._path, error.strerror)
        else:
            self._failed = False

    def close(self) -> None:
        """Write no more."""
        if self._file >= 0:
            with contextlib.suppress(OSError):  # it has told already that it cannot be written
                os.close(self._file)
            self._file = -1

    def _prepare(self, length: int) -> None:
        """See that there is a file with room, also where somebody removed it."""
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
