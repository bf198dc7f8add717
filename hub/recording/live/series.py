"""A recording as a series of files: split by time or size, as a ring, on a disk that fills up.

| event | action |
| --- | --- |
| a file is full, or an order | go on in the next file, which begins with the latched messages |
| a ring is too long or too large, or the disk is nearly full | delete its oldest files |
| a file ended with a fault | count what is lost; try the next file every `RETRY_S`, with room |
| the date was set | the next file has another anchor |
"""

from __future__ import annotations

import contextlib
import logging
import os
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hub.recording.anchor import TimeAnchor
from hub.recording.encoder import Payload
from hub.recording.topics import RecordedTopic
from hub.recording.writer import (
    PATIENCE_S,
    RecordingWriter,
    WaitingMessage,
    WriterLimits,
    no_end_yet,
)
from hub.values import dataclass

_logger = logging.getLogger(__name__)

_LEAST_FILES = 8
"""Number of files for which a ring has room: deleting one deletes a small part of it."""
RETRY_S, _RING_RETRY_S = 5.0, 0.5
"""Time between two attempts to go on after a fault [s]."""
DISK_S = 2.0
"""Longest wait for the disk at the end that an operator orders [s]."""
_STEP_S = 1.0
"""Smallest change of the date that counts as a step [s]."""
_LEAST_ROOM, _MOST_ROOM = 10**6, 64 * 10**6
"""Room for a file that is worth its name: at least, and at most after a long one [bytes]."""
_MARGIN, _MARGIN_SHARE = 64 * 2**20, 0.02
"""Room that a ring leaves beside the least free room: at most [bytes], and of the whole disk."""


class LatchedMessage(NamedTuple):
    """The newest message of a topic that is published at changes only."""

    topic: RecordedTopic
    payload: Payload
    measured: float
    number: int


class Attached(NamedTuple):
    """A file within recordings."""

    name: str
    media_type: str
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesLimits:
    """When files end, and which are deleted.

    Attributes:
        split_s: Longest time in a file [s]; 0: no limit.
        split_bytes: Largest file, about [bytes]; 0: no limit.
        keep_s: How far back a ring reaches [s]; 0: it is no ring.
        keep_bytes: Largest size of a ring [bytes].
        writer: Limits of each file.
    """

    split_s: float = 0.0
    split_bytes: int = 0
    keep_s: float = 0.0
    keep_bytes: int = 0
    writer: WriterLimits = WriterLimits()


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptFile:
    """A complete file of a series.

    Attributes:
        path: The file.
        begun: Its first moment, on the monotonic clock [s].
        ended: Its last moment [s].
        bytes: Its length [bytes].
    """

    path: Path
    begun: float
    ended: float
    bytes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesState:
    """How far a series has got.

    Attributes:
        path: The file that is written.
        files: Number of files so far.
        messages: Messages in them.
        bytes: Their length [bytes]; of a ring, of the files that are left.
        lost: Number of lost messages, by topic.
        fault: Why nothing is written now; after `close`, why something is not; else empty.
        reaches: How far back it reaches [s].
    """

    path: Path
    files: int
    messages: int
    bytes: int
    lost: Mapping[str, int]
    fault: str
    reaches: float


class _Ending(NamedTuple):
    """A file that is completed in a thread of its own, with its first and last moment [s]."""

    thread: threading.Thread
    writer: RecordingWriter
    begun: float
    ended: float


