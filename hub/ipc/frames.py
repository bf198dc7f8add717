"""The wire layout of a message and the protocol's version; only this file knows them.

A message is one ZeroMQ frame: its name, NUL bytes up to a multiple of 8 (at least one), a header of
36 bytes, the payload. The name comes first so that ZeroMQ can filter on it; with the payload's own
4-byte encapsulation, its members start at a multiple of 8.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass

from hub.errors import FrameError
from hub.ipc.codegen import Buffer
from hub.ipc.definition import MAX_NAME_LENGTH

VERSION = 1
"""Protocol version; peers with another one are refused."""

MAX_FRAME = 4 << 20
"""Largest frame any socket takes [bytes]; ZeroMQ drops the connection of who sends more."""

_HEADER = struct.Struct("<HHIQQqI")


@dataclass(frozen=True, slots=True)
class Frame:
    """A message as it travels.

    Attributes:
        name: Message name.
        publisher: Number that central gave the sender's connection.
        fingerprint: Identity of the format the payload was made with.
        sequence: Counts the messages of this name from this publisher, from 1.
        stamp_ns: When the content was measured, on the sender's monotonic clock [ns].
        payload: CDR bytes with their encapsulation header; a view of the frame.
    """

    name: str
    publisher: int
    fingerprint: int
    sequence: int
    stamp_ns: int
    payload: memoryview


def topic(name: str) -> bytes:
    """The filter that selects exactly the messages of this name."""
    return name.encode("ascii") + b"\0"


def prefix(name: str) -> bytes:
    """What stands before the header."""
    raw = name.encode("ascii")
    return raw + bytes(8 - len(raw) % 8)


def pack(
    prefix: bytes,
    *,
    publisher: int,
    fingerprint: int,
    sequence: int,
    stamp_ns: int,
    payload: Iterable[Buffer],
) -> bytes:
    """One frame; `payload` is joined here, the only copy it sees."""
    parts = list(payload)
    length = sum(memoryview(part).nbytes for part in parts)
    header = _HEADER.pack(VERSION, 0, publisher, fingerprint, sequence, stamp_ns, length)
    return b"".join((prefix, header, *parts))


def unpack(raw: Buffer) -> Frame:
    """The message in a frame.

    Raises:
        FrameError: The bytes are no frame of this protocol version.
    """
    view = memoryview(raw)
    name_length = bytes(view[: MAX_NAME_LENGTH + 1]).find(b"\0")
    if name_length < 1:
        text = f"a frame of {len(view)} bytes does not start with a message name"
        raise FrameError(text)
    start = name_length + 8 - name_length % 8
    if len(view) < start + _HEADER.size or any(view[name_length:start]):
        text = f"a frame of {len(view)} bytes has no whole header"
        raise FrameError(text)
    name = bytes(view[:name_length]).decode("ascii", "replace")
    if not name.isidentifier():
        text = f"a frame starts with {name[:20]!r}, which is no message name"
        raise FrameError(text)
    version, _, publisher, fingerprint, sequence, stamp_ns, length = _HEADER.unpack_from(
        view, start
    )
    if version != VERSION:
        text = f"a frame of {name} has protocol version {version}, this is {VERSION}"
        raise FrameError(text)
    payload = view[start + _HEADER.size :]
    if len(payload) != length:
        text = f"a frame of {name} has {len(payload)} bytes of payload instead of {length}"
        raise FrameError(text)
    return Frame(name, publisher, fingerprint, sequence, stamp_ns, payload)
