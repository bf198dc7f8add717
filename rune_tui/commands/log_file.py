"""The log of the commands of `rune`, in the user's log folder."""

from __future__ import annotations

import logging
import logging.handlers
import os
import sys
from pathlib import Path
from typing import NamedTuple

from hub.plain_text import plain

_LOG_BYTES = 1_000_000


class LogFile(NamedTuple):
    """The log file.

    Attributes:
        path: The file; the null device if none can be written.
        trouble: Why there is no log file, in one sentence; else empty.
    """

    path: Path
    trouble: str = ""


def log_to_file() -> LogFile:
    """Write the log to the user's log folder; if that fails, report it and continue without."""
    import platformdirs

    folder = Path(platformdirs.user_log_dir("rune", appauthor=False))
    handler: logging.Handler
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "rune.log"
        handler = logging.handlers.RotatingFileHandler(
            path, maxBytes=_LOG_BYTES, backupCount=2, encoding="utf-8"
        )
        log = LogFile(path)
    except OSError as error:
        log = LogFile(Path(os.devnull), f"no log is kept: {folder}: {error.strerror}")
        handler = logging.NullHandler()
        sys.stderr.write(f"rune: {plain(log.trouble)}\n")
    handler.setFormatter(logging.Formatter("%(asctime)s console %(levelname)s %(message)s"))
    logging.basicConfig(level=logging.INFO, handlers=[handler])
    logging.raiseExceptions = False  # the errors of a full disk must not appear in the picture
    return log
