"""Parts of an MCAP file with messages: where they are, and which messages they have.

The format: https://mcap.dev/spec. Sizes that a file declares are checked before they are used.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Final, NamedTuple

import lz4.frame
import numpy as np
import numpy.typing as npt
import zstandard

from hub.errors import RecordingError

SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX = 3, 4, 5, 6, 7
"""Numbers of records that lie in chunks, or are chunks."""
MOST_CHUNK: Final = 512 * 1024 * 1024
"""Longest part that is read, unpacked [bytes]."""
_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_CHUNK = struct.Struct("<QQQI")
_INDEX = struct.Struct("<HI")

Stamps = npt.NDArray[np.uint64]


class ChunkPlace(NamedTuple):
    """Where a part of a file is.

    Attributes:
        start: Stamp of its first message [ns].
        end: Stamp of its last message [ns].
        offset: Its place in the file [bytes].
        length: Its length [bytes].
        index_length: Length of the indexes behind it [bytes].
        channels: Channel and place of each index (10 bytes each), as the file has them.
        packed: It is a chunk; else it is a run of messages without one.
    """

    start: int
    end: int
    offset: int
    length: int
    index_length: int
    channels: bytes
    packed: bool = True


class LoadedChunk(NamedTuple):
    """An unpacked part: its records, and where each message is.

    Attributes:
        records: The records (bytes).
        channels: The channel of each message (n,).
        stamps: When each was logged (n,) [ns].
        offsets: Where its record begins (n,) [bytes].
    """

    records: bytes
    channels: npt.NDArray[np.uint16]
    stamps: Stamps
    offsets: Stamps


class LoggedMessage(NamedTuple):
    """A message of a recording.

    Attributes:
        channel: The number of its topic.
        stamp: When it was logged [ns since 1970].
        published: When its content was measured [ns since 1970].
        number: Its number at the receiver; 0 has none.
        payload: Its bytes.
    """

    channel: int
    stamp: int
    published: int
    number: int
    payload: bytes


def records_of(data: bytes, start: int = 0) -> Iterator[tuple[int, int, int]]:
    """Kind, begin and end of the content of each record.

    Raises:
        RecordingError: A record is longer than the data.
    """
    at = start
    while at < len(data):
        if at + _RECORD.size > len(data):
            text = "a record is cut"
            raise RecordingError(text)
        kind, length = _RECORD.unpack_from(data, at)
        at += _RECORD.size
        if length > len(data) - at:
            text = "a record is longer than its part of the file"
            raise RecordingError(text)
        yield kind, at, at + length
        at += length


def load(raw: bytes, place: ChunkPlace) -> LoadedChunk:
    """Unpack a part of a file.

    Args:
        raw: The part and the indexes behind it.
        place: Where it is.

    Raises:
        RecordingError: It is damaged, or longer than `MOST_CHUNK`.
    """
    try:
        records = unpack(raw[: place.length]) if place.packed else raw
        index = _read_indexes(raw[place.length :], len(records)) if place.index_length else None
        return LoadedChunk(records, *(index or _walk(records)))
    except (struct.error, ValueError, RuntimeError, UnicodeDecodeError, MemoryError) as error:
        text = f"a part of it is damaged: {error}"
        raise RecordingError(text) from error


def unpack(raw: bytes) -> bytes:
    """The records of a chunk, whose record this is.

    Raises:
        RecordingError: It is damaged, or longer than `MOST_CHUNK`.
    """
    kind, _ = _RECORD.unpack_from(raw)
    _, _, size, checksum = _CHUNK.unpack_from(raw, _RECORD.size)
    at = _RECORD.size + _CHUNK.size
    (named,) = struct.unpack_from("<I", raw, at)
    name = raw[at + 4 : at + 4 + min(named, 16)].decode()
    at += 4 + named
    (length,) = struct.unpack_from("<Q", raw, at)
    data = raw[at + 8 : at + 8 + length]
    if kind != CHUNK or len(data) != length or size > MOST_CHUNK:
        text = "a part of it is no chunk of messages, cut, or too long"
        raise RecordingError(text)
    records = _unpacked(name, data, size)
    if len(records) != size or (checksum and zlib.crc32(records) != checksum):
        text = "the checksum of a part of it is wrong"
        raise RecordingError(text)
    return records


def message_at(chunk: LoadedChunk, index: int) -> LoggedMessage:
    """One message of a part.

    Raises:
        RecordingError: The index points at something else.
    """
    at = int(chunk.offsets[index])
    kind, length = _RECORD.unpack_from(chunk.records, at)
    if kind != MESSAGE:
        text = "an index in it points at no message"
        raise RecordingError(text)
    begin = at + _RECORD.size
    channel, number, stamp, published = _MESSAGE.unpack_from(chunk.records, begin)
    payload = chunk.records[begin + _MESSAGE.size : begin + length]
    return LoggedMessage(channel, stamp, published, number, payload)


def _unpacked(name: str, data: bytes, size: int) -> bytes:
    if not name:
        return data
    if name == "lz4":
        unpacked: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
        return unpacked
    if name == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(data) as reader:
            return reader.read(size + 1)
    text = f"it is packed with {name!r}, which Rune does not know"
    raise RecordingError(text)


def _read_indexes(raw: bytes, length: int) -> tuple[npt.NDArray[np.uint16], Stamps, Stamps] | None:
    """Channels, stamps and offsets of messages, as the indexes say; None: an index is wrong."""
    channels: list[npt.NDArray[np.uint16]] = []
    pairs: list[Stamps] = []
    for kind, begin, end in records_of(raw):
        if kind != MESSAGE_INDEX:
            continue
        channel, size = _INDEX.unpack_from(raw, begin)
        if size % 16 or begin + _INDEX.size + size > end:
            return None
        flat = np.frombuffer(raw, "<u8", size // 8, begin + _INDEX.size).reshape(-1, 2)
        pairs.append(flat)
        channels.append(np.full(len(flat), channel, np.uint16))
    if not pairs:
        return None
    both = np.concatenate(pairs)
    if both.size and int(both[:, 1].max()) + _RECORD.size + _MESSAGE.size > length:
        return None
    order = np.lexsort((both[:, 1], both[:, 0]))
    return np.concatenate(channels)[order], both[order, 0], both[order, 1]


def _walk(records: bytes) -> tuple[npt.NDArray[np.uint16], Stamps, Stamps]:
    """The same from the messages themselves."""
    found = []
    for kind, begin, _ in records_of(records):
        if kind == MESSAGE:
            channel, _, stamp, _ = _MESSAGE.unpack_from(records, begin)
            found.append((channel, stamp, begin - _RECORD.size))
    channels, stamps, offsets = zip(*found, strict=True) if found else ((), (), ())
    both = np.array(stamps, np.uint64), np.array(offsets, np.uint64)
    order = np.lexsort((both[1], both[0]))
    return np.array(channels, np.uint16)[order], both[0][order], both[1][order]
