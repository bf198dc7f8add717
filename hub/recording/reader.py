"""Reads recordings: the newest message of each topic at any time, and all messages in order.

Damaged parts are left out; `faults` names them. An unfinished file, as after a crash, is read as
far as its records are whole.
"""

from __future__ import annotations

import contextlib
import os
import zlib
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from pathlib import Path
from typing import Self

import numpy as np
import numpy.typing as npt

from hub.errors import RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.budget import BudgetError, ReadBudget
from hub.recording.chunks import (
    LoadedChunk,
    LoggedMessage,
    MessageFacts,
    facts_of,
    load,
    message_at,
    without,
)
from hub.recording.lengths import length_fault
from hub.recording.open_recording import OpenRecording
from hub.recording.order import ChannelChunks, WaitingMessages, by_channel
from hub.recording.records import ATTACHMENT, RECORD
from hub.recording.summary import summary_of
from hub.recording.summary_facts import MOST_FAULTS, AttachmentPlace, Summary
from hub.recording.topics import RecordedTopic
from hub.recording.writer import ABOUT

__all__ = ["AttachmentPlace", "LoggedMessage", "Recording"]

_CACHE_BYTES = 64 * 1024 * 1024
_MOST_ATTACHMENT = 1024**3
_MOST_STAMP = 2**64 - 1


