"""What is in an MCAP file and where: from the index at its end, or, without one, from all of it."""

from __future__ import annotations

import itertools
import os
import struct
import zlib
from collections.abc import Sequence

from hub.errors import RecordingError
from hub.recording.budget import ReadBudget
from hub.recording.chunks import MOST_CHUNK, ChunkPlace
from hub.recording.lengths import wrong_lengths
from hub.recording.records import (
    ATTACHMENT_INDEX,
    CHANNEL,
    CHUNK_INDEX,
    MAGIC,
    METADATA,
    METADATA_INDEX,
    RECORD,
    SCHEMA,
    STATISTICS,
    fault_of_begin,
    records_of,
)
from hub.recording.scan import Scan
from hub.recording.summary_facts import (
    FOOTER_BYTES,
    MOST_CHUNKS,
    MOST_FAULTS,
    MOST_METADATA,
    MOST_SUMMARY,
    AttachmentPlace,
    Fields,
    Summary,
    Topics,
    is_footer,
    take_metadata,
)

_INDEXED_CHUNK = struct.Struct("<QQQQI")
_STATISTICS_BYTES = 8 + 2 + 4 * 4 + 2 * 8
"""Length of the statistics before the counts by channel [bytes]."""


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
    return _Indexed(handle, size).read() or Scan(handle, size, budget, partial=partial).read()


class _Indexed:
    """Reads the index at the end of a file."""

    def __init__(self, handle: int, size: int) -> None:
        self._handle = handle
        self._size = size
        self._summary = Summary(finished=True)
        self._topics = Topics(self._summary)

    def read(self) -> Summary | None:
        """What is in the file; None: there is no index, or it is not usable."""
        tail = os.pread(self._handle, FOOTER_BYTES, max(0, self._size - FOOTER_BYTES))
        if not is_footer(tail):
            return None
        start, _, checksum = struct.unpack_from("<QQI", tail, RECORD.size)
        length = self._size - FOOTER_BYTES - start
        if not start or not 0 <= length <= MOST_SUMMARY:
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
            fields = Fields(data, begin)
            offset, _, _, _, size = (fields.number("Q") for _ in range(5))
            name, media_type = fields.text(), fields.text()
            self._summary.attachments.append(AttachmentPlace(name, media_type, offset, size))
        elif kind == METADATA_INDEX:
            fields = Fields(data, begin)
            offset, length = fields.number("Q"), fields.number("Q")
            if offset + length > self._size or length > MOST_METADATA:
                text = "its metadata is elsewhere"
                raise RecordingError(text)
            record = os.pread(self._handle, length, offset)
            if record[:1] == bytes([METADATA]):
                take_metadata(self._summary, record[RECORD.size :])
        elif kind == STATISTICS:
            self._take_counts(data, begin + _STATISTICS_BYTES)

    def _take_chunk(self, data: bytes, begin: int, end: int) -> None:
        first, last, offset, length, maps = _INDEXED_CHUNK.unpack_from(data, begin)
        at = begin + _INDEXED_CHUNK.size
        if maps % 10 or at + maps + 8 > end or len(self._summary.chunks) >= MOST_CHUNKS:
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


def _overlap(chunks: Sequence[ChunkPlace]) -> bool:
    """Whether two parts share bytes, so that an index makes a short file a long one."""
    places = sorted((each.offset, each.length + each.index_length) for each in chunks)
    return any(at + length > after for (at, length), (after, _) in itertools.pairwise(places))