class RecordingSeries:
    """Files of one recording; for one thread."""

    def __init__(
        self,
        next_path: Callable[[int], Path],
        about: Mapping[str, str],
        limits: SeriesLimits,
        *,
        latched: Mapping[str, LatchedMessage],
        attached: Iterable[Attached] = (),
        clock: Callable[[], float] = time.monotonic,
        anchor: Callable[[], TimeAnchor] = TimeAnchor.now,
        say: Callable[[str], object] = _logger.warning,
    ) -> None:
        """Begin the first file; if it cannot be written, `state` has the fault, and `say` nothing.

        Args:
            next_path: The path of the file with a number, from 0; it does not exist.
            about: Facts for each file.
            limits: When files end.
            latched: The messages that each file begins with, by topic.
            attached: Files within each file.
            clock: Monotonic time [s].
            anchor: The date.
            say: Gets a sentence about faults, their ends, and a date that was set.
        """
        self._next_path, self._about, self._limits = next_path, about, limits
        self._clock, self._read_date, self._say = clock, anchor, say
        self._anchor = anchor()
        self._began = self._split_at = clock()
        self._files = self._split_bytes = 0
        # A ring makes room by itself.
        self._retry_s = _RING_RETRY_S if limits.keep_s else RETRY_S
        self._messages = 0
        self._lost: Counter[str] = Counter()
        self._fault = self._last_fault = ""
        self._retry_at = 0.0
        self._closed = False
        self._room = _LEAST_ROOM
        self._latched, self._attached = latched, tuple(attached)
        self._kept: deque[KeptFile] = deque()
        self._closing: list[_Ending] = []
        self._writer: RecordingWriter | None = None
        self._path = Path()
        self._retry(self._began, said=True)

    @property
    def state(self) -> SeriesState:
        """How far it has got."""
        writers = [each.writer for each in self._closing]
        writers += [self._writer] if self._writer is not None else []
        states = [writer.state for writer in writers]
        lost = self._lost.copy()
        for each in states:
            lost.update(each.lost)
        now = self._clock()
        older = self._kept or self._closing
        first = older[0].begun if older else self._split_at
        return SeriesState(
            path=self._path,
            files=self._files,
            messages=self._messages + sum(each.messages for each in states),
            bytes=sum(each.bytes for each in self._kept) + sum(each.bytes for each in states),
            lost=lost,
            fault=self._fault
            or next((each.fault for each in states if each.fault), "")
            or (self._last_fault if self._closed else ""),
            reaches=max(0.0, now - first),
        )

    def adopt(self, folder: Path) -> None:
        """Count complete files of an earlier run as the oldest of this ring."""
        now, date = self._clock(), time.time()
        found = []
        for path in folder.glob("*.mcap"):
            with contextlib.suppress(OSError):
                status = path.stat()
                if path != self._path:
                    ended = now - max(0.0, date - status.st_mtime)
                    begun = ended - self._limits.split_s
                    found.append(
                        KeptFile(path=path, begun=begun, ended=ended, bytes=status.st_size)
                    )
        self._kept.extendleft(sorted(found, key=lambda each: -each.ended))

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
            topic: Where it belongs.
            payload: The encoded message.
            moment: When it came [s].
            measured: When its content was measured [s].
            number: Its number at the receiver.
        """
        if self._writer is None:
            self._lost[topic.name] += 1
        else:
            self._writer.add(topic, payload, moment, measured, number)

    def add_all(self, messages: Sequence[WaitingMessage]) -> None:
        """Write messages, as `add` does: topic, payload, moment, measured, number, length."""
        if self._writer is None:
            self._lost.update(each[0].name for each in messages)
        else:
            self._writer.add_all(messages)

    def look(self) -> None:
        """Split, delete and retry what is due; call it some times a second."""
        now = self._clock()
        self._reap()
        self._prune(now)
        if self._writer is None:
            if now >= self._retry_at:
                self._retry(now)
            return
        state = self._writer.state
        if state.fault:
            self._end_file(now)
            self._room = min(max(state.bytes, _LEAST_ROOM), _MOST_ROOM)
            self._fault, self._retry_at = state.fault, now + self._retry_s
            self._say(f"nothing is recorded: {state.fault}")
            return
        old = 0.0 < self._limits.split_s <= now - self._split_at
        if old or 0 < self._split_bytes <= state.bytes:
            self.split()

    def keeps(self, patience: float) -> bool:
        """Whether the system has all that was added; waits for it at most a time [s]."""
        return self._writer is not None and self._writer.keeps(patience)

    def split(self) -> None:
        """Go on in the next file; not after `close`."""
        if self._closed:
            return
        now = self._clock()
        self._end_file(now)
        self._retry(now)

    @property
    def settled(self) -> bool:
        """Whether all files but the present one are complete."""
        self._reap()
        return not self._closing

    def files(self, begin: float, end: float) -> list[Path]:
        """The complete files with anything from `begin` to `end` [s], in order."""
        return [each.path for each in self._kept if each.ended >= begin and each.begun <= end]

    def close(self, patience: float = PATIENCE_S) -> SeriesState:
        """Complete the last file; returns the final state.

        Args:
            patience: Longest wait for the disk [s]; then it is a fault that files are not complete.
        """
        self._closed = True
        if self._writer is not None:
            self._end_file(self._clock())
        until = time.monotonic() + patience
        for ending in self._closing:
            ending.thread.join(max(0.0, until - time.monotonic()))
        self._reap()
        if self._closing:
            self._fault = no_end_yet(self._closing[0].writer.path, patience)
        return self.state

    def _open(self) -> None:
        """Begin the next file.

        Raises:
            OSError: It cannot be written.
        """
        now, date = self._clock(), self._read_date()
        off = (
            date.wall_ns / 1e9
            - date.monotonic
            - (self._anchor.wall_ns / 1e9 - self._anchor.monotonic)
        )
        if abs(off) > _STEP_S:
            self._say(f"the date was set by {off:.1f} s; the next file follows it")
            self._anchor = date
        path = self._next_path(self._files)
        path.parent.mkdir(parents=True, exist_ok=True)
        free, least = free_room(path.parent), self._limits.writer.least_free
        if self._limits.keep_s:
            enough = free >= least and (not self._fault or _has_room(path.parent, least))
        else:
            enough = free >= least + self._room
        if not enough:
            text = f"only {free // 10**6} MB are free on the disk of {path.parent}"
            raise OSError(text)
        self._writer = RecordingWriter(path, self._anchor, self._about, self._limits.writer)
        if self._fault:
            self._say(f"recording goes on in {path}")
        self._path, self._split_at, self._fault = path, now, ""
        self._split_bytes = self._limits.split_bytes
        if self._limits.keep_s:
            kept = sum(each.bytes for each in self._kept)
            usable = min(self._limits.keep_bytes, free + kept - self._limits.writer.least_free)
            largest = max(1, usable // _LEAST_FILES)
            self._split_bytes = min(self._split_bytes or largest, largest)
        self._files += 1
        for attached in self._attached:
            self._writer.attach(*attached, now)
        for first in self._latched.values():
            self._writer.add(first.topic, first.payload, now, first.measured, first.number)

    def _retry(self, now: float, *, said: bool = False) -> None:
        """Begin the next file; a fault is said unless it is the last one, or another says it."""
        try:
            self._open()
        except OSError as error:
            reason = error.strerror or str(error)
            place = error.filename or self._next_path(self._files)
            fault = f"{place} cannot be made: {reason}" if error.errno else reason
            if fault != self._fault and not said:
                self._say(f"nothing is recorded: {fault}")
            self._fault, self._retry_at = fault, now + self._retry_s

    def _end_file(self, now: float) -> None:
        """Complete the present file beside other work."""
        if self._writer is None:
            return
        writer, self._writer = self._writer, None
        thread = threading.Thread(target=writer.close, name="recording ends", daemon=True)
        thread.start()
        self._closing.append(_Ending(thread, writer, self._split_at, now))

    def _reap(self) -> None:
        """Add up the files that are complete."""
        while self._closing and not self._closing[0].thread.is_alive():
            ending = self._closing.pop(0)
            state = ending.writer.state
            self._messages += state.messages
            self._lost.update(state.lost)
            self._last_fault = state.fault or self._last_fault
            self._kept.append(
                KeptFile(
                    path=ending.writer.path,
                    begun=ending.begun,
                    ended=ending.ended,
                    bytes=state.bytes,
                )
            )

    def _prune(self, now: float) -> None:
        """Delete the oldest files of a ring."""
        if not self._limits.keep_s:
            return
        size = sum(each.bytes for each in self._kept)
        while self._kept:
            oldest = self._kept[0]
            room = _has_room(oldest.path.parent, self._limits.writer.least_free)
            young = now - oldest.ended <= self._limits.keep_s
            if young and room and size <= self._limits.keep_bytes:
                return
            self._kept.popleft()
            size -= oldest.bytes
            with contextlib.suppress(OSError):
                oldest.path.unlink()


def free_room(folder: Path) -> int:
    """Free room on the disk of a folder [bytes]; unlimited if the system does not say."""
    try:
        disk = os.statvfs(folder)
    except OSError:
        return 2**62
    return disk.f_bavail * disk.f_frsize


def _has_room(folder: Path, least: int) -> bool:
    """Whether the disk of a folder has the least free room [bytes] and a ring's margin."""
    try:
        disk = os.statvfs(folder)
    except OSError:
        return True
    margin = min(_MARGIN, disk.f_blocks * disk.f_frsize * _MARGIN_SHARE)
    return disk.f_bavail * disk.f_frsize >= least + margin
