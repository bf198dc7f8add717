"""The note on the disk about the recording that an order began, so that it outlives a crash."""

from __future__ import annotations

import json
import logging
import math
import time
from pathlib import Path
from typing import Final

from hub import files

_logger = logging.getLogger(__name__)

_LARGEST: Final = 100_000
"""Longest note [bytes]."""


def read_running(note: Path) -> tuple[Path, str, float]:
    """The first file of the recording that ran, its operator, and its start [s since the epoch].

    Raises:
        OSError, ValueError, KeyError, TypeError, RecursionError: It cannot be read, or is damaged.
    """
    kept = json.loads(files.read_regular(note, _LARGEST))
    begun = float(kept["begun"])
    return Path(str(kept["path"])), str(kept["by"]), begun if math.isfinite(begun) else 0.0


def note_running(note: Path, first: Path | None, by: str) -> str:
    """Note which recording an order began; None: none runs.

    Returns:
        Why a crash would end the recording, in a sentence; empty: it would not.
    """
    try:
        if first is None:
            note.unlink(missing_ok=True)
            return ""
        kept = {"path": str(first), "by": by, "begun": time.time()}
        files.replace(note, json.dumps(kept).encode())
    except OSError as error:
        text = f"a crash would end the recording: {note} cannot be written ({error.strerror})"
        _logger.warning("%s", text)
        return text
    return ""
