"""What is in a recording: its topics with rates, sizes, losses and gaps; marks and faults."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.errors import RecordingError
from hub.recording.chunks import MessageFacts
from hub.recording.recording_set import RecordingSet
from hub.recording.tools.clock_jumps import ClockJump, ClockJumps
from hub.recording.tools.selection import LoggedMark, marks_of
from hub.recording.topics import RecordedTopic
from hub.recording.writer import ABOUT, LOST
from hub.values import dataclass

GAP_S = 1.0
"""Time without any message that is a gap [s]."""
_MOST_GAPS = 100
_MOST_MARKS = 1000
_GAP = int(GAP_S * 1e9)


@dataclass(slots=True, kw_only=True)
class TopicFacts:
    """What a recording has of a topic.

    Attributes:
        topic: The topic.
        messages: Number of messages.
        bytes: Length of their payloads [bytes]; -1: not known.
        start: Stamp of the first [ns].
        end: Stamp of the last [ns].
        missing: Numbers that are left out between them; -1: not known, as where
            several publishers share the topic, or a console counts all topics together.
        longest_gap: Longest time between two [ns]; -1: not known.
    """

    topic: RecordedTopic
    messages: int = 0
    bytes: int = -1
    start: int = 0
    end: int = 0
    missing: int = -1
    longest_gap: int = -1

    @property
    def rate_hz(self) -> float:
        """Mean rate between the first and the last [1/s]; 0: not known."""
        return (self.messages - 1) * 1e9 / (self.end - self.start) if self.end > self.start else 0.0


@dataclass(slots=True, kw_only=True)
class RecordingFacts:
    """What is in a recording.

    Attributes:
        path: The file or folder.
        size: Length of its files [bytes].
        start: Stamp of the first message [ns].
        end: Stamp of the last [ns].
        finished: It has its index.
        topics: Its topics, by name.
        gaps: Times without any message of `GAP_S` or longer: begin and end of each [ns].
        jumps: Where its clock jumps back, the first ones; None: not known.
        lost: Messages that its writer could not write, by topic.
        marks: Its marks.
        about: Its metadata.
        attachments: Names of the files within it.
        faults: What is wrong with it, in sentences.
        looked: All of it was read; else gaps, jumps, marks and damage are not known.
    """

    path: Path
    size: int
    start: int
    end: int
    finished: bool
    topics: list[TopicFacts] = field(default_factory=list)
    gaps: list[tuple[int, int]] = field(default_factory=list)
    jumps: list[ClockJump] | None = None
    lost: dict[str, int] = field(default_factory=dict)
    marks: list[LoggedMark] = field(default_factory=list)
    about: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    looked: bool = False

    @property
    def messages(self) -> int:
        """Number of all messages."""
        return sum(each.messages for each in self.topics)


def facts_of_recording(
    path: Path, progress: Callable[[float], None], *, quick: bool = False, unpacked: int = 0
) -> RecordingFacts:
    """Read what is in a recording.

    Args:
        path: A file or a folder.
        progress: Is called now and then with the share that is done.
        quick: Whether the index is enough: without sizes, losses, gaps, jumps and marks.
        unpacked: Most bytes that are unpacked; 0: by its size.

    Raises:
        RecordingError: It cannot be read.
    """
    with RecordingSet.open([path], unpacked=unpacked) as recording:
        about = {name: dict(facts) for name, facts in recording.about.items()}
        found = RecordingFacts(
            path=path,
            size=size_of(path),
            start=recording.start,
            end=recording.end,
            finished=recording.finished,
            lost=_lost(about.pop(LOST, {})),
            about=about,
            attachments=[place.name for place in recording.attachments],
        )
        count = _Count(recording, numbered=_counted_by_topic(about))
        known = recording.counts.keys() >= recording.channels.keys() or bool(recording.counts)
        if quick and known and recording.finished:
            for number, topic in count.topics.items():
                topic.messages = recording.counts.get(number, 0)
        else:
            jumps = ClockJumps()
            length = max(1, recording.end - recording.start)
            for facts in recording.recordings[0].facts():
                count.add(facts)
                jumps.add(facts)
                if facts.stamps.size:
                    progress((int(facts.stamps[-1]) - recording.start) / length)
            found.looked = True
            found.gaps = count.gaps()
            found.jumps = jumps.found()
            found.marks = list(itertools.islice(marks_of(recording), _MOST_MARKS))
        found.topics = sorted(count.topics.values(), key=lambda each: each.topic.name)
        found.faults = recording.faults
        return found


def size_of(path: Path) -> int:
    """Length of a file, or of all files of a folder [bytes].

    Raises:
        RecordingError: It cannot be read.
    """
    try:
        files = [path] if path.is_file() else [each for each in path.iterdir() if each.is_file()]
        return sum(each.stat().st_size for each in files)
    except OSError as error:
        text = f"{path} cannot be read: {error.strerror}"
        raise RecordingError(text) from error


def as_json(facts: RecordingFacts) -> dict[str, Any]:
    """The same as values of JSON; times in seconds, those since 1970 as texts in nanoseconds."""
    return {
        "path": str(facts.path),
        "bytes": facts.size,
        "start_ns": str(facts.start),
        "end_ns": str(facts.end),
        "duration_s": (facts.end - facts.start) / 1e9,
        "messages": facts.messages,
        "finished": facts.finished,
        "topics": [
            {
                "name": each.topic.name,
                "type": each.topic.schema_name,
                "encoding": each.topic.encoding,
                "messages": each.messages,
                "rate_hz": round(each.rate_hz, 3),
                "bytes": each.bytes if each.bytes >= 0 else None,
                "missing": each.missing if each.missing >= 0 else None,
                "longest_gap_s": each.longest_gap / 1e9 if each.longest_gap >= 0 else None,
            }
            for each in facts.topics
        ],
        "gaps": [{"start_ns": str(a), "duration_s": (b - a) / 1e9} for a, b in facts.gaps]
        if facts.looked
        else None,
        "clock_jumps": [{"stamp_ns": str(a), "back_s": back / 1e9} for a, back in facts.jumps]
        if facts.jumps is not None
        else None,
        "lost": facts.lost,
        "marks": [
            {"number": each.number, "stamp_ns": str(each.stamp), "text": each.text}
            for each in facts.marks
        ]
        if facts.looked
        else None,
        "about": facts.about,
        "attachments": facts.attachments,
        "faults": facts.faults,
    }


class _Count:
    """Counts messages by topic, part after part.

    Attributes:
        topics: What was found, by channel.
    """

    def __init__(self, recording: RecordingSet, *, numbered: bool) -> None:
        self.topics = {
            number: TopicFacts(topic=topic) for number, topic in recording.channels.items()
        }
        self._numbered = numbered
        self._numbers: dict[int, int] = {}
        self._uncounted: set[int] = set()  # channels whose numbers are not of one publisher
        self._covered: list[tuple[int, int]] = []  # spans with messages, at most GAP_S apart

    def add(self, facts: MessageFacts) -> None:
        if not facts.stamps.size:
            return
        for begin, end in _spans(facts.stamps):
            self._cover(begin, end)
        order = np.argsort(facts.channels, kind="stable")  # stamps are in order
        found, begins = np.unique(facts.channels[order], return_index=True)
        for channel, ours in zip(found.tolist(), np.split(order, begins[1:]), strict=True):
            self._add_topic(channel, facts.stamps[ours], facts.numbers[ours], facts.lengths[ours])

    def gaps(self) -> list[tuple[int, int]]:
        """Times between spans with messages, the first ones."""
        spans = _joined(self._covered)
        found = [(a[1], b[0]) for a, b in itertools.pairwise(spans)]
        return found[:_MOST_GAPS]

    def _cover(self, begin: int, end: int) -> None:
        if self._covered and begin <= self._covered[-1][1] + _GAP:
            first, last = self._covered[-1]
            if begin >= first:
                self._covered[-1] = first, max(last, end)
                return
        self._covered.append((begin, end))
        if len(self._covered) > 100 * _MOST_GAPS:
            self._covered = _joined(self._covered)[-10 * _MOST_GAPS :]

    def _add_topic(
        self,
        channel: int,
        stamps: npt.NDArray[np.uint64],
        numbers: npt.NDArray[np.uint32],
        lengths: npt.NDArray[np.uint64],
    ) -> None:
        topic = self.topics.get(channel)
        if topic is None:
            return
        first, last = int(stamps[0]), int(stamps[-1])
        gap = int(np.diff(stamps).max()) if len(stamps) > 1 else 0
        if topic.messages:
            gap = max(gap, first - topic.end)
        topic.start = min(topic.start, first) if topic.messages else first
        topic.end = max(topic.end, last)
        topic.messages += len(stamps)
        topic.bytes = max(0, topic.bytes) + int(lengths.sum())
        topic.longest_gap = max(topic.longest_gap, gap)
        if self._numbered and numbers.all():
            before = self._numbers.get(channel, int(numbers[0]) - 1)
            steps = np.diff(numbers.astype(np.int64), prepend=before)
            self._numbers[channel] = int(numbers[-1])
            if steps.min() < 1:  # several publishers, or one that began again
                self._uncounted.add(channel)
            counted = channel not in self._uncounted
            topic.missing = max(0, topic.missing) + int((steps - 1).sum()) if counted else -1


def _spans(stamps: npt.NDArray[np.uint64]) -> Iterator[tuple[int, int]]:
    """First and last stamp of each run without a gap."""
    breaks = np.flatnonzero(np.diff(stamps) >= _GAP)
    begins = [0, *(breaks + 1).tolist()]
    ends = [*breaks.tolist(), len(stamps) - 1]
    for begin, end in zip(begins, ends, strict=True):
        yield int(stamps[begin]), int(stamps[end])


def _joined(spans: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The same times as spans in order, with gaps between all of them."""
    found: list[tuple[int, int]] = []
    for begin, end in sorted(spans):
        if found and begin - found[-1][1] < _GAP:
            found[-1] = found[-1][0], max(found[-1][1], end)
        else:
            found.append((begin, end))
    return found


def _counted_by_topic(about: dict[str, dict[str, str]]) -> bool:
    """Whether each publisher counts each topic, as in recordings that a hub made."""
    made = [facts for name, facts in about.items() if name.partition(" ")[0] == ABOUT]
    return bool(made) and all(facts.get("recorder") == "hub" for facts in made)


def _lost(facts: dict[str, str]) -> dict[str, int]:
    return {topic: int(count) for topic, count in facts.items() if count.isdigit()}
