"""What the recordings of a trial lack, in sentences: files, messages, and time at both ends."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from hub.recording.recording_set import RecordingSet

_AWAY_S = 2.0
"""A recording may begin after its trial, and end before it, by this much [s]."""
_SECOND = 1_000_000_000


def lacking_files(consoles: Sequence[Path], hubs: Sequence[Path], robots: int) -> Iterator[str]:
    """Which recordings a trial lacks.

    Args:
        consoles: Recordings of its console.
        hubs: Recordings of its robots' hubs.
        robots: Number of its robots.
    """
    if not consoles:
        yield "the console's recording is missing, so nothing is known of the operator's inputs"
    if len(hubs) < robots:
        yield f"{len(hubs)} of {robots} robots have a recording"


def lacking_time(recordings: RecordingSet, begin: int, end: int) -> Iterator[str]:
    """Which parts of a trial its recordings lack; damage counts as far as they were read.

    Args:
        recordings: Open recordings.
        begin: Begin of the trial [ns].
        end: Its end [ns].
    """
    for each, shift in zip(recordings.recordings, recordings.shifts, strict=True):
        name = each.path.name
        yield from (f"{name}: {fault}" for fault in each.faults)
        if not each.end:
            yield f"{name} has no message"
            continue
        late = (each.start + shift - begin) / _SECOND
        early = (end - each.end - shift) / _SECOND
        if late > _AWAY_S:
            yield f"{name} begins {late:.1f} s after the trial"
        if early > _AWAY_S:
            yield f"{name} ends {early:.1f} s before the trial"
