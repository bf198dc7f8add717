"""Writes messages into an MCAP file in a thread of its own; a crash costs half a second of them.

| what happens | what the file has |
| --- | --- |
| the writer is killed | all messages but those of the last `chunk_s`, without an index |
| the power fails | all messages but those of the last `sync_s`, without an index |
| the disk is full, or nearly | all messages until then; `fault` says so, later ones are counted |
| the disk is slow | messages beyond `waiting_bytes` are lost, counted by topic |
| the date is set | the same order and distances: stamps follow the monotonic clock |
"""

from __future__ import annotations

import contextlib
import io
import math
import os
import threading
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import NamedTuple

from mcap.writer import CompressionType, Writer

from hub.recording.anchor import TimeAnchor
from hub.recording.topics import RecordedTopic
from hub.values import dataclass

LIBRARY = "rune"
"""Who wrote a file, in its header."""
ABOUT = "rune"
"""Name of the metadata with the anchor and what the writer says of itself."""
BOOT = "boot"
"""Key of that metadata: which run of a machine the monotonic clock belongs to."""
BOOT_FILE = Path("/proc/sys/kernel/random/boot_id")
"""Where the system says which run of the machine this is."""
_GATHER_S = 0.05
"""Time that messages wait for others before the thread wakes [s]."""

Payload = bytes | bytearray | memoryview | Sequence[bytes | bytearray | memoryview]
"""An encoded message, whole or in parts, which do not change later."""
_BYTES = (bytes, bytearray, memoryview)


@dataclass(frozen=True, slots=True, kw_only=True)
class WriterLimits:
    """How much a crash may cost, and how much room a recording may take.

    Attributes:
        chunk_bytes: Length of messages with which a part of the file ends [bytes].
        chunk_s: It ends after this time at the latest [s].
        sync_s: The disk has all parts after this time [s].
        waiting_bytes: Most that may wait for the disk [bytes].
        least_free: The recording ends before the disk has less than this free [bytes].
    """

    chunk_bytes: int = 256 * 1024
    chunk_s: float = 0.5
    sync_s: float = 5.0
    waiting_bytes: int = 64 * 1024 * 1024
    least_free: int = 1024**3


@dataclass(frozen=True, slots=True, kw_only=True)
class WriterState:
    """How far a recording has got.

    Attributes:
        messages: Number of messages that the system has.
        bytes: Length of the file [bytes].
        lost: Number of lost messages, by topic.
        fault: Why writing ended; else empty.
    """

    messages: int = 0
    bytes: int = 0
    lost: Mapping[str, int] = field(default_factory=dict)
    fault: str = ""


