"""The wire layout of a message, and the protocol's version.

A message is one ZeroMQ frame: its topic, NUL bytes up to a multiple of 8 (at least one), a header
of 36 bytes, and the payload. The topic comes first because ZeroMQ filters on it. Behind the
payload's own 4-byte encapsulation, its members start at a multiple of 8.

Small messages of one name in a burst share a frame. Its payload starts with their number (4 bytes).
For each follow its stamp (8 bytes), its payload's length (4 bytes), the payload, and NUL bytes up
to a multiple of 8. Their sequence numbers follow the one in the header.

The topic is the message's name, or `!` and the name if its publisher sends nothing directly. A
large payload may lie in a ring of shared memory: then the topic is `@` and the name, and the frame
holds a descriptor of the place.

Direct messages need no filters: a bundle is one ZeroMQ frame with a `*` and several of these
frames.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

from hub.errors import FrameError
from hub.ipc.definition import MAX_NAME_LENGTH
from hub.ipc.formats.codegen import ENCAPSULATION, Buffer

VERSION = 6
"""Protocol version; peers with another one are refused."""

MAX_FRAME = 4 << 20
"""Largest frame [bytes]; ZeroMQ ends a connection that sends a larger one."""

INLINE, IN_RING, NO_RING, BATCH, RING_BATCH = 0, 1, 2, 3, 4
"""Content of a frame: a payload; the descriptor of a place in a ring; nothing, without a ring;
several payloads of a burst; several descriptors of a burst."""
RING_KINDS = (IN_RING, NO_RING, RING_BATCH)
"""The kinds under the topic of descriptors."""

FAR, RING = b"!", b"@"
"""The mark before the name in a topic: for publishers without direct messages; for descriptors."""

HEADER = struct.Struct("<HHIQQqI")
_ITEM = struct.Struct("<qI")
_COUNT = struct.Struct("<I")
HEADER_SIZE = HEADER.size
_BUNDLE = b"*"
_LITTLE_ENDIAN = ENCAPSULATION["<"]
MAX_TOPIC = MAX_NAME_LENGTH + 1


class Frame(NamedTuple):
    """A message on the wire.

    Attributes:
        name: Message name.
        kind: INLINE, IN_RING, NO_RING, BATCH or RING_BATCH.
        publisher: Number that central gave the sender's connection.
        fingerprint: Identity of the payload's format.
        sequence: Counts the messages of this name from this publisher, from 1.
        stamp_ns: Time of measurement, on the hub's clock [ns].
        payload: CDR bytes with their encapsulation header; a view of the frame.
    """

    name: str
    kind: int
    publisher: int
    fingerprint: int
    sequence: int
    stamp_ns: int
    payload: memoryview


def topic(name: str, kind: bytes = b"") -> bytes:
    """The filter for the messages of this name; `kind` is FAR, RING or empty."""
    return kind + name.encode("ascii") + b"\0"


def prefix(name: str, kind: bytes = b"") -> bytes:
    """The text before the header."""
    raw = topic(name, kind)
    return raw + bytes(-len(raw) % 8)


def size(payload: Iterable[Buffer]) -> int:
    """Total length of the pieces [bytes]."""
    length = 0
    for piece in payload:
        length += len(piece) if piece.__class__ is bytes else memoryview(piece).nbytes
    return length


def pack(
    prefix: bytes,
    *,
    publisher: int,
    fingerprint: int,
    sequence: int,
    stamp_ns: int,
    payload: Iterable[Buffer],
    kind: int = INLINE,
) -> bytes:
    """One frame; the only copy of `payload` is made here."""
    parts = list(payload)
    length = size(parts)
    header = HEADER.pack(VERSION, kind, publisher, fingerprint, sequence, stamp_ns, length)
    return b"".join((prefix, header, *parts))


class FlatFrames:
    """Frames of a flat format, each packed and unpacked by one call of `struct`.

    Attributes:
        pack: (publisher, sequence, stamp_ns, values) -> a whole frame.
        pack_item: (stamp_ns, values) -> one message of a batch.
        unpack: A frame with one message -> unused, publisher, unused, sequence, stamp_ns, unused,
            and the values; None: it is anything else.
        length: Of a payload [bytes].
    """

    def __init__(self, prefix: bytes, fingerprint: int, letters: str) -> None:
        """Prepare.

        Args:
            prefix: The text before the header.
            fingerprint: Identity of the format.
            letters: `struct` letters of the whole body, with its padding.
        """
        length = len(_LITTLE_ENDIAN) + struct.calcsize("<" + letters)
        padding = -(_ITEM.size + length) % 8
        item = struct.Struct(f"<qI4s{letters}{padding}x")
        self._body = struct.Struct("<4s" + letters)
        self._item = item
        self.length = length
        # The constant parts of every frame, joined where possible: fewer pieces to handle.
        start = prefix + struct.pack("<HH", VERSION, INLINE)
        middle = struct.pack("<Q", fingerprint)
        end = struct.pack("<I", length) + _LITTLE_ENDIAN
        whole = struct.Struct(f"<{len(start)}sI8sQq8s{letters}")

        def pack(publisher: int, sequence: int, stamp_ns: int, values: tuple[Any, ...]) -> bytes:
            return whole.pack(start, publisher, middle, sequence, stamp_ns, end, *values)

        def pack_item(stamp_ns: int, values: tuple[Any, ...]) -> bytes:
            return item.pack(stamp_ns, length, _LITTLE_ENDIAN, *values)

        def unpack(raw: bytes) -> tuple[Any, ...] | None:
            if len(raw) != whole.size:
                return None
            found = whole.unpack(raw)
            return found if found[0] == start and found[2] == middle and found[5] == end else None

        self.pack = pack
        self.pack_item = pack_item
        self.unpack = unpack

    def values(self, payload: memoryview) -> tuple[Any, ...] | None:
        """The numbers in a payload; None: it has another layout."""
        if len(payload) != self.length or bytes(payload[:4]) != _LITTLE_ENDIAN:
            return None
        return self._body.unpack(payload)[1:]

    def items(self, payload: memoryview) -> list[tuple[int, tuple[Any, ...]]] | None:
        """Stamp and numbers of each message of a batch; None: one has another layout."""
        if (len(payload) - 4) % self._item.size:
            return None
        items = list(self._item.iter_unpack(payload[4:]))
        if _COUNT.unpack_from(payload)[0] != len(items):
            return None
        for item in items:
            if item[1] != self.length or item[2] != _LITTLE_ENDIAN:
                return None
        return [(item[0], item[3:]) for item in items]


def pack_item(stamp_ns: int, payload: Iterable[Buffer]) -> bytes:
    """One message of a batch."""
    whole = b"".join(payload)
    return b"".join(
        (_ITEM.pack(stamp_ns, len(whole)), whole, bytes(-(_ITEM.size + len(whole)) % 8))
    )


def batch(items: Sequence[bytes]) -> tuple[bytes, ...]:
    """The payload of a batch, in pieces."""
    return (_COUNT.pack(len(items)), *items)


def joined(items: Sequence[bytes]) -> tuple[int, int, Sequence[Buffer]]:
    """Stamp, kind and payload of a frame for messages of a batch; a single one needs no batch."""
    if len(items) > 1:
        return 0, BATCH, batch(items)
    stamp_ns, payload = item_payload(items[0])
    return stamp_ns, INLINE, [payload]


def item_payload(item: bytes) -> tuple[int, memoryview]:
    """Stamp and payload of one message of a batch from this process."""
    stamp_ns, length = _ITEM.unpack_from(item)
    return stamp_ns, memoryview(item)[_ITEM.size : _ITEM.size + length]


def items(payload: memoryview) -> list[tuple[int, memoryview]]:
    """Stamp and payload of each message of a batch.

    Raises:
        FrameError: It is no batch.
    """
    found = []
    at = _COUNT.size
    while len(payload) - at >= _ITEM.size:
        stamp_ns, length = _ITEM.unpack_from(payload, at)
        start, at = at + _ITEM.size, at + _ITEM.size + length
        if at > len(payload):
            break
        found.append((stamp_ns, payload[start:at]))
        at += -(_ITEM.size + length) % 8
    if at != len(payload) or len(payload) < 4 or count(payload) != len(found):
        text = f"{len(payload)} bytes are no batch of messages"
        raise FrameError(text)
    return found


def bundle(whole: Sequence[bytes]) -> bytes:
    """Several frames in order as one direct frame."""
    parts = [_BUNDLE]
    for frame in whole:
        parts += (_COUNT.pack(len(frame)), frame)
    return b"".join(parts)


def is_bundle(raw: bytes) -> bool:
    """Whether this is a bundle."""
    return raw[:1] == _BUNDLE


def split_bundle(raw: bytes) -> list[bytes]:
    """The frames of a bundle.

    Raises:
        FrameError: It is damaged.
    """
    each = iter(bundle_places(raw, 0, len(raw)))
    return [raw[start:end] for start, end in zip(each, each, strict=True)]


def bundle_places(raw: bytes, start: int, end: int) -> list[int]:
    """Begin and end, in turn, of each frame of the bundle in a part of `raw`.

    Raises:
        FrameError: It is damaged.
    """
    found: list[int] = []
    at, read, size = start + len(_BUNDLE), _COUNT.unpack_from, _COUNT.size
    while at + size <= end:
        begin = at + size
        at = begin + read(raw, at)[0]
        found += (begin, at)
    if at != end:
        text = f"a bundle of {end - start} bytes ends inside a frame"
        raise FrameError(text)
    return found


def count(payload: memoryview) -> int:
    """The number of messages in a batch, by its header."""
    return int(_COUNT.unpack_from(payload)[0]) if len(payload) >= _COUNT.size else 0


read_header: Callable[[Buffer, int], tuple[int, int, int, int, int, int, int]] = HEADER.unpack_from
"""(frame, start) -> version, kind, publisher, fingerprint, sequence, stamp_ns, payload's length."""


