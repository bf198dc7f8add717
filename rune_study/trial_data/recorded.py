"""The recordings of a trial, open: what each robot's hub and the console have of it."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from hub.recording.recording_set import RecordingSet
from rune_study.errors import DataError
from rune_study.trial_data.measured import roles_of
from rune_study.trial_data.trial_log import TrialLog


@contextlib.contextmanager
def recorded_robots(
    consoles: Sequence[Path], hubs: Sequence[Path], begin: float, end: float
) -> Iterator[dict[str, tuple[TrialLog, RecordingSet]]]:
    """The log of each robot with its open recordings, by the robot's name in the layout.

    Args:
        consoles: Recordings of the console.
        hubs: Recordings of the robots' hubs, in the order of the layout.
        begin: Begin on the monotonic clock [s].
        end: End on that clock [s].

    Raises:
        RecordingError: A file cannot be read.
        DataError: A recording does not say its clock.
    """
    with contextlib.ExitStack() as stack:
        opened = [
            stack.enter_context(RecordingSet.open([*consoles, *hub]))
            for hub in ([[each] for each in hubs] or [[]])
        ]
        logs = [_log(each, begin, end) for each in opened]
        roles = roles_of(logs[0]) if consoles else []
        roles += [f"robot {number + 1}" for number in range(len(roles), len(logs))]
        yield dict(zip(roles, zip(logs, opened, strict=True), strict=False))


def _log(recordings: RecordingSet, begin: float, end: float) -> TrialLog:
    """A trial in recordings that follow the monotonic clock of one machine."""
    anchor = recordings.anchor
    if anchor is None:
        text = f"{recordings.path.name} does not say its clock"
        raise DataError(text)
    return TrialLog(recordings, anchor.stamp(begin), anchor.stamp(end))
