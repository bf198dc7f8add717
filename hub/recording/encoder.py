"""Makes the bytes of MCAP files: messages in packed chunks, and the index at the end.

The format: https://mcap.dev/spec. The index of an hour takes some megabytes of memory: that of each
chunk is kept as the bytes that the file will have.
"""

from __future__ import annotations

import struct
import zlib
from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import lz4.frame
import zstandard

from hub.errors import RecordingError
from hub.recording.records import (
    ATTACHMENT,
    ATTACHMENT_INDEX,
    CHANNEL,
    CHUNK,
    CHUNK_INDEX,
    DATA_END,
    FOOTER,
    HEADER,
    MAGIC,
    MESSAGE,
    MESSAGE_INDEX,
    METADATA,
    METADATA_INDEX,
    RECORD,
    SCHEMA,
    STATISTICS,
    SUMMARY_OFFSET,
)
from hub.recording.ros_quality import FACTS, QOS, ROSBAG2, numbered
from hub.recording.topics import RecordedTopic

LIBRARY: Final = "rune"
"""Who wrote a file, in its header."""
COMPRESSIONS: Final = ("lz4", "zstd", "none")
"""How chunks are packed."""
_ZSTD_LEVEL: Final = 3
_MOST_NUMBERS: Final = 65_535
_MESSAGE = struct.Struct("<BQHIQQ")
MESSAGE_HEAD: Final = _MESSAGE.size
"""Bytes of a chunk that each message takes beside its payload."""
_MESSAGE_BYTES: Final = _MESSAGE.size - RECORD.size
_CHUNK = struct.Struct("<QQQI")
_CHUNK_INDEX = struct.Struct("<QQQQ")
_CHANNEL_PLACE = struct.Struct("<HQ")

Payload = bytes | bytearray | memoryview | Sequence[bytes | bytearray | memoryview]
"""An encoded message, whole or in parts, which do not change later."""
WHOLE: Final = (bytes, bytearray, memoryview)


class _Undo(NamedTuple):
    """What takes a chunk back: places, counts, and the stamps before it."""

    place: int
    index_place: int
    counts: dict[int, int]
    first: int
    last: int


