"""Room on a disk that is kept for the index of a recording, so that a full disk leaves it whole."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path
from typing import IO, Final

_LEAST: Final = 64 * 1024
"""Room beside what the index has so far [bytes]: some chunks, and the facts of the end."""


class IndexRoom:
    """An unnamed file beside the recording; for one thread."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._file: IO[bytes] | None = None
        self._size = 0
        self._given_up = False

    def keep(self, index: int) -> None:
        """Keep room for an index of this length [bytes]; a disk that cannot is left alone."""
        wanted = index + _LEAST
        if self._given_up or wanted + _LEAST // 2 <= self._size:
            return
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile(dir=self._folder)  # noqa: SIM115 - `free` closes it
            os.posix_fallocate(self._file.fileno(), 0, 2 * wanted)
            self._size = 2 * wanted
        except OSError:
            self._given_up = True  # what it has stays

    def free(self) -> None:
        """Give the room back."""
        self._given_up = True
        if self._file is not None:
            with contextlib.suppress(OSError):
                self._file.close()
