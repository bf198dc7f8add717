"""What is in an MCAP file and where: from the index at its end, or, without one, from all of it."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import field
from typing import Final, NamedTuple

from hub.errors import RecordingError
from hub.recording.chunks import (
    CHANNEL,
    CHUNK,
    MESSAGE,
    MESSAGE_INDEX,
    SCHEMA,
    ChunkPlace,
    records_of,
    unpack,
)
from hub.recording.topics import RecordedTopic
from hub.values import dataclass

MAGIC: Final = b"\x89MCAP0\r\n"
_FOOTER, _DATA_END = 2, 15
_CHUNK_INDEX, _ATTACHMENT, _ATTACHMENT_INDEX, _STATISTICS, _METADATA, _METADATA_INDEX = (
    8, 9, 10, 11, 12, 13,
)  # fmt: skip
_RECORD = struct.Struct("<BQ")
_CHUNK_TIMES = struct.Struct("<QQ")
_INDEXED_CHUNK = struct.Struct("<QQQQI")
_MESSAGE_HEAD = struct.Struct("<HIQ")
_STATISTICS_BYTES = 8 + 2 + 4 * 4 + 2 * 8
"""Length of the statistics before the counts by channel [bytes]."""
_LOOSE_BYTES = 1024 * 1024
"""Messages without a chunk are read in runs of about this length [bytes]."""
_MOST_SUMMARY = 1024**3
_MOST_METADATA = 16 * 1024 * 1024


class AttachmentPlace(NamedTuple):
    """Where a file within the recording is.

    Attributes:
        name: Its name.
        media_type: Its type: "application/xml".
        offset: The place of its record [bytes].
        size: Its length [bytes].
    """

    name: str
    media_type: str
    offset: int
    size: int


@dataclass(slots=True)
class Summary:
    """What is in a file.

    Attributes:
        topics: Topics by the number of their channel.
        chunks: Parts with messages, in the order of the file.
        about: Metadata by name; equal names are merged.
        attachments: Files within it.
        counts: Number of messages by channel; empty without an index.
        finished: The file has its index.
        faults: What is wrong with the file, in sentences.
    """

    topics: dict[int, RecordedTopic] = field(default_factory=dict)
    chunks: list[ChunkPlace] = field(default_factory=list)
    about: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: list[AttachmentPlace] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    finished: bool = False
    faults: list[str] = field(default_factory=list)


def summary_of(handle: int) -> Summary:
    """Read what is in an open file.

    Raises:
        OSError: It cannot be read.
        RecordingError: It is no MCAP file.
    """
    size = os.fstat(handle).st_size
    if os.pread(handle, len(MAGIC), 0) != MAGIC:
        text = "it is no MCAP file"
        raise RecordingError(text)
    return _Indexed(handle, size).read() or _Scan(handle, size).read()


class _Fields:
    """The fields of a record, one after another."""

    def __init__(self, data: bytes, at: int = 0) -> None:
        self.data = data
        self.at = at

    def number(self, code: str) -> int:
        (value,) = struct.unpack_from("<" + code, self.data, self.at)
        self.at += struct.calcsize("<" + code)
        return int(value)

    def bytes(self) -> bytes:
        length = self.number("I")
        if length > len(self.data) - self.at:
            text = "a text in it is cut"
            raise RecordingError(text)
        self.at += length
        return self.data[self.at - length : self.at]

    def text(self) -> str:
        return self.bytes().decode("utf-8", "replace")

    def map(self) -> dict[str, str]:
        inner = _Fields(self.bytes())
        found = {}
        while inner.at < len(inner.data):
            name = inner.text()
            found[name] = inner.text()
        return found


class _Topics:
    """Gathers schemas and channels into topics."""

    def __init__(self, summary: Summary) -> None:
        self._summary = summary
        self._schemas: dict[int, tuple[str, str, bytes]] = {}

    def take(self, kind: int, content: bytes) -> None:
        fields = _Fields(content)
        number = fields.number("H")
        if kind == SCHEMA:
            self._schemas[number] = fields.text(), fields.text(), fields.bytes()
            return
        name, encoding, schema = self._schemas.get(fields.number("H"), ("", "", b""))
        topic, coding = fields.text(), fields.text()
        self._summary.topics.setdefault(
            number, RecordedTopic(topic, name, encoding, schema, coding, fields.map())
        )


class _Indexed:
    """Reads the index at the end of a file."""

    def __init__(self, handle: int, size: int) -> None:
        self._handle = handle
        self._size = size
        self._summary = Summary(finished=True)
        self._topics = _Topics(self._summary)
        self._messages = 0

    def read(self) -> Summary | None:
        """What is in the file; None: there is no index, or it is not usable."""
        tail = os.pread(self._handle, 37, max(0, self._size - 37))
        if len(tail) < 37 or tail[-8:] != MAGIC or tail[:1] != bytes([_FOOTER]):
            return None
        start, _, checksum = struct.unpack_from("<QQI", tail, 9)
        length = self._size - 37 - start
        if not start or not 0 <= length <= _MOST_SUMMARY:
            return None
        data = os.pread(self._handle, length, start)
        if checksum and zlib.crc32(tail[:25], zlib.crc32(data)) != checksum:
            return None
        try:
            for kind, begin, end in records_of(data):
                self._take(kind, data, begin, end)
        except (RecordingError, struct.error):
            return None
        known = bool(self._summary.topics) or not self._messages
        return self._summary if known and (self._summary.chunks or not self._messages) else None

    def _take(self, kind: int, data: bytes, begin: int, end: int) -> None:
        if kind == _CHUNK_INDEX:
            first, last, offset, length, maps = _INDEXED_CHUNK.unpack_from(data, begin)
            at = begin + _INDEXED_CHUNK.size
            (indexes,) = struct.unpack_from("<Q", data, at + maps)
            if offset + length + indexes <= self._size and maps % 10 == 0 and at + maps < end:
                self._summary.chunks.append(
                    ChunkPlace(first, last, offset, length, indexes, data[at : at + maps])
                )
            else:
                self._summary.faults.append("the index names a part that the file does not have")
        elif kind in (SCHEMA, CHANNEL):
            self._topics.take(kind, data[begin:end])
        elif kind == _ATTACHMENT_INDEX:
            fields = _Fields(data, begin)
            offset, _, _, _, size = (fields.number("Q") for _ in range(5))
            name, media_type = fields.text(), fields.text()
            self._summary.attachments.append(AttachmentPlace(name, media_type, offset, size))
        elif kind == _METADATA_INDEX:
            fields = _Fields(data, begin)
            offset, length = fields.number("Q"), min(fields.number("Q"), _MOST_METADATA)
            record = os.pread(self._handle, length, offset)
            _take_metadata(self._summary, record[_RECORD.size :])
        elif kind == _STATISTICS:
            self._messages = _Fields(data, begin).number("Q")
            self._take_counts(data, begin + _STATISTICS_BYTES)

    def _take_counts(self, data: bytes, at: int) -> None:
        (length,) = struct.unpack_from("<I", data, at)
        for place in range(at + 4, at + 4 + length - length % 10, 10):
            channel, count = struct.unpack_from("<HQ", data, place)
            self._summary.counts[channel] = count


class _Scan:
    """Reads a file from its begin, as far as its records are whole."""

    def __init__(self, handle: int, size: int) -> None:
        self._handle = handle
        self._size = size
        self._summary = Summary()
        self._topics = _Topics(self._summary)
        self._indexed: set[int] = set()
        self._loose: list[tuple[int, int, int]] = []  # stamp, begin, end

    def read(self) -> Summary:
        """What the file has."""
        last = len(MAGIC)
        try:
            for kind, offset, length in self._records():
                last = offset + _RECORD.size + length
                self._take(kind, offset, length)
        except (RecordingError, struct.error) as error:
            self._summary.faults.append(f"after byte {last} it cannot be read: {error}")
        self._end_run()
        for place in self._summary.chunks:
            if place.packed and self._unknown(place):
                self._look_inside(place)
        return self._summary

    def _records(self) -> Iterator[tuple[int, int, int]]:
        """Kind, place and length of each whole record."""
        at = len(MAGIC)
        while at + _RECORD.size <= self._size:
            kind, length = _RECORD.unpack(os.pread(self._handle, _RECORD.size, at))
            if kind == 0 or at + _RECORD.size + length > self._size:
                raise RecordingError("its last record is cut" if kind else "that is no record")
            if kind in (_DATA_END, _FOOTER):
                return
            yield kind, at, length
            at += _RECORD.size + length

    def _content(self, offset: int, length: int, most: int) -> bytes:
        return os.pread(self._handle, min(length, most), offset + _RECORD.size)

    def _take(self, kind: int, offset: int, length: int) -> None:
        end = offset + _RECORD.size + length
        if kind == MESSAGE:
            _, _, stamp = _MESSAGE_HEAD.unpack(self._content(offset, length, _MESSAGE_HEAD.size))
            self._loose.append((stamp, offset, end))
            if end - self._loose[0][1] >= _LOOSE_BYTES:
                self._end_run()
            return
        if kind == CHUNK:
            self._end_run()
            first, last = _CHUNK_TIMES.unpack(self._content(offset, length, _CHUNK_TIMES.size))
            self._summary.chunks.append(ChunkPlace(first, last, offset, end - offset, 0, b""))
        elif kind == MESSAGE_INDEX:
            self._take_index(offset, length, end)
        elif kind in (SCHEMA, CHANNEL):
            self._topics.take(kind, self._content(offset, length, _MOST_METADATA))
        elif kind == _METADATA:
            _take_metadata(self._summary, self._content(offset, length, _MOST_METADATA))
        elif kind == _ATTACHMENT:
            fields = _Fields(self._content(offset, length, 65536), 16)
            name, media_type = fields.text(), fields.text()
            self._summary.attachments.append(
                AttachmentPlace(name, media_type, offset, fields.number("Q"))
            )

    def _take_index(self, offset: int, length: int, end: int) -> None:
        """Add the index of a channel to the chunk before it."""
        if not self._summary.chunks or not self._summary.chunks[-1].packed:
            return
        place = self._summary.chunks[-1]
        if place.offset + place.length + place.index_length == offset:
            channel = self._content(offset, length, 2)
            self._summary.chunks[-1] = place._replace(
                index_length=end - place.offset - place.length,
                channels=place.channels + channel + struct.pack("<Q", offset),
            )

    def _end_run(self) -> None:
        """Messages that lie in no chunk are a part of the file as well."""
        if self._loose:
            stamps = [stamp for stamp, _, _ in self._loose]
            begin, end = self._loose[0][1], self._loose[-1][2]
            self._summary.chunks.append(
                ChunkPlace(min(stamps), max(stamps), begin, end - begin, 0, b"", packed=False)
            )
            self._loose = []

    def _unknown(self, place: ChunkPlace) -> bool:
        """Whether a chunk has messages of channels that are not known yet, as far as one sees."""
        channels = {number for (number, _) in struct.iter_unpack("<HQ", place.channels)}
        return not place.channels or not channels <= self._summary.topics.keys()

    def _look_inside(self, place: ChunkPlace) -> None:
        """Find schemas and channels in a chunk."""
        try:
            records = unpack(os.pread(self._handle, place.length, place.offset))
            for kind, begin, end in records_of(records):
                if kind in (SCHEMA, CHANNEL):
                    self._topics.take(kind, records[begin:end])
        except (RecordingError, struct.error, RuntimeError, ValueError) as error:
            self._summary.faults.append(f"at byte {place.offset}: {error}")


def _take_metadata(summary: Summary, content: bytes) -> None:
    fields = _Fields(content)
    summary.about.setdefault(fields.text(), {}).update(fields.map())
