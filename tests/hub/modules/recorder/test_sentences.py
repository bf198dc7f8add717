"""What the recorder says of a mark and of an end: what the files have, and why others have not."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

from hub.errors import RecordingError
from hub.gcm.recording import RecordMark
from hub.modules.recorder.sentences import said_of_end, said_of_mark
from hub.recording.live.series import SeriesState

MARK = RecordMark(number=3, text="", by="", stamp=1.0)
SLOW = "the disk has not taken it for 2 s"


class Disk:
    """The time, and how long the disk takes for each series."""

    def __init__(self) -> None:
        self.now = 100.0

    def series(self, takes_s: float, fault: str = "") -> Any:
        state = SeriesState(
            path=Path("a"), files=1, messages=0, bytes=0, lost={}, fault=fault, reaches=0.0
        )
        return _Series(self, takes_s, state)


class _Series:
    def __init__(self, disk: Disk, takes_s: float, state: SeriesState) -> None:
        self._disk, self._takes_s, self.state = disk, takes_s, state

    def keeps(self, patience: float) -> bool:
        self._disk.now += min(patience, self._takes_s)
        return self._takes_s <= patience and not self.state.fault


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Disk:
    made = Disk()
    monkeypatch.setattr(time, "monotonic", lambda: made.now)
    return made


def test_a_disk_that_hangs_holds_the_recorder_up_once_and_not_for_each_series(disk: Disk) -> None:
    """A module that is silent for 5 s counts as hanging."""
    begun = disk.now
    with pytest.raises(RecordingError, match=f"mark 3 is not kept: {SLOW}; {SLOW}"):
        said_of_mark([disk.series(60.0), disk.series(60.0)], MARK)
    assert disk.now - begun == pytest.approx(2.0)


def test_a_mark_in_a_part_of_the_files_is_said_to_be_there_only(disk: Disk) -> None:
    whole = [disk.series(0.01), disk.series(0.02)]
    assert said_of_mark(whole, MARK) == "mark 3 is kept"
    part = [disk.series(0.01), disk.series(0.0, fault="the disk is full")]
    said = "mark 3 is kept; only in a part of the files: the disk is full"
    assert said_of_mark(part, MARK) == said


def test_an_end_that_lacks_messages_is_no_success(disk: Disk) -> None:
    whole = disk.series(0.0).state
    assert said_of_end(whole, 0) == "0 messages (0.0 MB) are in a"
    for state, lost, said in (
        (whole, 7, "is ended, and lacks 7 messages; 0 messages"),
        (disk.series(0.0, fault="the disk hangs").state, 0, "lacks 0 messages: the disk hangs;"),
    ):
        with pytest.raises(RecordingError, match=said):
            said_of_end(state, lost)
