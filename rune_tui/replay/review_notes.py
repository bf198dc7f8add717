"""What people note while they look at a recording: a file beside it, never the recording itself.

`FILE.notes.jsonl` has a JSON object a line: `stamp` [ns since 1970], `time`, `by`, `text`.
"""

from __future__ import annotations

import datetime
import json
import os
from pathlib import Path
from typing import Final

from hub import files
from hub.errors import MapFileError
from hub.plain_text import plain
from rune_tui.errors import LogError
from rune_tui.replay.source import EventKind, ReplayEvent

SUFFIX: Final = ".notes.jsonl"
LONGEST: Final = 200
"""Most letters of a note."""
_MOST_BYTES: Final = 4 << 20
_MOST_STAMP: Final = 1 << 63


class ReviewNotes:
    """The notes of a recording.

    Attributes:
        path: Their file; it is there from the first note on.
        events: The notes.
        fault: What of the file cannot be read, in one sentence; empty: nothing.
    """

    def __init__(self, recording: Path) -> None:
        """Read the notes of a recording: a file or a folder."""
        place = recording.absolute()
        self.path = place.with_name(f"{place.name}{SUFFIX}")
        self.events: list[ReplayEvent] = []
        self.fault = ""
        if self.path.exists():
            self._read()

    def _read(self) -> None:
        try:
            text = files.read(self.path, _MOST_BYTES).decode()
        except (MapFileError, UnicodeDecodeError) as error:
            self.fault = f"the notes in {self.path.name} cannot be read: {error}"
            return
        lines = [line for line in text.splitlines() if line.strip()]
        self.events = [event for event in map(_event, lines) if event is not None]
        if damaged := len(lines) - len(self.events):
            self.fault = f"{damaged} of {len(lines)} lines of {self.path.name} are no notes"

    def add(self, stamp: int, text: str, by: str) -> ReplayEvent:
        """Keep a note.

        Args:
            stamp: Its time in the recording [ns since 1970].
            text: What it says.
            by: Who says it.

        Raises:
            LogError: It is empty, or the file cannot be written.
        """
        text = plain(text.strip())[:LONGEST]
        if not text:
            reason = "a note without words is not kept"
            raise LogError(reason)
        moment = datetime.datetime.fromtimestamp(stamp / 1e9, datetime.UTC)
        values = {"stamp": stamp, "time": moment.isoformat(), "by": by, "text": text}
        try:
            with self.path.open("ab+") as file:
                file.seek(0, os.SEEK_END)
                if file.tell():
                    file.seek(-1, os.SEEK_END)
                    torn = file.read(1) != b"\n"
                    file.write(b"\n" * torn)
                file.write(json.dumps(values, ensure_ascii=False).encode() + b"\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            reason = f"the note is not kept: {self.path} cannot be written: {error.strerror}"
            raise LogError(reason) from error
        event = ReplayEvent(stamp=stamp, kind=EventKind.NOTE, text=text)
        self.events.append(event)
        return event


def _event(line: str) -> ReplayEvent | None:
    """The note of a line; None: it is none."""
    try:
        values = json.loads(line)
        stamp, text = values["stamp"], values["text"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    if type(stamp) is not int or not 0 <= stamp < _MOST_STAMP or not isinstance(text, str):
        return None
    return ReplayEvent(stamp=stamp, kind=EventKind.NOTE, text=plain(text)[:LONGEST])
