"""Reads what is in an MCAP file without an index: from all of it."""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Iterator
from typing import Final

from hub.errors import RecordingError
from hub.recording.budget import BudgetError, ReadBudget
from hub.recording.chunks import MOST_CHUNK, ChunkPlace, unpack
from hub.recording.records import (
    ATTACHMENT,
    CHANNEL,
    CHUNK,
    DATA_END,
    FOOTER,
    MAGIC,
    MESSAGE,
    MESSAGE_INDEX,
    METADATA,
    RECORD,
    SCHEMA,
    records_of,
)
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

_CHUNK_TIMES = struct.Struct("<QQ")
_MESSAGE_HEAD = struct.Struct("<HIQ")
_LOOSE_BYTES: Final = 1024 * 1024
"""Messages without a chunk are read in runs of about this length [bytes]."""
_NAMES: Final = re.compile(rb"\x03\0\0\0lz4|\x04\0\0\0zstd")
"""How a packed chunk names its compression."""
_CHUNK_HEAD: Final = 28 + 4 + 4 + 8
"""Length of the head of a chunk, with the longest name of a compression [bytes]."""
_MOST_SEARCHED: Final = 16
"""What may be a chunk behind damage is read up to this times the length of the file."""
_BLOCK: Final = 64 * 1024
"""A scan reads the heads of records in blocks of this length [bytes]."""


class Scan:
    """Reads a file from its begin, as far as its records are whole.

    Behind a damaged record it goes on at the next chunk whose checksum is right.
    """

    def __init__(self, handle: int, size: int, budget: ReadBudget, *, partial: bool) -> None:
        self._handle = handle
        self._size = size
        self._budget = budget
        self._partial = partial
        self._summary = Summary()
        self._topics = Topics(self._summary)
        self._loose: list[tuple[int, int, int]] = []  # stamp, begin, end
        self._index_channels = bytearray()
        self._kept = 0
        self._block = b""
        self._block_at = 0
        self._searched = 0

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
        return is_footer(os.pread(self._handle, FOOTER_BYTES, self._size - FOOTER_BYTES))

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
        head = os.pread(self._handle, RECORD.size + _CHUNK_HEAD, place)
        if len(head) < RECORD.size + _CHUNK_HEAD:
            return False
        kind, length = RECORD.unpack_from(head)
        if kind != CHUNK or not 0 < length <= min(MOST_CHUNK, self._size - place):
            return False
        (named,) = struct.unpack_from("<I", head, RECORD.size + 28)
        (packed,) = struct.unpack_from("<Q", head, RECORD.size + 32 + min(named, 4))
        if length != 40 + named + packed:
            return False
        self._searched += length
        if self._searched > _MOST_SEARCHED * self._size:
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
            take_metadata(self._summary, self._facts(offset, length))
        elif kind == ATTACHMENT:
            fields = Fields(self._content(offset, length, _BLOCK), 16)
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
        return self._content(offset, length, MOST_METADATA)

    def _check_kept(self) -> None:
        if self._kept > MOST_SUMMARY:
            text = "it has more schemas, metadata and names than are read"
            raise RecordingError(text)

    def _add(self, place: ChunkPlace) -> None:
        if place.length > MOST_CHUNK or len(self._summary.chunks) >= MOST_CHUNKS:
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
