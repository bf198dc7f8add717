"""Shared memory for large payloads between processes of one machine.

A publisher writes payloads into the slots of a ring and sends descriptors. Receivers copy a
payload, and then check that it was not overwritten meanwhile. The ring is an anonymous file
(memfd_create(2)) that receivers open through /proc, so it disappears with its publisher. It is
sealed against shrinking: a publisher that truncated it would kill its receivers.

A slot is its generation (8 bytes), 4 unused bytes, and the payload, so its members start at a
multiple of 16. Generation 0 means: being written. A slot gets this mark one message before it is
written again. The system call that sends the message between orders both for other processors.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import re
import struct
from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from hub.errors import FrameError
from hub.ipc.formats.codegen import Buffer

with contextlib.suppress(ImportError):  # Windows has neither this module nor such files
    import fcntl

available = hasattr(os, "memfd_create")
"""Whether this system has such files."""

_DESCRIPTOR = struct.Struct("<IIQQQI")
_GENERATION = struct.Struct("<Q")
_PAYLOAD_AT = 12
_PAGE = 4096
_MOST_SLOTS, _FEWEST_SLOTS = 64, 4
_MAX_RING = 64 << 20
_MAX_OPEN = 8
_SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW if available else 0
_LINK = re.compile(r"/memfd:rune-ring( \(deleted\))?")


class Place(NamedTuple):
    """The place of a payload.

    Attributes:
        process: Process id of the publisher.
        file: Its file descriptor of the ring.
        ring: The file's inode: the two numbers above may have belonged to another ring.
        generation: Number of the payload in the ring, from 1.
        start: Offset of the slot [bytes].
        length: Of the payload [bytes].
    """

    process: int
    file: int
    ring: int
    generation: int
    start: int
    length: int

    def pack(self) -> bytes:
        """The descriptor of the place, as sent."""
        return _DESCRIPTOR.pack(*self)

    @classmethod
    def unpack(cls, raw: Buffer) -> Place:
        """The place in a descriptor.

        Raises:
            FrameError: It is no descriptor.
        """
        return cls._make(_unpacked(raw))


class RingWriter:
    """A ring that this process writes.

    Attributes:
        capacity: Largest payload [bytes].
    """

    def __init__(self, payload: int) -> None:
        """Make a ring for payloads of `payload` bytes and a quarter more.

        Raises:
            OSError: There is not enough shared memory.
        """
        self._slot = -(-(_PAYLOAD_AT + payload + payload // 4) // _PAGE) * _PAGE
        self.capacity = self._slot - _PAYLOAD_AT
        self._slots = max(_FEWEST_SLOTS, min(_MOST_SLOTS, _MAX_RING // self._slot))
        self._generation = 0
        size = self._slot * self._slots
        self._file = os.memfd_create("rune-ring", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(self._file, size)
            os.posix_fallocate(self._file, 0, size)  # no memory later would kill us
            fcntl.fcntl(self._file, fcntl.F_ADD_SEALS, _SEALS | fcntl.F_SEAL_SEAL)
            self._identity = os.fstat(self._file).st_ino
            self._map = mmap.mmap(self._file, size)
        except BaseException:
            os.close(self._file)
            raise
        self._memory = memoryview(self._map)
        self._process = os.getpid()

    def write(self, payload: Sequence[Buffer]) -> Place:
        """Put a payload, given in pieces, into the next slot; it must fit into `capacity`."""
        self._generation += 1
        start = self._generation % self._slots * self._slot
        memory = self._memory
        _GENERATION.pack_into(memory, start, 0)
        at = start + _PAYLOAD_AT
        for piece in payload:
            raw = piece if isinstance(piece, bytes) else memoryview(piece).cast("B")
            memory[at : at + len(raw)] = raw
            at += len(raw)
        _GENERATION.pack_into(memory, start, self._generation)
        # Mark the next slot now, long before it is written.
        _GENERATION.pack_into(memory, (self._generation + 1) % self._slots * self._slot, 0)
        length = at - start - _PAYLOAD_AT
        return Place(self._process, self._file, self._identity, self._generation, start, length)

    def read(self, place: Place) -> memoryview | None:
        """The payload at a place; None: it was overwritten."""
        return _copy(self._memory, place.generation, place.start, place.length)

    def close(self) -> None:
        """Free the memory; receivers keep it until they close it."""
        self._memory.release()
        self._map.close()
        os.close(self._file)


class GrowingRing:
    """A ring of this process, made for the first payload, and again for a longer one."""

    def __init__(self) -> None:
        self._writer: RingWriter | None = None

    @property
    def capacity(self) -> int:
        """The longest payload that fits now [bytes]; 0: no ring."""
        return self._writer.capacity if self._writer else 0

    def write(self, payload: Sequence[Buffer], length: int) -> Place:
        """Put a payload, given in pieces, `length` bytes together, into the ring.

        Raises:
            OSError: The system gives no memory for a ring.
        """
        if self._writer is None or length > self._writer.capacity:
            self.close()
            self._writer = RingWriter(length)
        return self._writer.write(payload)

    def read(self, place: Place) -> memoryview | None:
        """The payload at a place; None: it was overwritten."""
        return self._writer.read(place) if self._writer else None

    def close(self) -> None:
        """Free the memory."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None


