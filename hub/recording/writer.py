"""Writes messages into an MCAP file in a thread of its own; a crash costs half a second of them.

| what happens | what the file has |
| --- | --- |
| the writer is killed | all messages but those of the last `chunk_s`, without an index |
| the power fails | all messages but those of the last `sync_s`, without an index |
| the disk is full, or nearly | all messages until then; `fault` says so, later ones are counted |
| it is full of a sudden | the same, and the index, for which room is kept |
| the file is deleted | none; all are counted, and `fault` says so |
| the disk is slow | messages beyond `waiting_bytes` are lost, counted by topic |
| the date is set | the same order and distances: stamps follow the monotonic clock |
"""

from __future__ import annotations

import contextlib
import math
import os
import struct
import threading
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from operator import itemgetter
from pathlib import Path
from typing import Any

from hub.errors import RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.encoder import MESSAGE_HEAD, WHOLE, McapEncoder, Payload
from hub.recording.index_room import IndexRoom
from hub.recording.topics import RecordedTopic
from hub.values import dataclass

ABOUT = "rune"
"""Name of the metadata with the anchor and what the writer says of itself."""
LOST = "rune lost"
"""Name of the metadata with the number of lost messages by topic, where there are some."""
BOOT = "boot"
"""Key of that metadata: which run of a machine the monotonic clock belongs to."""
BOOT_FILE = Path("/proc/sys/kernel/random/boot_id")
"""Where the system says which run of the machine this is."""
PATIENCE_S = 60.0
"""Longest wait for the disk at the end of a recording, where nothing else waits [s]."""
_LENGTH = itemgetter(5)
_GATHER_S = 0.1
"""Time that messages wait for others before the thread wakes [s]."""
_LATE_S = _GATHER_S + 0.05
"""The same, with the time that messages of a bus wait in their inbox [s]."""