NUMBERS = struct.Struct("<QqI")
"""The last part of a header: sequence, stamp_ns, payload's length. All before it is the same in
each frame of one kind, of one message of one publisher."""


_PUBLISHER = struct.Struct("<4xI")


def sender_of(raw: bytes) -> int:
    """The number where the header of a frame has it, without a check of the rest; -1: none."""
    end = raw.find(b"\0", 1, MAX_TOPIC + 1)
    start = end + 8 - end % 8
    if end < 0 or raw[:1] == _BUNDLE or len(raw) < start + _PUBLISHER.size:
        return -1
    return int(_PUBLISHER.unpack_from(raw, start)[0])


def name_of(raw: Buffer) -> str:
    """The message's name, without a check of the rest.

    Raises:
        FrameError: The bytes do not start with a name.
    """
    return _start(memoryview(raw))[0]


def unpack(raw: Buffer) -> Frame:
    """The message in a frame.

    Raises:
        FrameError: The bytes are no frame of this protocol version.
    """
    view = memoryview(raw)
    name, start = _start(view)
    if len(view) < start + HEADER_SIZE or any(view[bytes(view[:start]).index(b"\0") : start]):
        text = f"a frame of {len(view)} bytes has no whole header"
        raise FrameError(text)
    version, kind, publisher, fingerprint, sequence, stamp_ns, length = read_header(view, start)
    if version != VERSION:
        text = f"a frame of {name} has protocol version {version}, this is {VERSION}"
        raise FrameError(text)
    if kind > RING_BATCH or (kind in RING_KINDS) != (view[:1] == RING):
        text = f"a frame of {name} is of kind {kind}, which its topic does not carry"
        raise FrameError(text)
    payload = view[start + HEADER_SIZE :]
    if len(payload) != length:
        text = f"a frame of {name} has {len(payload)} bytes of payload instead of {length}"
        raise FrameError(text)
    return Frame(name, kind, publisher, fingerprint, sequence, stamp_ns, payload)


def _start(view: memoryview) -> tuple[str, int]:
    """The message's name, and the start of its header."""
    length = bytes(view[: MAX_TOPIC + 1]).find(b"\0")
    if length < 1:
        text = f"a frame of {len(view)} bytes does not start with a message name"
        raise FrameError(text)
    name = bytes(view[:length]).decode("ascii", "replace")
    name = name[1:] if name[0] in "!@" else name
    if not name.isidentifier() or len(name) > MAX_NAME_LENGTH:
        text = f"a frame starts with {name[:20]!r}, which is no message name"
        raise FrameError(text)
    return name, length + 8 - length % 8
