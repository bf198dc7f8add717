"""Lengths that records of an MCAP file name, compared with the index of the file."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import Final

from hub.recording.chunks import ChunkPlace
from hub.recording.records import CHUNK, MAGIC, RECORD

_MOST: Final = 256
"""Most heads of chunks and of other records that are looked at when a file is opened."""


def length_fault(head: bytes, place: ChunkPlace) -> str:
    """The fault of the head of a chunk that has another length than the index says; else empty."""
    if len(head) < RECORD.size:
        return ""
    kind, length = RECORD.unpack_from(head)
    if kind != CHUNK or length == place.length - RECORD.size:
        return ""
    return "the length of a part of it is wrong; its messages are read by the index"


def wrong_lengths(handle: int, chunks: Sequence[ChunkPlace]) -> Iterator[str]:
    """Faults of the records before the first chunk, and of some chunks, in sentences.

    Args:
        handle: The file.
        chunks: Its chunks, at least one.

    Raises:
        OSError: The file cannot be read.
    """
    first, at = min(each.offset for each in chunks), len(MAGIC)
    for _ in range(_MOST):
        if at >= first:
            break
        kind, length = RECORD.unpack(os.pread(handle, RECORD.size, at))
        if kind == 0 or at + RECORD.size + length > first:
            yield f"at byte {at}: the length of a record is wrong; messages are read by the index"
            break
        at += RECORD.size + length
    for place in chunks[:: 1 + len(chunks) // _MOST]:
        fault = length_fault(os.pread(handle, RECORD.size, place.offset), place)
        if fault:
            yield f"at byte {place.offset}: {fault}"
