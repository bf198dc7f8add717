"""Holes in the time of a recording, and messages whose stamps are far from all others.

A simulation logs at 0 before its clock comes, a clock that was not set says 1970, and damage says
anything. Such messages would make a recording of a minute 56 years long.
"""

from __future__ import annotations

import datetime
import itertools
from collections.abc import Sequence
from typing import Final, NamedTuple

from hub.plain_text import counted
from hub.recording.open_recording import OpenRecording

HOLE_NS: Final = 3600 * 10**9
"""Time without any message that is a hole [ns]."""
_MOST_COUNTED: Final = 1000
_MOST_PARTS: Final = 100
_SHARE: Final = 20
"""A part at an end with less than this part of the messages of the largest is left out."""
_EARLIEST: Final = 10**18
"""Stamps before this, 2001, are no dates [ns since 1970]."""
_LATEST: Final = 4_102_444_800 * 10**9
"""Stamps from this on, 2100, are none either."""
_GROWS_OLD_NS: Final = 5 * 10**9
"""Time at the begin of a hole in which one sees that all grows old [ns]."""


class Part(NamedTuple):
    """A part of a recording without holes.

    Attributes:
        start: Stamp of its first message [ns].
        end: Stamp of its last message [ns].
        messages: Their number, at most `_MOST_COUNTED`.
    """

    start: int
    end: int
    messages: int


class TimeLine(NamedTuple):
    """What of a recording's time is looked at.

    Attributes:
        start: Its begin [ns].
        end: Its end [ns].
        holes: Times without messages in it: begin and end of each [ns].
        faults: What is left out, in sentences.
    """

    start: int
    end: int
    holes: Sequence[tuple[int, int]]
    faults: Sequence[str]


def time_line(recording: OpenRecording) -> TimeLine:
    """The time of a recording without the messages that are far from all others."""
    whole = TimeLine(recording.start, recording.end, (), ())
    if recording.end - recording.start <= HOLE_NS:
        return whole
    parts = _parts(recording)
    if len(parts) < 2 or len(parts) == _MOST_PARTS:
        return whole
    largest = max(parts, key=lambda part: (part.messages, part.end - part.start))
    first = next(at for at, part in enumerate(parts) if _counts(part, largest))
    last = next(at for at in range(len(parts) - 1, -1, -1) if _counts(parts[at], largest))
    left_out = (*parts[:first], *parts[last + 1 :])
    shown = parts[first : last + 1]
    holes = [(a.end, b.start) for a, b in itertools.pairwise(shown)]
    far = "are far from all others, and left out"
    faults = [f"{_number(each)} at {_date(each.start)} {far}" for each in left_out]
    return TimeLine(shown[0].start, shown[-1].end, tuple(holes), tuple(faults))


def said_of_holes(holes: Sequence[tuple[int, int]]) -> list[str]:
    """A sentence for each hole; begin and end of each [ns]. A hole is no fault of a file."""
    return [f"no message from {_date(begin)} to {_date(end)}" for begin, end in holes]


def beyond_hole(holes: Sequence[tuple[int, int]], stamp: int, *, backwards: bool = False) -> int:
    """A time [ns]; in a hole, its end, or backwards the time at which all has grown old in it."""
    for begin, end in holes:
        old = begin + _GROWS_OLD_NS
        if old < stamp < end:
            return old if backwards else end
    return stamp


def _parts(recording: OpenRecording) -> list[Part]:
    """The parts of a recording; it stops at the most."""
    found: list[Part] = []
    following = next(recording.messages(), None)
    while following is not None and len(found) < _MOST_PARTS:
        begin = end = following.stamp
        while True:
            newest = next(recording.messages(end, end + HOLE_NS, reverse=True), None)
            if newest is None or newest.stamp <= end:
                break
            end = newest.stamp
        messages = itertools.islice(recording.messages(begin, end), _MOST_COUNTED)
        found.append(Part(begin, end, sum(1 for _ in messages)))
        following = next(recording.messages(end + 1), None)
    return found


def _counts(part: Part, largest: Part) -> bool:
    """Whether a part is more than some messages with wrong stamps."""
    dated = largest.start >= _EARLIEST and largest.end < _LATEST
    wrong = dated and not (part.start >= _EARLIEST and part.end < _LATEST)
    return part == largest or (not wrong and part.messages * _SHARE >= largest.messages)


def _number(part: Part) -> str:
    more = "at least " if part.messages == _MOST_COUNTED else ""
    return more + counted(part.messages, "message")


def _date(stamp: int) -> str:
    try:
        moment = datetime.datetime.fromtimestamp(stamp / 1e9, datetime.UTC).astimezone()
    except (ValueError, OverflowError, OSError):
        return f"{stamp / 1e9:.0f} s"
    return f"{moment:%Y-%m-%d %H:%M:%S}"