WaitingMessage = tuple[Any, Payload, float, float, int, int]
"""Topic, or name and type of an attachment; payload, moment, measured, number, length [bytes].

A tuple, because a class costs a tenth of all writing.
"""


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
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._closing = threading.Event()
        self._waiting: list[WaitingMessage] = []
        self._waiting_bytes = 0
        self._lost: Counter[str] = Counter()
        self._ended = False
        self._fault = ""
        self._written = 0
        self._whole = 0
        self._chunk_due = self._sync_due = math.inf
        self._encoder = McapEncoder()
        self._parts = [self._encoder.begin()]
        self._parts.append(self._encoder.metadata(ABOUT, {**about, **clock_facts(anchor)}))
        self._file = path.open("xb", buffering=0)
        self._room = IndexRoom(path.parent)
        self._asked: list[threading.Event] = []
        try:
            self._pass_on()
        except OSError:
            self._file.close()
            with contextlib.suppress(OSError):
                path.unlink()
            raise
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
        """Write a message; never waits. After `close` it counts as lost.

        Args:
            topic: Where it belongs; equal names have equal schemas.
            payload: The encoded message.
            moment: When it came, on the monotonic clock [s].
            measured: When its content was measured, on the same clock [s].
            number: Its number at the receiver; 0 has none.
        """
        size = _size(payload) if isinstance(payload, WHOLE) else sum(map(_size, payload))
        self._add(topic.name, (topic, payload, moment, measured, number, size))

    def add_all(self, messages: Sequence[WaitingMessage]) -> None:
        """As `add`, for many at once: topic, payload, moment, measured, number, length [bytes]."""
        size = sum(map(_LENGTH, messages))
        with self._lock:
            fits = self._waiting_bytes + size <= self._limits.waiting_bytes and not self._ended
            if fits:
                self._waiting_bytes += size
                first = not self._waiting
                self._waiting += messages
        if not fits:
            for each in messages:
                self._add(each[0].name, each)
        elif first:
            self._wake.set()

    def attach(self, name: str, media_type: str, data: bytes, moment: float) -> None:
        """Write a file into the recording, such as a layout; it waits and is lost as messages."""
        self._add(name, ((name, media_type), data, moment, moment, 0, len(data)))

    def keeps(self, patience: float) -> bool:
        """Whether the system has all that was added before; waits for it at most a time [s]."""
        done = threading.Event()
        with self._lock:
            if self._ended:
                return False
            self._asked.append(done)
        self._wake.set()
        return done.wait(patience) and not self._fault

    def close(self, patience: float = PATIENCE_S) -> str:
        """Write what waits, and the index; once.

        Args:
            patience: Time after which a disk that does not answer is left alone [s].

        Returns:
            Why the file has no end yet; empty: it has one, or `state` has the fault.
        """
        self._closing.set()
        self._wake.set()
        self._thread.join(patience)
        return no_end_yet(self.path, patience) if self._thread.is_alive() else ""

    def _add(self, name: str, entry: WaitingMessage) -> None:
        with self._lock:
            waiting = self._waiting_bytes + entry[-1]
            if self._ended or waiting > self._limits.waiting_bytes:
                self._lost[name] += 1
                return
            self._waiting_bytes = waiting
            first = not self._waiting
            self._waiting.append(entry)
        if first:
            self._wake.set()

    def _serve(self) -> None:
        try:
            while not (self._fault or (self._closing.is_set() and not self._waiting)):
                self._wait()
                with self._lock:
                    asked = [*self._asked]
                self._write(self._take())
                if asked:
                    self._flush()
                self._keep()
                self._answer(asked)
        except OSError as error:
            self._give_up(error)
        finally:
            self._end()

    def _answer(self, asked: list[threading.Event]) -> None:
        """End the wait of those that asked first; after a fault `_end` does, which knows it."""
        with self._lock:
            del self._asked[: len(asked)]
        for each in asked:
            each.set()

    def _wait(self) -> None:
        """Return when messages wait, a part of the file is due, or the recording ends."""
        due = min(self._chunk_due, self._sync_due) - time.monotonic()
        if self._wake.wait(None if math.isinf(due) else max(0.0, due)):
            self._closing.wait(min(_GATHER_S, max(0.0, due)))

    def _take(self) -> list[WaitingMessage]:
        with self._lock:
            entries, self._waiting = self._waiting, []
            self._wake.clear()
        return entries

    def _write(self, entries: list[WaitingMessage]) -> None:
        """Encode messages; those that are complete chunks go to the system."""
        rest = iter(entries)
        channels, stamp_of, add = self._channels, self._anchor.stamp, self._encoder.add
        left = self._limits.chunk_bytes - self._encoder.open_bytes
        try:
            for entry in rest:
                topic, payload, moment, measured, number, size = entry
                try:
                    if topic.__class__ is RecordedTopic:
                        stamp = stamp_of(moment)
                        add(
                            channels.get(topic.name) or self._channel(topic),
                            stamp,
                            stamp if measured == moment else stamp_of(measured),
                            number & 0xFFFFFFFF,
                            payload,
                        )
                    else:
                        self._attach(topic, payload, moment)
                except (RecordingError, ValueError, TypeError, OverflowError, struct.error):
                    # Nothing of it is written: times that are no numbers, a topic too many.
                    self._lose([_name(entry)])
                left -= size + MESSAGE_HEAD
                if left <= 0:
                    self._flush()
                    left = self._limits.chunk_bytes
        except OSError:
            self._lose(map(_name, rest))
            raise
        if entries:
            with self._lock:
                self._waiting_bytes -= sum(map(_LENGTH, entries))
            now = time.monotonic()
            self._chunk_due = min(self._chunk_due, now + self._limits.chunk_s - _LATE_S)
            self._sync_due = min(self._sync_due, now + self._limits.sync_s)

    def _attach(self, names: tuple[str, str], data: Payload, moment: float) -> None:
        self._parts.append(self._encoder.end_chunk())
        whole = data if isinstance(data, bytes) else b""
        self._parts.append(self._encoder.attachment(*names, whole, self._anchor.stamp(moment)))

    def _channel(self, topic: RecordedTopic) -> int:
        number = self._channels[topic.name] = self._encoder.register(topic)
        return number

    def _keep(self) -> None:
        """Pass what is due to the system, and to the disk; look at its room."""
        now = time.monotonic()
        if now >= self._chunk_due:
            self._flush()
            self._chunk_due = math.inf
            free = _free(self.path)
            if free < self._limits.least_free:
                self._fault = f"only {free // 1024**2} MB are free on the disk of {self.path}"
            if self._deleted():
                self._fault = f"{self.path} was deleted"
        if now >= self._sync_due:
            os.fdatasync(self._file.fileno())
            self._sync_due = math.inf

    def _flush(self) -> None:
        """End the chunk, and pass it to the system."""
        self._parts.append(self._encoder.end_chunk())
        self._pass_on()
        self._written = self._encoder.messages
        self._room.keep(self._encoder.index_bytes)

    def _pass_on(self) -> None:
        """Pass what was made to the system.

        Raises:
            OSError: It does not take all of it.
        """
        rest = memoryview(b"".join(self._parts))
        self._parts.clear()
        while rest:
            rest = rest[self._file.write(rest) or 0 :]
        self._whole = self._encoder.length
        self._encoder.keep()

    def _give_up(self, error: OSError) -> None:
        """Stop writing; the file ends with its last complete part."""
        self._fault = f"{self.path} cannot be written: {error.strerror or error}"
        self._parts.clear()
        gone = self._encoder.forget(self._whole)
        names = {number: name for name, number in self._channels.items()}
        self._lose(names[channel] for channel in gone.elements())
        with contextlib.suppress(OSError):
            os.ftruncate(self._file.fileno(), self._whole)
            os.lseek(self._file.fileno(), 0, os.SEEK_END)

    def _lose(self, topics: Iterable[str]) -> None:
        with self._lock:
            self._lost.update(topics)

    def _end(self) -> None:
        """Write what still waits, and the index, if there is room for it."""
        with self._lock:
            self._ended = True
        rest = self._take()
        if self._fault:
            self._lose(map(_name, rest))
        try:
            if not self._fault:
                self._write(rest)
                self._flush()
        except OSError as error:
            self._give_up(error)
        self._room.free()
        try:
            if lost := self.state.lost:
                facts = {name: str(count) for name, count in lost.items()}
                self._parts.append(self._encoder.metadata(LOST, facts))
            self._parts.append(self._encoder.end())
            self._pass_on()
            os.fdatasync(self._file.fileno())
        except OSError as error:
            self._give_up(error)
        if self._deleted():
            names = {number: name for name, number in self._channels.items()}
            self._lose(names[channel] for channel in self._encoder.counts.elements())
            self._written = self._whole = 0
        self._answer([*self._asked])
        with contextlib.suppress(OSError):
            self._file.close()

    def _deleted(self) -> bool:
        """Whether the file has no name any more."""
        return os.fstat(self._file.fileno()).st_nlink == 0


def clock_facts(anchor: TimeAnchor) -> dict[str, str]:
    """What the metadata of a recording says of the clock of this machine."""
    facts = {"wall_ns": str(anchor.wall_ns), "monotonic": repr(anchor.monotonic)}
    if run := boot():
        facts[BOOT] = run
    return facts


def boot() -> str:
    """Which run of the machine this is; empty where the system does not say it."""
    with contextlib.suppress(OSError):
        return BOOT_FILE.read_text().strip()
    return ""


def _free(path: Path) -> int:
    """Free room for us on the disk of a file [bytes]."""
    disk = os.statvfs(path.parent)
    return disk.f_bavail * disk.f_frsize


def _name(entry: WaitingMessage) -> str:
    """The topic, or the name of an attachment."""
    return entry[0].name if isinstance(entry[0], RecordedTopic) else entry[0][0]


def _size(payload: bytes | bytearray | memoryview) -> int:
    """Length of a payload, or of a part of it [bytes]."""
    return payload.nbytes if isinstance(payload, memoryview) else len(payload)


def no_end_yet(path: Path, patience: float) -> str:
    """A sentence: the disk has not taken all of a file within this time [s]."""
    return f"{path} has no end yet: the disk has not taken it for {patience:g} s"
