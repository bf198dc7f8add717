"""Recordings of one mission on one time line: of a hub, of consoles, of other robots.

| clocks of two recordings | their stamps |
| --- | --- |
| of one machine that ran on | those of the second are moved: both follow its monotonic clock |
| of two machines, or not known | stay: both follow the date, as exactly as the machines keep it |
"""

from __future__ import annotations

import contextlib
import heapq
import time
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from pathlib import Path
from typing import Self

from hub.errors import RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.chunks import LoggedMessage
from hub.recording.holes import time_line
from hub.recording.open_recording import OpenRecording
from hub.recording.reader import AttachmentPlace
from hub.recording.ros.bag import Bag
from hub.recording.topics import RecordedTopic
from hub.recording.writer import ABOUT, BOOT

MOST = 100
"""Most recordings that are open at once."""


class RecordingSet(OpenRecording):
    """Several recordings; the attributes and methods are those of `Recording`.

    Equal topics of two recordings are two channels, for both may have the same messages.

    Attributes:
        path: The first recording.
        recordings: Each of them: a file or a folder of splits.
        shifts: What is added to the stamps of each [ns].
        channels: Topics by number.
        counts: Number of messages by channel, where the files say it.
        attachments: Files within the recordings.
        finished: All files have their index.
        holes: Long times without messages, after `drop_outliers`: begin and end of each [ns].
    """

    def __init__(self, recordings: Sequence[Bag]) -> None:
        """Put open recordings on one time line; at least one."""
        self.path = recordings[0].path
        self.recordings = tuple(recordings)
        self.shifts = _shifts(recordings)
        placed = [each for each in zip(recordings, self.shifts, strict=True) if each[0].end]
        self.start = min((each.start + shift for each, shift in placed), default=0)
        self.end = max((each.end + shift for each, shift in placed), default=0)
        self.channels: dict[int, RecordedTopic] = {}
        self.counts: dict[int, int] = {}
        self._own: list[dict[int, int]] = []  # of each recording: its number, and the one here
        for recording in recordings:
            numbers = {}
            for channel, topic in recording.channels.items():
                number = numbers[channel] = len(self.channels) + 1
                self.channels[number] = topic
                if channel in recording.counts:
                    self.counts[number] = recording.counts[channel]
            self._own.append(numbers)
        self.attachments = tuple(place for each in recordings for place in each.attachments)
        self.finished = all(each.finished for each in recordings)
        self.holes: Sequence[tuple[int, int]] = ()
        self._time_faults: Sequence[str] = ()

    def drop_outliers(self) -> None:
        """Leave out messages whose stamps are far from all others, and find holes.

        `faults` names what is left out. `newest` still knows those before the start: what is said
        once holds on.
        """
        self.start, self.end, self.holes, self._time_faults = time_line(self)

    @classmethod
    def open(cls, paths: Sequence[Path], *, partial: bool = False, unpacked: int = 0) -> Self:
        """Open files and folders.

        Args:
            paths: The files and folders.
            partial: Whether damaged parts have those messages that can be found in them; these
                may be wrong themselves.
            unpacked: Most bytes that are unpacked of each; 0: by its size, see `ReadBudget`.

        Raises:
            RecordingError: One of them cannot be read, or there are more than `MOST`.
        """
        if not 0 < len(paths) <= MOST:
            text = f"1 to {MOST} recordings are read at once, not {len(paths)}"
            raise RecordingError(text)
        with contextlib.ExitStack() as opened:
            recordings = [
                opened.enter_context(Bag.open(path, partial=partial, unpacked=unpacked))
                for path in paths
            ]
            made = cls(recordings)
            opened.pop_all()
        return made

    def close(self) -> None:
        """Close all files."""
        for recording in self.recordings:
            recording.close()

    @property
    def faults(self) -> list[str]:
        """What is wrong with the files, in sentences."""
        several = len(self.recordings) > 1
        of_files = [
            f"{each.path.name}: {fault}" if several else fault
            for each in self.recordings
            for fault in each.faults
        ]
        return [*self._time_faults, *of_files]

    def check(self, seconds: float) -> None:
        """Look for damage in parts of MCAP files for a time [s]; see `faults`."""
        deadline = time.monotonic() + seconds
        for recording in self.recordings:
            recording.check(deadline)

    @property
    def anchor(self) -> TimeAnchor | None:
        """The clock of the first recording; None: it does not say it."""
        return self.recordings[0].anchor

    @property
    def about(self) -> Mapping[str, Mapping[str, str]]:
        """Metadata by name; that of earlier recordings counts."""
        found: dict[str, Mapping[str, str]] = {}
        for recording in reversed(self.recordings):
            found |= recording.about
        return found

    def attachment(self, place: AttachmentPlace) -> bytes:
        """The content of a file within a recording, which `attachments` names.

        Raises:
            RecordingError: It is damaged, or too long.
        """
        for recording in self.recordings:
            if any(each is place for each in recording.attachments):
                return recording.attachment(place)
        text = f"no recording has the file {place.name[:80]!r}"
        raise RecordingError(text)

    def newest(
        self, stamp: int, channels: AbstractSet[int] | None = None
    ) -> dict[int, LoggedMessage]:
        """The last message of each channel at or before a time [ns]; see `Recording.newest`."""
        found = {}
        for recording, shift, numbers in self._parts():
            own = _wanted(numbers, channels)
            for channel, message in recording.newest(stamp - shift, own).items():
                if channel in numbers:
                    found[numbers[channel]] = _moved(message, numbers[channel], shift)
        return found

    def messages(
        self,
        start: int | None = None,
        end: int | None = None,
        channels: AbstractSet[int] | None = None,
        *,
        reverse: bool = False,
    ) -> Iterator[LoggedMessage]:
        """All messages by stamp; see `Recording.messages`."""
        begin = self.start if start is None else start
        until = self.end if end is None else end

        def of(recording: Bag, shift: int, numbers: Mapping[int, int]) -> Iterator[LoggedMessage]:
            first, last = begin - shift, until - shift
            own = _wanted(numbers, channels)
            for message in recording.messages(first, last, own, reverse=reverse):
                if message.channel in numbers:
                    yield _moved(message, numbers[message.channel], shift)

        parts = [of(*each) for each in self._parts()]
        if len(parts) == 1:
            return parts[0]
        return heapq.merge(*parts, key=lambda message: message.stamp, reverse=reverse)

    def _parts(self) -> Iterator[tuple[Bag, int, Mapping[int, int]]]:
        return zip(self.recordings, self.shifts, self._own, strict=True)


def _wanted(numbers: Mapping[int, int], channels: AbstractSet[int] | None) -> set[int] | None:
    if channels is None:
        return None
    return {channel for channel, number in numbers.items() if number in channels}


def _moved(message: LoggedMessage, channel: int, shift: int) -> LoggedMessage:
    if not shift and channel == message.channel:
        return message
    return LoggedMessage(
        channel, message.stamp + shift, message.published + shift, message.number, message.payload
    )


def _shifts(recordings: Sequence[Bag]) -> tuple[int, ...]:
    """What is added to the stamps of each recording [ns]."""
    first: dict[str, TimeAnchor] = {}
    shifts = []
    for recording in recordings:
        anchor, boot = recording.anchor, recording.about.get(ABOUT, {}).get(BOOT, "")
        if anchor is None or not boot:
            shifts.append(0)
            continue
        line = first.setdefault(boot, anchor)
        shifts.append(line.stamp(anchor.monotonic) - anchor.wall_ns)
    return tuple(shifts)
