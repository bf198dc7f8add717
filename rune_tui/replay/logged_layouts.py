"""Layouts out of recordings: their files are attachments, and no code in them runs."""

from __future__ import annotations

import dataclasses
import tempfile
from pathlib import Path, PurePosixPath

from hub.errors import RecordingError
from hub.recording.recording_set import RecordingSet
from rune_tui.errors import LayoutError, LogError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.own_records import LayoutRecord
from rune_tui.startup.opening import open_layout

_LARGEST = 16 << 20
"""Longest file of a layout that is taken out of a recording [bytes]."""
_MOST = 200
"""Most files of a layout."""


class LoggedLayouts:
    """Opens the layouts of a recording."""

    def __init__(self, recording: RecordingSet) -> None:
        self._recording = recording
        self._places = {place.name: place for place in recording.attachments}
        self._opened: dict[tuple[str, str], LayoutSpec] = {}

    def open(self, record: LayoutRecord) -> LayoutSpec:
        """The layout of a record.

        Raises:
            LogError: It cannot be opened; the reason says what to do.
        """
        key = record.sha256, repr(record.variables)
        if key not in self._opened:
            try:
                self._opened[key] = self._read(record)
            except LayoutError as error:
                reason = f"the recorded layout {record.layout} cannot be opened: {error}"
                raise LogError(reason) from error
        return self._opened[key]

    def _read(self, record: LayoutRecord) -> LayoutSpec:
        if not record.files or len(record.files) > _MOST:
            reason = f"the recording has no files of {record.layout}; name a layout by --layout"
            raise LogError(reason)
        with tempfile.TemporaryDirectory(prefix="rune-replay-") as folder:
            for name in record.files:
                path = Path(folder, *_parts(name))
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(self._content(name))
            variables = {each.name: each.value for each in record.variables}
            first = Path(folder, *_parts(record.files[0]))
            layout = open_layout(first, variables, trusted=False)
        return dataclasses.replace(layout, path=record.layout, files=())

    def _content(self, name: str) -> bytes:
        place = self._places.get(name)
        if place is None or place.size > _LARGEST:
            reason = f"the recording lacks {name}, a part of its layout; name a layout by --layout"
            raise LogError(reason)
        try:
            return self._recording.attachment(place)
        except RecordingError as error:
            reason = f"{name}, a part of the recorded layout, cannot be read: {error}"
            raise LogError(reason) from error


def _parts(name: str) -> tuple[str, ...]:
    """The steps of an attachment's path.

    Raises:
        LogError: It leads out of its folder.
    """
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or "\\" in name or "\0" in name:
        reason = f"the recording has a file with the path {name[:80]!r}, which is not opened"
        raise LogError(reason)
    return path.parts
