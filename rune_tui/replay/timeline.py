"""The two rows under a recording: all of it by time, readable without colours; pure.

| character | meaning |
| --- | --- |
| `F` `!` `V` `B` `|` `·` | freeze, alarm, victim, bump, trial, note |
| `▂` | the operator interacts with a robot |
| `╱` | the recording has nothing |
| `▲` | the time that is shown |
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from rune_tui.replay.source import EventKind, Overview

_RANK: Final = [each.value for each in EventKind]
_EPISODE, _GAP, _HERE, _UNDER = "▂", "╱", "█", "▲"
SECOND: Final = 1_000_000_000


def column_of(stamp: int, start: int, end: int, width: int) -> int:
    """The column of a time [ns] on a timeline of some columns."""
    share = (stamp - start) / (end - start) if end > start else 0.0
    return min(width - 1, max(0, int(share * width)))


def stamp_of(column: int, start: int, end: int, width: int) -> int:
    """The time [ns] in the middle of a column."""
    return start + round((column + 0.5) / width * (end - start))


def marks_row(width: int, start: int, end: int, position: int, overview: Overview) -> str:
    """The upper row: episodes, gaps, and the most important event of each column.

    Args:
        width: Its width [cells].
        start: Begin of the recording [ns].
        end: End of the recording [ns].
        position: The time that is shown [ns].
        overview: What happened.
    """
    row = [" "] * width
    for spans, character in ((overview.episodes, _EPISODE), (overview.gaps, _GAP)):
        for span in spans:
            first, last = (column_of(each, start, end, width) for each in (span.start, span.end))
            row[first : last + 1] = character * (last + 1 - first)
    for event in overview.events:
        column = column_of(event.stamp, start, end, width)
        known = row[column]
        if known not in _RANK or _RANK.index(event.kind.value) < _RANK.index(known):
            row[column] = event.kind.value
    here = column_of(position, start, end, width)
    if row[here] not in _RANK:
        row[here] = _HERE
    return "".join(row)


def pointer_row(width: int, start: int, end: int, position: int, words: Iterable[str]) -> str:
    """The lower row: a pointer to the time that is shown, and words on its longer side.

    Args:
        width: Its width [cells].
        start: Begin of the recording [ns].
        end: End of the recording [ns].
        position: The time that is shown [ns].
        words: Forms of the words, the longest first.
    """
    here = column_of(position, start, end, width)
    left = here > width // 2
    room = here - 1 if left else width - here - 2
    text = next((each for each in words if len(each) <= room), "")
    row = [" "] * width
    row[here] = _UNDER
    at = 0 if left else width - len(text)
    row[at : at + len(text)] = text
    return "".join(row)


def clock_text(seconds: float) -> str:
    """A duration [s] such as 1:02:03.4 or 4:05.0."""
    tenths = round(10.0 * seconds)
    hours, minutes, rest = tenths // 36000, tenths // 600 % 60, tenths % 600 / 10.0
    return f"{hours}:{minutes:02d}:{rest:04.1f}" if hours else f"{minutes}:{rest:04.1f}"


def rate_text(rate: float, reached: float) -> str:
    """A rate such as x10, and the reached one if it is another."""
    text = f"x{rate:g}"
    return text if abs(reached - rate) < 0.1 * rate else f"{text} (reaches x{reached:.2g})"
