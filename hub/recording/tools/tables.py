"""Recordings as tables: a CSV file for each topic, with a column for each field.

| field | in the table |
| --- | --- |
| when the message was logged and measured, its number | log_time_s, publish_time_s, sequence |
| a number, a text | its value |
| one within another type | a column of its own: twist.linear.x |
| a message of protobuf or JSON | one column, `json` |
| an array | a JSON list; one that is longer than `most`: the number of its values |
| a number that is none, or infinite | "nan", "inf" or "-inf", in JSON as a text |
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from hub.errors import RecordingError, RosMessageError
from hub.recording.chunks import LoggedMessage
from hub.recording.recording_set import RecordingSet
from hub.recording.tools.selection import Selection
from hub.recording.topics import RecordedTopic
from hub.ros.decoding import RosDecoder
from hub.ros.schema import RosType
from hub.ros.values import RosValue
from hub.table_text import csv_line, json_text
from hub.values import dataclass

_COMMON = ("log_time_s", "publish_time_s", "sequence")
_SELDOM = 2000
_PARTIAL = ".partial"
MOST_FILES = 500
"""Most topics that are written at once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A file that was written.

    Attributes:
        path: The file.
        topic: Its topic.
        rows: Number of its rows.
        unreadable: Messages that do not fit their definition.
    """

    path: Path
    topic: str
    rows: int
    unreadable: int


def write_tables(
    recording: RecordingSet,
    folder: Path,
    selection: Selection,
    progress: Callable[[float], None],
    *,
    most: int = 1000,
    replace: bool = False,
) -> list[Table]:
    """Write the messages of each topic into a file.

    Args:
        recording: Where they are.
        folder: Where the files come; it is made.
        selection: Which topics and which span.
        progress: Is called now and then with the share that is done.
        most: Most values of an array that are written.
        replace: Whether files may be replaced.

    Raises:
        RecordingError: A file exists or cannot be written, or there are too many topics.
    """
    channels = selection.channels(recording)
    first, last = selection.span(recording)
    if len(channels) > MOST_FILES:
        text = f"{len(channels)} topics are more than {MOST_FILES} files; choose some with -e"
        raise RecordingError(text)
    writers: dict[int, _TopicTable] = {}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for number, name in _file_names(recording.channels, channels).items():
            path = folder / name
            if path.exists() and not replace:
                text = f"{path} exists; choose another folder, or replace its files with --force"
                raise RecordingError(text)
            writers[number] = _TopicTable(path, recording.channels[number], most)
        length = max(1, last - first)
        for count, message in enumerate(recording.messages(first, last, channels)):
            writers[message.channel].add(message)
            if count % _SELDOM == 0:
                progress((message.stamp - first) / length)
        return [each.finish() for each in writers.values()]
    except OSError as error:
        text = f"{error.filename or folder} cannot be written: {error.strerror}"
        raise RecordingError(text) from error
    finally:
        for each in writers.values():
            each.close()


class _TopicTable:
    """The file of one topic; it is there when it is complete."""

    def __init__(self, path: Path, topic: RecordedTopic, most: int) -> None:
        self._path, self._topic, self._most = path, topic, most
        self._partial = path.with_name(f".{path.name}{_PARTIAL}")
        self._file: TextIO | None = None
        self._rows = self._unreadable = 0
        self._decoder: RosDecoder | None = None
        try:
            self._decoder = RosDecoder.of(topic)
            kind = self._decoder.type
            columns = list(_columns(kind)) if kind is not None else ["json"]
        except RosMessageError:  # a type that is not known: its bytes
            columns = ["payload"]
        self._file = self._partial.open("w", newline="", encoding="utf-8")
        self._write((*_COMMON, *columns))

    def add(self, message: LoggedMessage) -> None:
        try:
            values = self._values(message.payload)
        except RosMessageError:
            self._unreadable += 1
            return
        stamps = _seconds(message.stamp), _seconds(message.published)
        self._write((*stamps, message.number, *values))
        self._rows += 1

    def finish(self) -> Table:
        try:
            self.close_file()
            self._partial.replace(self._path)
        except OSError as error:
            raise self._fault(error) from error
        return Table(
            path=self._path, topic=self._topic.name, rows=self._rows, unreadable=self._unreadable
        )

    def close_file(self) -> None:
        if self._file is not None:
            file, self._file = self._file, None
            file.close()

    def _write(self, row: tuple[object, ...]) -> None:
        try:
            if self._file is not None:
                self._file.write(csv_line(row))
        except OSError as error:
            raise self._fault(error) from error

    def _fault(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self._path} cannot be written: {error.strerror}")

    def close(self) -> None:
        """Remove what is not finished."""
        with contextlib.suppress(OSError):  # a full disk: closing writes what is left
            self.close_file()
        with contextlib.suppress(OSError):
            self._partial.unlink(missing_ok=True)

    def _values(self, payload: bytes) -> list[object]:
        if self._topic.encoding == "json":
            return [payload.decode("utf-8", "replace")]
        if self._decoder is not None:
            value = self._decoder.decode(payload)
            if self._decoder.type is None:
                return [json_text(_plain(value, self._most))]
            return list(_flat(value, self._most))
        return [payload.hex() if len(payload) <= self._most else f"{len(payload)} bytes"]


def _columns(kind: RosType, before: str = "") -> Iterator[str]:
    """The columns of a type."""
    for each in kind.fields:
        if isinstance(each.kind, RosType) and each.count is None:
            yield from _columns(each.kind, f"{before}{each.name}.")
        else:
            yield before + each.name


def _flat(value: RosValue, most: int) -> Iterator[object]:
    """The values of the columns."""
    for _, item in value.fields():
        if isinstance(item, RosValue):
            yield from _flat(item, most)
        elif isinstance(item, np.ndarray | tuple | list | bytes | bytearray | memoryview):
            if len(item) > most:
                yield f"{len(item)} values"
            else:
                yield json_text(_plain(item, most))
        else:
            yield item.item() if isinstance(item, np.generic) else item


def _plain(value: Any, most: int) -> Any:  # noqa: ANN401 - fields have any type
    """A value for JSON."""
    if isinstance(value, RosValue):
        return {name: _plain(item, most) for name, item in value.fields()}
    if isinstance(value, np.ndarray):
        return value.tolist() if len(value) <= most else f"{len(value)} values"
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (tuple, list, bytes, bytearray, memoryview)):
        return [_plain(item, most) for item in value]
    return value


def _seconds(stamp: int) -> str:
    """A stamp [ns] in seconds, exactly."""
    return f"{stamp // 10**9}.{stamp % 10**9:09d}"


def _file_names(topics: Mapping[int, RecordedTopic], chosen: set[int]) -> dict[int, str]:
    """A file name for each topic."""
    found: dict[int, str] = {}
    taken: set[str] = set()
    for number in sorted(chosen):
        stem = re.sub(r"[^A-Za-z0-9._-]+", "-", topics[number].name).strip("-.")[:150] or "topic"
        name, count = f"{stem}.csv", 1
        while name.casefold() in taken:
            count += 1
            name = f"{stem}-{count}.csv"
        taken.add(name.casefold())
        found[number] = name
    return found
