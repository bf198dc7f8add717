"""What is in an MCAP file and where: from the index at its end, or, without one, from all of it."""

from __future__ import annotations

import itertools
import os
import re
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import field
from typing import Final, NamedTuple

from hub.errors import RecordingError
from hub.recording.budget import BudgetError, ReadBudget
from hub.recording.chunks import MOST_CHUNK, ChunkPlace, unpack
from hub.recording.lengths import wrong_lengths
from hub.recording.records import (
    ATTACHMENT,
    ATTACHMENT_INDEX,
    CHANNEL,
    CHUNK,
    CHUNK_INDEX,
    DATA_END,
    FOOTER,
    MAGIC,
    MESSAGE,
    MESSAGE_INDEX,
    METADATA,
    METADATA_INDEX,
    RECORD,
    SCHEMA,
    STATISTICS,
    fault_of_begin,
    records_of,
)
from hub.recording.ros_quality import ROSBAG2
from hub.recording.topics import RecordedTopic
from hub.values import dataclass

MOST_FAULTS: Final = 20
"""Most faults of a file that are named."""
_CHUNK_TIMES = struct.Struct("<QQ")
_INDEXED_CHUNK = struct.Struct("<QQQQI")
_MESSAGE_HEAD = struct.Struct("<HIQ")
_STATISTICS_BYTES = 8 + 2 + 4 * 4 + 2 * 8
"""Length of the statistics before the counts by channel [bytes]."""
_FOOTER_BYTES: Final = RECORD.size + 20 + len(MAGIC)
_LOOSE_BYTES: Final = 1024 * 1024
"""Messages without a chunk are read in runs of about this length [bytes]."""
_MOST_SUMMARY: Final = 256 * 1024 * 1024
"""Longest index that is read, and all facts that a scan keeps [bytes]."""
_MOST_METADATA: Final = 16 * 1024 * 1024
_MOST_CHUNKS: Final = 4_000_000
_NAMES: Final = re.compile(rb"\x03\0\0\0lz4|\x04\0\0\0zstd")
"""How a packed chunk names its compression."""
_BLOCK: Final = 64 * 1024
"""A scan reads the heads of records in blocks of this length [bytes]."""


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
        unreadable: Length of what lies between the parts and is damaged [bytes].
    """

    topics: dict[int, RecordedTopic] = field(default_factory=dict)
    chunks: list[ChunkPlace] = field(default_factory=list)
    about: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: list[AttachmentPlace] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    finished: bool = False
    faults: list[str] = field(default_factory=list)
    unreadable: int = 0


def summary_of(handle: int, budget: ReadBudget, *, partial: bool = False) -> Summary:
    """Read what is in an open file.

    Args:
        handle: The file.
        budget: What may be unpacked.
        partial: Whether a part that is cut or damaged counts as well.

    Raises:
        OSError: It cannot be read.
        RecordingError: It is no MCAP file.
    """
    size = os.fstat(handle).st_size
    if fault := fault_of_begin(os.pread(handle, len(MAGIC), 0)):
        raise RecordingError(fault)
    return _Indexed(handle, size).read() or _Scan(handle, size, budget, partial=partial).read()


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
    """Gathers schemas and channels into topics.

    Attributes:
        complete: Each channel has its schema.
    """

    def __init__(self, summary: Summary) -> None:
        self.complete = True
        self._summary = summary
        self._schemas: dict[int, tuple[str, str, bytes]] = {}

    def take(self, kind: int, content: bytes) -> None:
        fields = _Fields(content)
        number = fields.number("H")
        if kind == SCHEMA:
            self._schemas[number] = fields.text(), fields.text(), fields.bytes()
            return
        schema = fields.number("H")
        if schema and schema not in self._schemas:
            self.complete = False
        name, encoding, text = self._schemas.get(schema, ("", "", b""))
        topic, coding = fields.text(), fields.text()
        self._summary.topics.setdefault(
            number, RecordedTopic(topic, name, encoding, text, coding, fields.map())
        )


class _Indexed:
    """Reads the index at the end of a file."""

    def __init__(self, handle: int, size: int) -> None:
        self._handle = handle
        self._size = size
        self._summary = Summary(finished=True)
        self._topics = _Topics(self._summary)

    def read(self) -> Summary | None:
        """What is in the file; None: there is no index, or it is not usable."""
        tail = os.pread(self._handle, _FOOTER_BYTES, max(0, self._size - _FOOTER_BYTES))
        if not _is_footer(tail):
            return None
        start, _, checksum = struct.unpack_from("<QQI", tail, RECORD.size)
        length = self._size - _FOOTER_BYTES - start
        if not start or not 0 <= length <= _MOST_SUMMARY:
            return None
        data = os.pread(self._handle, length, start)
        if checksum and zlib.crc32(tail[:25], zlib.crc32(data)) != checksum:
            return None
        try:
            for kind, begin, end in records_of(data):
                self._take(kind, data, begin, end)
        except (RecordingError, struct.error, OverflowError):
            return None
        if not self._is_complete():
            return None
        faults = self._summary.faults
        wrong = wrong_lengths(self._handle, self._summary.chunks)
        faults += itertools.islice(wrong, MOST_FAULTS - len(faults))
        return self._summary

    def _is_complete(self) -> bool:
        """Whether it names all channels, and the chunks of a file that has messages."""
        named = set[int]()
        for maps in {place.channels for place in self._summary.chunks}:
            named.update(number for number, _ in struct.iter_unpack("<HQ", maps))
        topics = self._summary.topics
        return (
            bool(self._summary.chunks)
            and not _overlap(self._summary.chunks)
            and self._topics.complete
            and bool(topics)
            and named <= topics.keys()
        )

    def _take(self, kind: int, data: bytes, begin: int, end: int) -> None:
        if kind == CHUNK_INDEX:
            self._take_chunk(data, begin, end)
        elif kind in (SCHEMA, CHANNEL):
            self._topics.take(kind, data[begin:end])
        elif kind == ATTACHMENT_INDEX:
            fields = _Fields(data, begin)
            offset, _, _, _, size = (fields.number("Q") for _ in range(5))
            name, media_type = fields.text(), fields.text()
            self._summary.attachments.append(AttachmentPlace(name, media_type, offset, size))
        elif kind == METADATA_INDEX:
            fields = _Fields(data, begin)
            offset, length = fields.number("Q"), fields.number("Q")
            if offset + length > self._size or length > _MOST_METADATA:
                text = "its metadata is elsewhere"
                raise RecordingError(text)
            record = os.pread(self._handle, length, offset)
            if record[:1] == bytes([METADATA]):
                _take_metadata(self._summary, record[RECORD.size :])
        elif kind == STATISTICS:
            self._take_counts(data, begin + _STATISTICS_BYTES)

    def _take_chunk(self, data: bytes, begin: int, end: int) -> None:
        first, last, offset, length, maps = _INDEXED_CHUNK.unpack_from(data, begin)
        at = begin + _INDEXED_CHUNK.size
        if maps % 10 or at + maps + 8 > end or len(self._summary.chunks) >= _MOST_CHUNKS:
            text = "its index is damaged, or too long"
            raise RecordingError(text)
        (indexes,) = struct.unpack_from("<Q", data, at + maps)
        if offset + length + indexes > self._size:
            text = "its index names a part that the file does not have"
            raise RecordingError(text)
        if length + indexes <= MOST_CHUNK:
            self._summary.chunks.append(
                ChunkPlace(first, last, offset, length, indexes, data[at : at + maps])
            )
        elif len(self._summary.faults) < MOST_FAULTS:
            self._summary.faults.append(f"at byte {offset}: a part of it is too long")

    def _take_counts(self, data: bytes, at: int) -> None:
        (length,) = struct.unpack_from("<I", data, at)
        for place in range(at + 4, at + 4 + length - length % 10, 10):
            channel, count = struct.unpack_from("<HQ", data, place)
            self._summary.counts[channel] = count


class _Scan:
    """Reads a file from its begin, as far as its records are whole.

    Behind a damaged record it goes on at the next chunk whose checksum is right.
    """

    def __init__(self, handle: int, size: int, budget: ReadBudget, *, partial: bool) -> None:
        self._handle = handle
        self._size = size
        self._budget = budget
        self._partial = partial
        self._summary = Summary()
        self._topics = _Topics(self._summary)
        self._loose: list[tuple[int, int, int]] = []  # stamp, begin, end
        self._index_channels = bytearray()
        self._kept = 0
        self._block = b""
        self._block_at = 0

    def read(self) -> Summary:
        """What the file has."""
        at: int | None = len(MAGIC)
        while at is not None:
            last = at
            try:
                for kind, offset, length in self._records(at):
                    self._take(kind, offset, length)
                    last = offset + RECORD.size + length
                at = None
            except (RecordingError, struct.error, OverflowError) as error:
                self._forget_index()
                at = self._next_chunk(last + 1)
                lost = (self._size if at is None else at) - last
                self._summary.unreadable += lost
                if not (self._partial and self._added_damaged(last, lost)):
                    self._note(f"after byte {last} {lost} bytes cannot be read: {error}")
        if not self._summary.finished:
            self._forget_index()
        self._end_run()
        self._end_index()
        for place in self._summary.chunks:
            if place.packed and self._unknown(place):
                self._look_inside(place)
        return self._summary

    def _added_damaged(self, at: int, length: int) -> bool:
        """Take what is left of a chunk, if it is one."""
        head = os.pread(self._handle, RECORD.size + _CHUNK_TIMES.size, at)
        if len(head) < RECORD.size + _CHUNK_TIMES.size or head[0] != CHUNK:
            return False
        self._end_run()
        self._end_index()
        first, last = _CHUNK_TIMES.unpack_from(head, RECORD.size)
        self._add(ChunkPlace(first, last, at, length, 0, b""))
        return True

    def _note(self, fault: str) -> None:
        if len(self._summary.faults) < MOST_FAULTS and fault not in self._summary.faults:
            self._summary.faults.append(fault)

    def _records(self, at: int) -> Iterator[tuple[int, int, int]]:
        """Kind, place and length of each whole record."""
        while at + RECORD.size <= self._size:
            kind, length = RECORD.unpack(self._bytes(at, RECORD.size))
            if kind in (DATA_END, FOOTER) and length <= 20:
                self._summary.finished = self._ends_well()
                return
            if kind == 0 or at + RECORD.size + length > self._size:
                raise RecordingError("its last record is cut" if kind else "that is no record")
            yield kind, at, length
            at += RECORD.size + length
        if at < self._size:
            text = "its last record is cut"
            raise RecordingError(text)

    def _ends_well(self) -> bool:
        """Whether the file has its last bytes."""
        return _is_footer(os.pread(self._handle, _FOOTER_BYTES, self._size - _FOOTER_BYTES))

    def _next_chunk(self, start: int) -> int | None:
        """The place of the next chunk that is whole; None: there is none."""
        head = RECORD.size + 28
        at = start
        while at < self._size:
            block = os.pread(self._handle, _LOOSE_BYTES + head + 8, at)
            for name in _NAMES.finditer(block):
                place = at + name.start() - head
                if name.start() < _LOOSE_BYTES and place >= start and self._is_chunk(place):
                    return place
            at += _LOOSE_BYTES
        return None

    def _is_chunk(self, place: int) -> bool:
        kind, length = RECORD.unpack(os.pread(self._handle, RECORD.size, place))
        if kind != CHUNK or not 0 < length <= min(MOST_CHUNK, self._size - place):
            return False
        try:
            raw = os.pread(self._handle, RECORD.size + length, place)
            unpack(raw, self._budget.of_part(self._handle, place))
        except RecordingError:
            return False
        return True

    def _bytes(self, at: int, length: int) -> bytes:
        """A few bytes of the file."""
        begin = at - self._block_at
        if begin < 0 or begin + length > len(self._block):
            self._block, self._block_at, begin = os.pread(self._handle, _BLOCK, at), at, 0
        return self._block[begin : begin + length]

    def _content(self, offset: int, length: int, most: int) -> bytes:
        at, length = offset + RECORD.size, min(length, most)
        return os.pread(self._handle, length, at) if length > _BLOCK else self._bytes(at, length)

    def _take(self, kind: int, offset: int, length: int) -> None:
        end = offset + RECORD.size + length
        if kind == MESSAGE:
            _, _, stamp = _MESSAGE_HEAD.unpack(self._content(offset, length, _MESSAGE_HEAD.size))
            self._loose.append((stamp, offset, end))
            if end - self._loose[0][1] >= _LOOSE_BYTES:
                self._end_run()
            return
        self._end_run()
        if kind == MESSAGE_INDEX:
            self._take_index(offset, length, end)
            return
        self._end_index()
        if kind == CHUNK:
            first, last = _CHUNK_TIMES.unpack(self._content(offset, length, _CHUNK_TIMES.size))
            self._add(ChunkPlace(first, last, offset, end - offset, 0, b""))
        elif kind in (SCHEMA, CHANNEL):
            self._topics.take(kind, self._facts(offset, length))
        elif kind == METADATA:
            _take_metadata(self._summary, self._facts(offset, length))
        elif kind == ATTACHMENT:
            fields = _Fields(self._content(offset, length, _BLOCK), 16)
            name, media_type = fields.text(), fields.text()
            size = fields.number("Q")
            self._kept += fields.at
            self._check_kept()
            if fields.at + size + 4 > length:
                self._note(f"at byte {offset}: a file within it is damaged")
            else:
                self._summary.attachments.append(AttachmentPlace(name, media_type, offset, size))

    def _facts(self, offset: int, length: int) -> bytes:
        """The content of a record that is kept."""
        self._kept += length
        self._check_kept()
        return self._content(offset, length, _MOST_METADATA)

    def _check_kept(self) -> None:
        if self._kept > _MOST_SUMMARY:
            text = "it has more schemas, metadata and names than are read"
            raise RecordingError(text)

    def _add(self, place: ChunkPlace) -> None:
        if place.length > MOST_CHUNK or len(self._summary.chunks) >= _MOST_CHUNKS:
            self._note(f"at byte {place.offset}: a part of it is too long, or one too many")
        else:
            self._summary.chunks.append(place)

    def _take_index(self, offset: int, length: int, end: int) -> None:
        """Add the index of a channel to the chunk before it."""
        place = self._summary.chunks[-1] if self._summary.chunks else None
        if place is None or not place.packed:
            return
        if place.offset + place.length + place.index_length != offset:
            return
        if end - place.offset <= MOST_CHUNK:
            channel = self._content(offset, length, 2)
            self._index_channels += channel + struct.pack("<Q", offset)
            self._summary.chunks[-1] = place._replace(
                index_length=end - place.offset - place.length
            )

    def _forget_index(self) -> None:
        """The indexes of the last chunk may not be all there."""
        if self._index_channels and self._summary.chunks:
            self._summary.chunks[-1] = self._summary.chunks[-1]._replace(index_length=0)
        self._index_channels = bytearray()

    def _end_index(self) -> None:
        """The last chunk has all its indexes."""
        if self._index_channels and self._summary.chunks:
            channels = bytes(self._index_channels)
            self._summary.chunks[-1] = self._summary.chunks[-1]._replace(channels=channels)
        self._index_channels = bytearray()

    def _end_run(self) -> None:
        """Messages that lie in no chunk are a part of the file as well."""
        if self._loose:
            stamps = [stamp for stamp, _, _ in self._loose]
            begin, end = self._loose[0][1], self._loose[-1][2]
            self._loose = []
            self._end_index()
            self._add(
                ChunkPlace(min(stamps), max(stamps), begin, end - begin, 0, b"", packed=False)
            )

    def _unknown(self, place: ChunkPlace) -> bool:
        """Whether a chunk has messages of channels that are not known yet, as far as one sees."""
        channels = {number for (number, _) in struct.iter_unpack("<HQ", place.channels)}
        return not place.channels or not channels <= self._summary.topics.keys()

    def _look_inside(self, place: ChunkPlace) -> None:
        """Find schemas and channels in a chunk."""
        try:
            raw = os.pread(self._handle, place.length, place.offset)
            budget = self._budget.of_part(self._handle, place.offset)
            records = unpack(raw, budget, partial=self._partial)
            count = 0
            for count, (kind, begin, end) in enumerate(records_of(records), 1):
                if count > budget.records:
                    break
                if kind in (SCHEMA, CHANNEL):
                    self._kept += end - begin
                    self._check_kept()
                    self._topics.take(kind, records[begin:end])
            budget.count(count)
        except (RecordingError, struct.error) as error:
            if isinstance(error, BudgetError):
                self._note(str(error))
            elif not self._partial:  # else it is found when its messages are read
                self._note(f"at byte {place.offset}: {error}")


def _overlap(chunks: Sequence[ChunkPlace]) -> bool:
    """Whether two parts share bytes, so that an index makes a short file a long one."""
    places = sorted((each.offset, each.length + each.index_length) for each in chunks)
    return any(at + length > after for (at, length), (after, _) in itertools.pairwise(places))


def _is_footer(tail: bytes) -> bool:
    """Whether these are the last bytes of a complete file."""
    whole = len(tail) == _FOOTER_BYTES
    return whole and tail[-len(MAGIC) :] == MAGIC and tail[0] == FOOTER


def _take_metadata(summary: Summary, content: bytes) -> None:
    fields = _Fields(content)
    name = fields.text()
    if name != ROSBAG2:
        summary.about.setdefault(name, {}).update(fields.map())