class RingReader:
    """A ring of another process.

    Attributes:
        ring: The file's inode.
        memory: The file, read-only.
    """

    def __init__(self, place: Place) -> None:
        """Open the ring of `place`.

        Raises:
            OSError: It is gone, belongs to another user or machine, or is no ring.
        """
        self.ring = place.ring
        path = Path(f"/proc/{place.process}/fd/{place.file}")
        if not _LINK.fullmatch(str(path.readlink())):
            text = f"{path} is no ring"
            raise OSError(text)
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
        try:
            status = os.fstat(file)
            if (
                status.st_ino != place.ring
                or fcntl.fcntl(file, fcntl.F_GET_SEALS) & _SEALS != _SEALS
            ):
                text = f"{path} is not the ring that was meant"
                raise OSError(text)
            self._map = mmap.mmap(file, 0, prot=mmap.PROT_READ)
        finally:
            os.close(file)
        self.memory = memoryview(self._map)

    def read(self, place: Place) -> memoryview | None:
        """The payload; None: it was overwritten, or lies outside the ring."""
        return _copy(self.memory, place.generation, place.start, place.length)

    def close(self) -> None:
        """Free the memory."""
        self.memory.release()
        self._map.close()


class Readers:
    """The last used rings of other processes."""

    def __init__(self) -> None:
        self._open: OrderedDict[tuple[int, ...], RingReader] = OrderedDict()
        self._latest: tuple[int, ...] | None = None
        self._memory = memoryview(b"")

    def read(self, descriptor: Buffer) -> memoryview | None:
        """The payload of a descriptor; None: it was overwritten, or lies outside.

        Raises:
            FrameError: It is no descriptor.
            OSError: The ring is gone, belongs to another user or machine, or is no ring.
        """
        place = _unpacked(descriptor)
        if place[:3] != self._latest:
            self._open_ring(Place._make(place))
        return _copy(self._memory, *place[3:])

    def _open_ring(self, place: Place) -> None:
        key = place[:3]
        reader = self._open.get(key)
        if reader is None:
            reader = self._open[key] = RingReader(place)
            if len(self._open) > _MAX_OPEN:
                self._open.popitem(last=False)[1].close()
        self._latest, self._memory = key, reader.memory

    def close(self) -> None:
        """Free all rings."""
        self._latest, self._memory = None, memoryview(b"")
        while self._open:
            self._open.popitem()[1].close()


def _unpacked(raw: Buffer) -> tuple[int, ...]:
    if len(raw) != _DESCRIPTOR.size:
        text = f"a ring's descriptor has {len(raw)} bytes instead of {_DESCRIPTOR.size}"
        raise FrameError(text)
    return _DESCRIPTOR.unpack(raw)


def _copy(memory: memoryview, generation: int, start: int, length: int) -> memoryview | None:
    at = start + _PAYLOAD_AT
    if at + length > len(memory) or generation == 0:
        return None
    # With the 4 bytes before it: then the members of the copy are aligned as well.
    copied = memory[at - 4 : at + length].tobytes()
    if _GENERATION.unpack_from(memory, start) != (generation,):
        return None
    return memoryview(copied)[4:]