class McapEncoder:
    """The bytes of one file, in the order of the calls.

    Attributes:
        length: Number of bytes that were made.
        messages: Number of messages in the chunks that are complete.
    """

    def __init__(self, compression: str = "lz4") -> None:
        """Begin; `compression` is one of `COMPRESSIONS`."""
        self.length = self.messages = 0
        self._compression = "" if compression == "none" else compression
        self._records = bytearray()
        self._entries: dict[int, array[int]] = {}  # of each channel: stamp, place, stamp, ...
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._definitions = bytearray()
        self._channels = 0
        self._counts: dict[int, int] = {}
        self._first, self._last = 1 << 64, 0
        self._chunk_indexes = bytearray()
        self._chunks = 0
        self._undo: list[_Undo] = []
        self._attachment_indexes: list[bytes] = []
        self._metadata_indexes: list[bytes] = []

    @property
    def open_bytes(self) -> int:
        """Length of the chunk that is not complete."""
        return len(self._records)

    @property
    def index_bytes(self) -> int:
        """Length of the index that `end` makes, without what it has at least [bytes]."""
        small = sum(map(len, (*self._attachment_indexes, *self._metadata_indexes)))
        return len(self._definitions) + len(self._chunk_indexes) + small

    @property
    def counts(self) -> Counter[int]:
        """Number of messages of each channel in the chunks that are complete."""
        return Counter(self._counts)

    def begin(self) -> bytes:
        """The first bytes of the file."""
        head = self._made(MAGIC + _record(HEADER, _text("ros2") + _text(LIBRARY)))
        return head + self.metadata(ROSBAG2, FACTS)

    def register(self, topic: RecordedTopic) -> int:
        """The number of a channel for a topic.

        Raises:
            RecordingError: The file has all channels that it can have.
        """
        if self._channels == _MOST_NUMBERS:
            text = f"a recording has at most {_MOST_NUMBERS} topics"
            raise RecordingError(text)
        schema, definitions = 0, b""
        if topic.schema_name:
            key = topic.schema_name, topic.schema_encoding, topic.schema
            schema = self._schemas.get(key, 0)
            if not schema:
                schema = len(self._schemas) + 1
                names = _text(topic.schema_name) + _text(topic.schema_encoding)
                content = schema.to_bytes(2, "little") + names + _sized(topic.schema)
                definitions = _record(SCHEMA, content)
        number = self._channels + 1
        content = struct.pack("<HH", number, schema) + _text(topic.name) + _text(topic.encoding)
        metadata = topic.metadata
        if QOS in metadata:
            metadata = {**metadata, QOS: numbered(metadata[QOS])}
        definitions += _record(CHANNEL, content + _map(metadata))
        if schema:
            self._schemas[key] = schema
        self._channels = number
        self._definitions += definitions
        self._records += definitions
        return number

    def add(self, channel: int, stamp: int, published: int, number: int, payload: Payload) -> None:
        """Add a message to the open chunk.

        Args:
            channel: The number of its channel.
            stamp: When it was logged [ns].
            published: When it was measured [ns].
            number: Its number at the receiver.
            payload: The message.

        Raises:
            struct.error: A number does not fit.
            TypeError: The payload has no bytes.
        """
        data = payload if isinstance(payload, WHOLE) else b"".join(payload)
        length = len(data) if data.__class__ is bytes else memoryview(data).nbytes
        head = _MESSAGE.pack(MESSAGE, _MESSAGE_BYTES + length, channel, number, stamp, published)
        records = self._records
        place = len(records)
        records += head
        records += data
        entries = self._entries.get(channel)
        if entries is None:
            entries = self._entries[channel] = array("Q")
        entries.append(stamp)
        entries.append(place)

    def end_chunk(self) -> bytes:
        """The bytes of the open chunk; empty: nothing was added."""
        if not self._records:
            return b""
        if not self._entries:  # definitions alone: a chunk without messages would begin in 1970
            records, self._records = bytes(self._records), bytearray()
            return self._made(records)
        stamps = [entries[::2] for entries in self._entries.values()]
        first = min(min(each) for each in stamps)
        last = max(max(each) for each in stamps)
        records = bytes(self._records)
        packed = _packed(records, self._compression)
        name = _text(self._compression)
        head = _CHUNK.pack(first, last, len(records), zlib.crc32(records))
        chunk = _record(CHUNK, head + name + struct.pack("<Q", len(packed)), packed)
        parts, at = [chunk], self.length + len(chunk)
        places = bytearray()
        for channel, entries in self._entries.items():
            raw = entries.tobytes()
            index = _record(MESSAGE_INDEX, struct.pack("<HI", channel, len(raw)), raw)
            places += _CHANNEL_PLACE.pack(channel, at)
            parts.append(index)
            at += len(index)
        counts = {channel: len(entries) // 2 for channel, entries in self._entries.items()}
        self._undo.append(
            _Undo(self.length, len(self._chunk_indexes), counts, self._first, self._last)
        )
        self._chunks += 1
        self.messages += sum(counts.values())
        for channel, count in counts.items():
            self._counts[channel] = self._counts.get(channel, 0) + count
        self._first, self._last = min(self._first, first), max(self._last, last)
        self._chunk_indexes += _record(
            CHUNK_INDEX,
            _CHUNK_INDEX.pack(first, last, self.length, len(chunk))
            + _sized(bytes(places))
            + struct.pack("<Q", at - self.length - len(chunk))
            + name
            + struct.pack("<QQ", len(packed), len(records)),
        )
        self._records = bytearray()
        self._entries = {}
        return self._made(b"".join(parts))

    def metadata(self, name: str, facts: Mapping[str, str]) -> bytes:
        """A record of facts; not while a chunk is open."""
        made = _record(METADATA, _text(name) + _map(facts))
        self._metadata_indexes.append(
            _record(METADATA_INDEX, struct.pack("<QQ", self.length, len(made)) + _text(name))
        )
        return self._made(made)

    def attachment(self, name: str, media_type: str, data: bytes, stamp: int) -> bytes:
        """A file within the recording; not while a chunk is open."""
        names = _text(name) + _text(media_type)
        content = struct.pack("<QQ", stamp, stamp) + names + struct.pack("<Q", len(data)) + data
        made = _record(ATTACHMENT, content, zlib.crc32(content).to_bytes(4, "little"))
        place = struct.pack("<QQQQQ", self.length, len(made), stamp, stamp, len(data))
        self._attachment_indexes.append(_record(ATTACHMENT_INDEX, place + names))
        return self._made(made)

    def keep(self) -> None:
        """The file has all that was made: nothing of it is taken back."""
        self._undo.clear()

    def forget(self, length: int) -> Counter[int]:
        """Take back what was made since `keep` and lies behind this place in the file.

        Returns the number of messages of each channel that are taken back.
        """
        gone = Counter({channel: len(each) // 2 for channel, each in self._entries.items()})
        while self._undo and self._undo[-1].place >= length:
            undo = self._undo.pop()
            del self._chunk_indexes[undo.index_place :]
            self._first, self._last = undo.first, undo.last
            self._chunks -= 1
            self.messages -= sum(undo.counts.values())
            for channel, count in undo.counts.items():
                self._counts[channel] -= count
                gone[channel] += count
        for indexes in (self._attachment_indexes, self._metadata_indexes):
            indexes[:] = [each for each in indexes if _place_of(each) < length]
        self._records, self._entries = bytearray(), {}
        self.length = length
        return gone

    def end(self) -> bytes:
        """The last bytes of the file: the open chunk and the index."""
        chunk = self.end_chunk()
        start = self.length + RECORD.size + 4
        counts = b"".join(_CHANNEL_PLACE.pack(*each) for each in self._counts.items())
        numbers = struct.pack(
            "<QHIIIIQQ",
            sum(self._counts.values()),
            len(self._schemas),
            self._channels,
            len(self._attachment_indexes),
            len(self._metadata_indexes),
            self._chunks,
            min(self._first, self._last),
            self._last,
        )
        groups = (
            *_by_kind(self._definitions),
            (STATISTICS, _record(STATISTICS, numbers + _sized(counts))),
            (METADATA_INDEX, b"".join(self._metadata_indexes)),
            (ATTACHMENT_INDEX, b"".join(self._attachment_indexes)),
            (CHUNK_INDEX, bytes(self._chunk_indexes)),
        )
        at, offsets = start, b""
        for kind, group in groups:
            if group:
                offsets += _record(SUMMARY_OFFSET, struct.pack("<BQQ", kind, at, len(group)))
                at += len(group)
        summary = b"".join(group for _, group in groups) + offsets
        footer = RECORD.pack(FOOTER, 20) + struct.pack("<QQ", start, at)
        footer += zlib.crc32(footer, zlib.crc32(summary)).to_bytes(4, "little")
        return chunk + self._made(_record(DATA_END, bytes(4)) + summary + footer + MAGIC)

    def _made(self, data: bytes) -> bytes:
        self.length += len(data)
        return data


def _packed(records: bytes, compression: str) -> bytes:
    if compression == "lz4":
        packed: bytes = lz4.frame.compress(records)
        return packed
    if compression == "zstd":
        return zstandard.ZstdCompressor(level=_ZSTD_LEVEL).compress(records)
    return records


def _by_kind(definitions: bytes | bytearray) -> tuple[tuple[int, bytes], tuple[int, bytes]]:
    """Schemas, then channels, from the records of both."""
    found: dict[int, list[bytes]] = {SCHEMA: [], CHANNEL: []}
    at = 0
    while at < len(definitions):
        kind, length = RECORD.unpack_from(definitions, at)
        found[kind].append(bytes(definitions[at : at + RECORD.size + length]))
        at += RECORD.size + length
    return (SCHEMA, b"".join(found[SCHEMA])), (CHANNEL, b"".join(found[CHANNEL]))


def _place_of(index: bytes) -> int:
    """The place in the file that an index of an attachment or of metadata says."""
    return int.from_bytes(index[RECORD.size : RECORD.size + 8], "little")


def _record(kind: int, content: bytes, rest: bytes = b"") -> bytes:
    return RECORD.pack(kind, len(content) + len(rest)) + content + rest


def _sized(data: bytes) -> bytes:
    return len(data).to_bytes(4, "little") + data


def _text(text: str) -> bytes:
    return _sized(text.encode("utf-8", "replace"))


def _map(facts: Mapping[str, str]) -> bytes:
    return _sized(b"".join(_text(key) + _text(value) for key, value in facts.items()))
