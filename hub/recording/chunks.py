"""Parts of an MCAP file with messages: where they are, and which messages they have.

The format: https://mcap.dev/spec. Sizes that a file declares are checked before they are used.
"""

from __future__ import annotations

import contextlib
import struct
import zlib
from array import array
from typing import Any, Final, NamedTuple

import lz4.frame
import numpy as np
import numpy.typing as npt
import zstandard

from hub.errors import RecordingError
from hub.recording.budget import PartBudget
from hub.recording.records import CHUNK, MESSAGE, MESSAGE_INDEX, RECORD, records_of

MOST_CHUNK: Final = 256 * 1024 * 1024
"""Longest part that is read, as it is in the file [bytes]."""
_PIECE: Final = 256
"""What is unpacked at once of a damaged part [bytes]."""
_MESSAGE = struct.Struct("<BQHIQQ")
_CHUNK = struct.Struct("<QQQI")
_INDEX = struct.Struct("<HI")
_HEAD = np.dtype(
    [
        ("kind", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("number", "<u4"),
        ("stamp", "<u8"),
        ("published", "<u8"),
    ]
)
_DAMAGE: Final = (
    struct.error,
    ValueError,
    RuntimeError,
    MemoryError,
    OverflowError,
    zstandard.ZstdError,
)
"""What damaged bytes raise in the libraries that unpack them."""

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


def load(
    raw: bytes, place: ChunkPlace, budget: PartBudget, *, partial: bool = False
) -> LoadedChunk:
    """Unpack a part of a file.

    An index that is wrong is not used: the messages themselves say where they are.

    Args:
        raw: The part and the indexes behind it.
        place: Where it is.
        budget: What may be unpacked of it.
        partial: Whether a damaged part has those messages that can be found in it; they may be
            wrong themselves.

    Raises:
        BudgetError: It has more than the budget allows.
        RecordingError: It is damaged.
    """
    try:
        records = unpack(raw[: place.length], budget, partial=partial) if place.packed else raw
        found = _read_indexes(raw[place.length :]) if place.index_length else None
        whole = _are_whole(records, *found) if found is not None else np.zeros(0, bool)
        if found is None or not (whole.all() or partial):
            found = _walk(records, budget, partial=partial)
        elif not whole.all():
            found = found[0][whole], found[1][whole], found[2][whole]
        return LoadedChunk(records, *found)
    except RecordingError:
        raise
    except _DAMAGE as error:
        text = f"a part of it is damaged: {error}"
        raise RecordingError(text) from error


def unpack(raw: bytes, budget: PartBudget, *, partial: bool = False) -> bytes:
    """The records of a chunk, whose record this is; of a damaged one those before the damage.

    Raises:
        BudgetError: It is longer than the budget allows.
        RecordingError: It is damaged.
    """
    try:
        kind, _ = RECORD.unpack_from(raw)
        _, _, size, checksum = _CHUNK.unpack_from(raw, RECORD.size)
        at = RECORD.size + _CHUNK.size
        (named,) = struct.unpack_from("<I", raw, at)
        name = raw[at + 4 : at + 4 + min(named, 16)].decode()
        at += 4 + named
        (length,) = struct.unpack_from("<Q", raw, at)
        data = raw[at + 8 : at + 8 + length]
        if kind != CHUNK or (len(data) != length and not partial):
            text = "a part of it is no chunk of messages, or cut"
            raise RecordingError(text)
        if name:
            budget.unpack(size)
        if partial:
            return _begin_of(name, data, size)
        records = _unpacked(name, data, size)
    except RecordingError:
        raise
    except _DAMAGE as error:
        text = f"a part of it is damaged: {error}"
        raise RecordingError(text) from error
    if len(records) != size or (checksum and zlib.crc32(records) != checksum):
        text = "the checksum of a part of it is wrong"
        raise RecordingError(text)
    return records


def message_at(chunk: LoadedChunk, index: int) -> LoggedMessage:
    """One message of a part."""
    at = int(chunk.offsets[index])
    _, length, channel, number, stamp, published = _MESSAGE.unpack_from(chunk.records, at)
    payload = chunk.records[at + _MESSAGE.size : at + RECORD.size + length]
    return LoggedMessage(channel, stamp, published, number, payload)


class MessageFacts(NamedTuple):
    """Facts of many messages, without their bytes.

    Attributes:
        channels: The number of the topic of each (n,).
        stamps: When each was logged (n,) [ns].
        numbers: Its number at the receiver (n,).
        lengths: Length of its payload (n,) [bytes].
        places: Where it was written: a later message has a greater number (n,); none where that is
            not known (0,).
    """

    channels: npt.NDArray[np.uint16]
    stamps: Stamps
    numbers: npt.NDArray[np.uint32]
    lengths: Stamps
    places: Stamps


def facts_of(chunk: LoadedChunk) -> MessageFacts:
    """Facts of the messages of a part."""
    if not chunk.offsets.size:
        nothing = np.zeros(0, np.uint64)
        return MessageFacts(chunk.channels, nothing, np.zeros(0, np.uint32), nothing, nothing)
    heads = _heads(chunk.records, chunk.offsets)
    lengths = heads["length"] - np.uint64(_MESSAGE.size - RECORD.size)
    return MessageFacts(chunk.channels, chunk.stamps, heads["number"], lengths, chunk.offsets)


def without(chunk: LoadedChunk, channels: npt.NDArray[np.uint16]) -> LoadedChunk:
    """The part with messages of these channels only."""
    keep = np.isin(chunk.channels, channels)
    if keep.all():
        return chunk
    return LoadedChunk(chunk.records, chunk.channels[keep], chunk.stamps[keep], chunk.offsets[keep])


def _begin_of(name: str, data: bytes, size: int) -> bytes:
    """What can be unpacked before the damage."""
    if not name:
        return data[:size]
    unpacker: Any = None
    if name == "lz4":
        unpacker = lz4.frame.LZ4FrameDecompressor()
    elif name == "zstd":
        unpacker = zstandard.ZstdDecompressor().decompressobj()
    found = bytearray()
    with contextlib.suppress(AttributeError, EOFError, *_DAMAGE):
        for at in range(0, len(data), _PIECE):
            found += unpacker.decompress(data[at : at + _PIECE])
            if len(found) >= size:
                break
    return bytes(found[:size])


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


_Found = tuple[npt.NDArray[np.uint16], Stamps, Stamps]
"""Channels, stamps and offsets of messages, by stamp and offset."""


def _read_indexes(raw: bytes) -> _Found | None:
    """Messages as the indexes say; None: an index is wrong."""
    channels: list[npt.NDArray[np.uint16]] = []
    pairs: list[Stamps] = []
    try:
        for kind, begin, end in records_of(raw):
            if kind != MESSAGE_INDEX:
                continue
            channel, size = _INDEX.unpack_from(raw, begin)
            if size % 16 or begin + _INDEX.size + size > end:
                return None
            flat = np.frombuffer(raw, "<u8", size // 8, begin + _INDEX.size).reshape(-1, 2)
            pairs.append(flat)
            channels.append(np.full(len(flat), channel, np.uint16))
    except (RecordingError, struct.error):
        return None
    if not pairs:
        return None
    both = np.concatenate(pairs)
    order = np.lexsort((both[:, 1], both[:, 0]))
    return np.concatenate(channels)[order], both[order, 0], both[order, 1]


def _are_whole(
    records: bytes, channels: npt.NDArray[np.uint16], stamps: Stamps, offsets: Stamps
) -> npt.NDArray[np.bool_]:
    """Whether there is a whole message with this channel and stamp at each offset (n,)."""
    whole = np.zeros(offsets.size, bool)
    if len(records) < _MESSAGE.size:
        return whole
    _, firsts = np.unique(offsets, return_index=True)
    whole[firsts] = offsets[firsts] <= len(records) - _MESSAGE.size
    inside = np.flatnonzero(whole)
    heads = _heads(records, offsets[inside])
    ends = heads["length"] <= len(records) - RECORD.size - offsets[inside]
    same = (heads["channel"] == channels[inside]) & (heads["stamp"] == stamps[inside])
    shape = (heads["kind"] == MESSAGE) & (heads["length"] >= _MESSAGE.size - RECORD.size)
    whole[inside] = ends & same & shape
    return whole


def _heads(records: bytes, offsets: Stamps) -> npt.NDArray[np.void]:
    """The heads of the messages at these offsets (n,)."""
    # A view with a record at every byte of the chunk; nothing of it is copied.
    everywhere: npt.NDArray[np.void] = np.ndarray(
        (len(records) - _MESSAGE.size + 1,), _HEAD, records, strides=(1,)
    )
    return everywhere[offsets]


def _walk(records: bytes, budget: PartBudget, *, partial: bool) -> _Found:
    """The same from the messages themselves."""
    channels, stamps, offsets = array("H"), array("Q"), array("Q")
    count = 0
    try:
        for count, (kind, begin, end) in enumerate(records_of(records), 1):
            if count > budget.records:
                break
            if kind == MESSAGE and end - begin >= _MESSAGE.size - RECORD.size:
                _, _, channel, _, stamp, _ = _MESSAGE.unpack_from(records, begin - RECORD.size)
                channels.append(channel)
                stamps.append(stamp)
                offsets.append(begin - RECORD.size)
    except RecordingError:
        if not partial:
            raise
    budget.count(count)
    both = np.array(stamps, np.uint64), np.array(offsets, np.uint64)
    order = np.lexsort((both[1], both[0]))
    return np.array(channels, np.uint16)[order], both[0][order], both[1][order]