class RecordingWriter:
    """A new file of messages; any thread may call its methods."""

    def __init__(
        self,
        path: Path,
        anchor: TimeAnchor,
        about: Mapping[str, str],
        limits: WriterLimits | None = None,
    ) -> None:
        """Begin.

        Args:
            path: A file that does not exist.
            anchor: The clock of the recording.
            about: Facts, such as the layout and the number of the run.
            limits: What a crash may cost.

        Raises:
            OSError: The file cannot be written.
        """
        self.path = path
        self._anchor = anchor
        self._limits = limits or WriterLimits()
        self._channels: dict[str, int] = {}
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._waiting: list[_WaitingMessage] = []
        self._waiting_bytes = 0
        self._lost: Counter[str] = Counter()
        self._closing = False
        self._fault = ""
        self._written = 0
        self._unflushed: Counter[str] = Counter()
        self._whole = 0
        self._chunk_due = self._sync_due = math.inf
        self._file = path.open("xb", buffering=0)
        self._stream = _Gathered(self._file)
        self._writer = Writer(
            self._stream,  # type: ignore[arg-type]  # all that Writer needs of a file
            chunk_size=self._limits.chunk_bytes,
            compression=CompressionType.LZ4,
        )
        self._writer.start(profile="ros2", library=LIBRARY)
        self._writer.add_metadata(ABOUT, {**about, **clock_facts(anchor)})
        try:
            self._stream.flush()
        except OSError:
            self._file.close()
            with contextlib.suppress(OSError):
                path.unlink()
            raise
        self._whole = self._stream.tell()
        self._thread = threading.Thread(target=self._serve, name="recording", daemon=True)
        self._thread.start()

    @property
    def state(self) -> WriterState:
        """How far the recording has got."""
        with self._lock:
            lost = dict(self._lost)
        return WriterState(messages=self._written, bytes=self._whole, lost=lost, fault=self._fault)

    def add(
        self,
        topic: RecordedTopic,
        payload: Payload,
        moment: float,
        measured: float,
        number: int = 0,
    ) -> None:
        """Write a message; never waits.

        Args:
            topic: Where it belongs; equal names have equal schemas.
            payload: The encoded message.
            moment: When it came, on the monotonic clock [s].
            measured: When its content was measured, on the same clock [s].
            number: Its number at the receiver; 0 has none.
        """
        size = len(payload) if isinstance(payload, _BYTES) else sum(map(len, payload))
        entry = _WaitingMessage(topic, payload, moment, measured, number, size)
        with self._lock:
            if self._fault or self._waiting_bytes + size > self._limits.waiting_bytes:
                self._lost[topic.name] += 1
                return
            self._waiting_bytes += size
            first = not self._waiting
            self._waiting.append(entry)
        if first:
            self._wake.set()

    def attach(self, name: str, media_type: str, data: bytes, moment: float) -> None:
        """Write a file into the recording, such as a layout."""
        with self._lock:
            if not self._fault:
                self._waiting.append(
                    _WaitingMessage(None, data, moment, moment, 0, 0, name, media_type)
                )
        self._wake.set()

    def close(self) -> None:
        """Write what waits, and the index; once."""
        self._closing = True
        self._wake.set()
        self._thread.join()

    def _serve(self) -> None:
        try:
            while not self._fault and not (self._closing and not self._waiting):
                self._wait()
                self._write(self._take())
                self._keep()
        except OSError as error:
            self._give_up(error.strerror or str(error))
        finally:
            self._end()

    def _wait(self) -> None:
        """Return when messages wait, a part of the file is due, or the recording ends."""
        due = min(self._chunk_due, self._sync_due) - time.monotonic()
        if self._wake.wait(None if math.isinf(due) else max(0.0, due)) and not self._closing:
            gather = min(_GATHER_S, max(0.0, due))
            if gather and self._waiting_bytes < self._limits.chunk_bytes:
                time.sleep(gather)

    def _take(self) -> list[_WaitingMessage]:
        with self._lock:
            entries, self._waiting = self._waiting, []
            self._waiting_bytes = 0
            self._wake.clear()
        return entries

    def _write(self, entries: list[_WaitingMessage]) -> None:
        for entry in entries:
            self._write_one(entry)
        if entries:
            now = time.monotonic()
            self._chunk_due = min(self._chunk_due, now + self._limits.chunk_s - _GATHER_S)
            self._sync_due = min(self._sync_due, now + self._limits.sync_s)

    def _write_one(self, entry: _WaitingMessage) -> None:
        topic, payload = entry.topic, entry.payload
        stamp = self._anchor.stamp(entry.moment)
        data = bytes(payload) if isinstance(payload, _BYTES) else b"".join(payload)
        if topic is None:
            self._writer.add_attachment(stamp, stamp, entry.name, entry.media_type, data)
            return
        self._writer.add_message(
            channel_id=self._channels.get(topic.name) or self._channel(topic),
            log_time=stamp,
            publish_time=self._anchor.stamp(entry.measured),
            data=data,
            sequence=entry.number & 0xFFFFFFFF,
        )
        self._unflushed[topic.name] += 1

    def _channel(self, topic: RecordedTopic) -> int:
        schema = 0
        if topic.schema_name:
            key = (topic.schema_name, topic.schema)
            if key not in self._schemas:
                self._schemas[key] = self._writer.register_schema(
                    name=topic.schema_name, encoding=topic.schema_encoding, data=topic.schema
                )
            schema = self._schemas[key]
        self._channels[topic.name] = self._writer.register_channel(
            topic=topic.name,
            message_encoding=topic.encoding,
            schema_id=schema,
            metadata=dict(topic.metadata),
        )
        return self._channels[topic.name]

    def _keep(self) -> None:
        """Pass complete parts to the system, and to the disk; look at its room."""
        now = time.monotonic()
        if self._stream.gathered >= self._limits.chunk_bytes:
            self._stream.flush()
        if now >= self._chunk_due:
            self._flush()
            self._chunk_due = math.inf
            free = _free(self.path)
            if free < self._limits.least_free:
                self._fault = f"only {free // 1024**2} MB are free on the disk of {self.path}"
        if now >= self._sync_due:
            os.fdatasync(self._file.fileno())
            self._sync_due = math.inf

    def _flush(self) -> None:
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._stream.flush()
        self._written += self._unflushed.total()
        self._unflushed.clear()
        self._whole = self._stream.tell()

    def _give_up(self, fault: str) -> None:
        """Stop writing; the file ends with its last complete part."""
        self._fault = fault
        self._lose(self._unflushed.elements())
        self._unflushed.clear()
        with contextlib.suppress(OSError):
            os.ftruncate(self._file.fileno(), self._whole)

    def _lose(self, topics: Iterable[str]) -> None:
        with self._lock:
            self._lost.update(topics)

    def _end(self) -> None:
        if self._fault:
            self._lose(entry.topic.name for entry in self._take() if entry.topic is not None)
        try:
            if not self._stream.failed:
                self._flush()
                self._writer.finish()  # type: ignore[no-untyped-call]
                self._stream.flush()
                self._whole = self._stream.tell()
                os.fdatasync(self._file.fileno())
        except OSError as error:
            self._give_up(error.strerror or str(error))
        with contextlib.suppress(OSError):
            self._file.close()