class Recording(OpenRecording):
    """An MCAP file that is read; for one thread.

    Attributes:
        path: The file.
        channels: Topics by number.
        about: Metadata by name.
        attachments: Files within it.
        counts: Number of messages by channel, where the file says it.
        start: Stamp of the first message [ns]; 0 without messages.
        end: Stamp of the last message [ns]; 0 without messages.
        finished: The file has its index.
        faults: What is wrong with the file, in sentences.
        unreadable: Length of what was found to be damaged, between the parts and in them [bytes].
    """

    def __init__(
        self,
        path: Path,
        handle: int,
        summary: Summary,
        budget: ReadBudget,
        *,
        partial: bool = False,
    ) -> None:
        """Use `open`."""
        self.path = path
        self.channels: Mapping[int, RecordedTopic] = summary.topics
        self.about: Mapping[str, Mapping[str, str]] = summary.about
        self.attachments = tuple(summary.attachments)
        self.counts: Mapping[int, int] = summary.counts
        self.finished = summary.finished
        self.faults = summary.faults
        self.unreadable = summary.unreadable
        self._handle = handle
        self._budget = budget
        self._partial = partial
        self._places = sorted(
            (place for place in summary.chunks if place.start <= place.end),
            key=lambda place: (place.start, place.offset),
        )
        self._starts = np.array([place.start for place in self._places], np.uint64)
        self._ends = np.array([place.end for place in self._places], np.uint64)
        self.start = self._places[0].start if self._places else 0
        self.end = max((place.end for place in self._places), default=0)
        self._loaded: OrderedDict[int, LoadedChunk] = OrderedDict()
        self._loaded_bytes = 0
        self._damaged: set[int] = set()
        self._of_channel: dict[int, ChannelChunks] | None = None
        self._known = np.array(sorted(summary.topics), np.uint16)

    @classmethod
    def open(cls, path: Path, *, partial: bool = False, budget: ReadBudget | None = None) -> Self:
        """Open a file.

        Args:
            path: The file.
            partial: Whether damaged parts have those messages that can be found in them; these
                may be wrong themselves.
            budget: What may be unpacked; default: by its size.

        Raises:
            RecordingError: It cannot be read, or is no recording.
        """
        try:
            handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        except OSError as error:
            text = f"{path} cannot be read: {error.strerror}"
            raise RecordingError(text) from error
        try:
            budget = budget or ReadBudget(os.fstat(handle).st_size)
            summary = summary_of(handle, budget, partial=partial)
            return cls(path, handle, summary, budget, partial=partial)
        except BaseException as error:
            os.close(handle)
            if isinstance(error, OSError | RecordingError):
                reason = getattr(error, "strerror", None) or error
                text = f"{path} cannot be read: {reason}"
                raise RecordingError(text) from error
            raise

    def close(self) -> None:
        """Close the file; once."""
        os.close(self._handle)

    @property
    def anchor(self) -> TimeAnchor | None:
        """The clock of the writer; None: the file does not say it."""
        about = self.about.get(ABOUT, {})
        try:
            return TimeAnchor(int(about["wall_ns"]), float(about["monotonic"]))
        except (KeyError, ValueError):
            return None

    def attachment(self, place: AttachmentPlace) -> bytes:
        """The content of a file within the recording.

        Raises:
            RecordingError: It is damaged, or too long.
        """
        with contextlib.suppress(OSError):
            content = _attachment(self._handle, place)
            if content is not None:
                return content
        text = f"{self.path}: the file {place.name[:80]!r} in it is damaged, or too long"
        raise RecordingError(text)

    def newest(
        self, stamp: int, channels: AbstractSet[int] | None = None
    ) -> dict[int, LoggedMessage]:
        """The last message of each channel at or before a time.

        Args:
            stamp: The time [ns].
            channels: Which channels; default all.
        """
        found: dict[int, LoggedMessage] = {}
        if stamp < 0:
            return found
        for channel, chunks in self._chunks_of_channels().items():
            if channels is None or channel in channels:
                message = self._newest(channel, chunks, stamp)
                if message is not None:
                    found[channel] = message
        return found

    def messages(
        self,
        start: int | None = None,
        end: int | None = None,
        channels: AbstractSet[int] | None = None,
        *,
        reverse: bool = False,
    ) -> Iterator[LoggedMessage]:
        """All messages by stamp; equal stamps by their place in the file.

        Args:
            start: The first stamp [ns]; default the first of all.
            end: The last stamp [ns]; default the last of all.
            channels: Which channels; default all.
            reverse: The last message first.
        """
        first = self.start if start is None else max(0, start)
        last = min(self.end, _MOST_STAMP if end is None else end)
        wanted = None if channels is None else channels & self.channels.keys()
        chosen = None if wanted is None else np.array(sorted(wanted), np.uint16)
        waiting = WaitingMessages(reverse=reverse)
        meeting = (self._ends >= first) & (self._starts <= last)
        places = np.flatnonzero(meeting).tolist() if last >= 0 else []
        if wanted is not None and len(places) > 1:
            known = self._chunks_of_channels()
            having = {n for each in wanted & known.keys() for n in known[each].numbers.tolist()}
            places = [number for number in places if number in having]
        if reverse:
            places.sort(key=lambda number: (-self._places[number].end, -number))
        for number in places:
            place = self._places[number]
            yield from self._read_all(waiting.before(place.end if reverse else place.start))
            chunk = self._load(number)
            if chunk is not None:
                stamps = chunk.stamps
                keep = (stamps >= first) & (stamps <= last)
                if chosen is not None:
                    keep &= np.isin(chunk.channels, chosen)
                waiting.add(number, place.offset, chunk, np.flatnonzero(keep))
        yield from self._read_all(waiting.rest())

    def facts(self) -> Iterator[MessageFacts]:
        """Facts of all messages, part after part in the order of the file."""
        for number in self._in_file_order():
            chunk = self._load(number)
            if chunk is not None:
                yield facts_of(chunk)

    def salvage(self) -> Iterator[LoggedMessage]:
        """All messages in the order of the file; the times that their parts name do not count."""
        for number in self._in_file_order():
            place = self._places[number]
            try:
                raw = os.pread(self._handle, place.length + place.index_length, place.offset)
                chunk = without(self._unpacked(number, raw), self._known)
            except (RecordingError, OSError, MemoryError) as error:
                self.unreadable += place.length + place.index_length
                self._note(number, error)
                continue
            for index in np.argsort(chunk.offsets, kind="stable").tolist():
                yield message_at(chunk, index)

    def _in_file_order(self) -> list[int]:
        return sorted(range(len(self._places)), key=lambda number: self._places[number].offset)

    def _read_all(self, entries: Iterator[tuple[int, int]]) -> Iterator[LoggedMessage]:
        for number, index in entries:
            chunk = self._load(number)
            if chunk is not None:
                yield message_at(chunk, index)

    def _newest(self, channel: int, chunks: ChannelChunks, stamp: int) -> LoggedMessage | None:
        best: tuple[int, int, LoadedChunk, int] | None = None  # stamp, offset, chunk, index
        until = np.uint64(min(stamp, _MOST_STAMP))  # NumPy would compare integers as floats
        for at in range(int(np.searchsorted(chunks.starts, until, "right")) - 1, -1, -1):
            if best is not None and chunks.ends_before[at] < best[0]:
                break
            number = int(chunks.numbers[at])
            chunk = self._load(number)
            if chunk is None:
                continue
            ours = np.flatnonzero((chunk.channels == channel) & (chunk.stamps <= until))
            if ours.size:
                index = int(ours[-1])
                key = int(chunk.stamps[index]), self._places[number].offset
                if best is None or key > best[:2]:
                    best = (*key, chunk, index)
        return message_at(best[2], best[3]) if best is not None else None

    def _load(self, number: int) -> LoadedChunk | None:
        """A part of the file; None: it is damaged."""
        if number in self._loaded:
            self._loaded.move_to_end(number)
            return self._loaded[number]
        if number in self._damaged:
            return None
        place = self._places[number]
        try:
            raw = os.pread(self._handle, place.length + place.index_length, place.offset)
            chunk = self._checked(number, self._unpacked(number, raw))
        except (RecordingError, OSError, MemoryError) as error:
            self._damaged.add(number)
            self._note(number, error)
            return None
        self._loaded[number] = chunk
        self._loaded_bytes += len(chunk.records)
        while self._loaded_bytes > _CACHE_BYTES and len(self._loaded) > 1:
            _, oldest = self._loaded.popitem(last=False)
            self._loaded_bytes -= len(oldest.records)
        return chunk

    def _unpacked(self, number: int, raw: bytes) -> LoadedChunk:
        """A part of the file; of a damaged one what can be found, if that is wanted.

        Raises:
            RecordingError: It is damaged.
        """
        place = self._places[number]
        if place.packed and (fault := length_fault(raw, place)):
            self._note(number, fault)
        budget = self._budget.of_part(self._handle, place.offset)
        try:
            return load(raw, place, budget)
        except RecordingError as error:
            if not self._partial or isinstance(error, BudgetError):
                raise
            chunk = load(raw, place, budget, partial=True)
            if not chunk.stamps.size:
                raise
            count = f"{len(chunk.stamps)} of its messages are shown, which may be wrong"
            self._note(number, f"{error}; {count}")
            return chunk

    def _checked(self, number: int, chunk: LoadedChunk) -> LoadedChunk:
        """The messages whose channel is known, and whose time is that of their part."""
        place = self._places[number]
        count = len(chunk.stamps)
        chunk = without(chunk, self._known)
        if len(chunk.stamps) < count:
            self._note(number, f"{count - len(chunk.stamps)} messages have no topic")
        if chunk.stamps.size and not (
            place.start <= chunk.stamps[0] and chunk.stamps[-1] <= place.end
        ):
            keep = (chunk.stamps >= place.start) & (chunk.stamps <= place.end)
            self._note(
                number,
                f"{np.count_nonzero(~keep)} messages are of other times than the file says; "
                "`rune-hub log recover` makes a file with all of them",
            )
            chunk = chunk._replace(
                channels=chunk.channels[keep],
                stamps=chunk.stamps[keep],
                offsets=chunk.offsets[keep],
            )
        return chunk

    def _note(self, number: int, fault: str | Exception) -> None:
        one = isinstance(fault, BudgetError)  # one sentence for all parts
        sentence = str(fault) if one else f"at byte {self._places[number].offset}: {fault}"
        if len(self.faults) < MOST_FAULTS and sentence not in self.faults:
            self.faults.append(sentence)

    def _chunks_of_channels(self) -> dict[int, ChannelChunks]:
        """Which parts of the file have messages of a channel."""
        if self._of_channel is None:
            self._of_channel = by_channel(self._places, self._channels_in)
        return self._of_channel

    def _channels_in(self, number: int) -> npt.NDArray[np.uint16]:
        """The channels of a part that has no indexes."""
        chunk = self._load(number)
        return np.unique(chunk.channels) if chunk is not None else np.zeros(0, np.uint16)


def _attachment(handle: int, place: AttachmentPlace) -> bytes | None:
    """The content of a file within an open recording; None: it is damaged, or too long."""
    if not (0 <= place.size <= _MOST_ATTACHMENT and 0 <= place.offset < 1 << 62):
        return None
    names = place.name.encode(), place.media_type.encode()
    head = RECORD.size + 16 + sum(4 + len(each) for each in names) + 8
    raw = os.pread(handle, head + place.size + 4, place.offset)
    if len(raw) != head + place.size + 4 or raw[0] != ATTACHMENT:
        return None
    checksum = int.from_bytes(raw[-4:], "little")
    return raw[head:-4] if checksum in (0, zlib.crc32(raw[RECORD.size : -4])) else None