def clock_facts(anchor: TimeAnchor) -> dict[str, str]:
    """What the metadata of a recording says of the clock of this machine."""
    facts = {"wall_ns": str(anchor.wall_ns), "monotonic": repr(anchor.monotonic)}
    with contextlib.suppress(OSError):
        facts[BOOT] = BOOT_FILE.read_text().strip()
    return facts


def _free(path: Path) -> int:
    """Free room for us on the disk of a file [bytes]."""
    disk = os.statvfs(path.parent)
    return disk.f_bavail * disk.f_frsize


class _WaitingMessage(NamedTuple):
    """What waits for the disk; without a topic it is an attachment."""

    topic: RecordedTopic | None
    payload: Payload
    moment: float
    measured: float
    number: int
    size: int
    name: str = ""
    media_type: str = ""


class _Gathered:
    """Passes what a writer writes to a file in few and complete writes.

    Attributes:
        failed: The file took a part of a write only.
    """

    def __init__(self, file: io.FileIO) -> None:
        self._file = file
        self._parts: list[bytes] = []
        self._length = self._gathered = 0
        self.failed = False

    @property
    def gathered(self) -> int:
        """What the system does not have yet [bytes]."""
        return self._gathered

    def write(self, data: bytes) -> int:
        """Gather these bytes."""
        if data:
            self._parts.append(bytes(data))
            self._length += len(data)
            self._gathered += len(data)
        return len(data)

    def tell(self) -> int:
        """The place behind all that was written, gathered bytes included."""
        return self._length

    def flush(self) -> None:
        """Pass all to the system.

        Raises:
            OSError: It does not take them.
        """
        rest = memoryview(b"".join(self._parts))
        self._parts.clear()
        self._gathered = 0
        try:
            while rest:
                rest = rest[self._file.write(rest) or 0 :]
        except OSError:
            self.failed = True
            raise
