"""Files of a series: split, deleted, begun again after a fault, each complete by itself."""

from __future__ import annotations

import itertools
import random
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hub.recording.anchor import TimeAnchor
from hub.recording.live.places import numbered
from hub.recording.live.series import RETRY_S, LatchedMessage, RecordingSeries, SeriesLimits
from hub.recording.reader import Recording
from hub.recording.topics import RecordedTopic
from hub.recording.writer import WriterLimits
from tests.support.waiting import until

TOPIC = RecordedTopic("/rover/T")
SEEN = WriterLimits(chunk_bytes=200, chunk_s=0.06, least_free=0)
"""What is written is in the file after some milliseconds."""


class Clock:
    """A monotonic clock, and a date that may be set."""

    def __init__(self) -> None:
        self.now = 1000.0
        self.date = 1_700_000_000.0

    def __call__(self) -> float:
        return self.now

    def anchor(self) -> TimeAnchor:
        return TimeAnchor(round((self.date + self.now) * 1e9), self.now)


class Rig:
    """A series with a clock of its own."""

    def __init__(self, folder: Path, **limits: Any) -> None:
        self.clock = Clock()
        self.folder = folder
        self.said: list[str] = []
        self.latched: dict[str, LatchedMessage] = {}
        limits.setdefault("writer", SEEN)
        self.series = RecordingSeries(
            numbered(folder / "a.mcap"),
            {"robot": "rover"},
            SeriesLimits(**limits),
            latched=self.latched,
            clock=self.clock,
            anchor=self.clock.anchor,
            say=self.said.append,
        )
        self._numbers = itertools.count(1)

    def add(self, count: int = 1, size: int = 10) -> None:
        for _ in range(count):
            now, number = self.clock.now, next(self._numbers)
            self.series.add(TOPIC, random.Random(number).randbytes(size), now, now, number)

    def settle(self) -> None:
        until(lambda: self.series.settled, 10.0)
        self.series.look()

    def numbers(self) -> dict[str, list[int]]:
        """The numbers of the messages of the topic, by file."""
        found = {}
        for path in sorted(self.folder.glob("*.mcap")):
            with Recording.open(path) as recording:
                found[path.name] = [
                    each.number
                    for each in recording.messages()
                    if recording.channels[each.channel].name == TOPIC.name
                ]
        return found


def test_a_series_goes_on_in_the_next_file_after_its_time(tmp_path: Path) -> None:
    rig = Rig(tmp_path, split_s=60.0)
    for _ in range(3):
        rig.add(2)
        rig.clock.now += 61.0
        rig.series.look()
    state = rig.series.close()
    assert rig.numbers() == {
        "a.mcap": [1, 2], "a_1.mcap": [3, 4], "a_2.mcap": [5, 6], "a_3.mcap": [],
    }  # fmt: skip
    assert (state.messages, state.files, dict(state.lost), state.fault) == (6, 4, {}, "")
    assert state.bytes == sum(path.stat().st_size for path in tmp_path.glob("*.mcap"))


def test_a_series_goes_on_in_the_next_file_at_its_size(tmp_path: Path) -> None:
    rig = Rig(tmp_path, split_bytes=2000)
    rig.add(5, 1000)
    until(lambda: rig.series.state.bytes >= 2000, 10.0)
    rig.series.look()
    rig.add()
    rig.series.close()
    assert rig.numbers() == {"a.mcap": [1, 2, 3, 4, 5], "a_1.mcap": [6]}


def test_each_file_begins_with_the_latched_messages(tmp_path: Path) -> None:
    rig = Rig(tmp_path, split_s=60.0)
    body = RecordedTopic("/rover/GCM_RobotDescription")
    rig.series.add(body, b"first", rig.clock.now, rig.clock.now, 7)
    rig.latched[body.name] = LatchedMessage(body, b"first", rig.clock.now, 7)
    rig.clock.now += 61.0
    rig.series.look()
    rig.add()
    rig.series.close()
    with Recording.open(tmp_path / "a_1.mcap") as recording:
        first = next(iter(recording.messages()))
        assert recording.channels[first.channel].name == body.name
        assert (first.payload, first.number) == (b"first", 7)
        assert first.stamp - first.published == 61_000_000_000


def test_a_ring_deletes_what_is_too_old(tmp_path: Path) -> None:
    rig = Rig(tmp_path, split_s=60.0, keep_s=120.0, keep_bytes=10**9)
    for _ in range(6):
        rig.add()
        rig.clock.now += 61.0
        rig.series.look()
        rig.settle()
    assert 120.0 <= rig.series.state.reaches <= 120.0 + 2 * 61.0
    rig.series.close()
    assert sorted(rig.numbers()) == ["a_4.mcap", "a_5.mcap", "a_6.mcap"]


def test_a_ring_deletes_what_is_too_much(tmp_path: Path) -> None:
    rig = Rig(tmp_path, split_s=60.0, keep_s=1e6, keep_bytes=5000)
    for _ in range(4):
        rig.add(1, 2000)
        rig.clock.now += 61.0
        rig.series.look()
        rig.settle()
    rig.series.close()
    kept = sum(path.stat().st_size for path in tmp_path.glob("*.mcap"))
    assert 0 < kept <= 5000 + 4000
    assert [3] not in rig.numbers().values() or [1] not in rig.numbers().values()


def test_a_ring_takes_the_files_of_an_earlier_run_as_its_oldest(tmp_path: Path) -> None:
    first = Rig(tmp_path, split_s=60.0, keep_s=1e6, keep_bytes=10**9)
    first.add()
    first.series.close()
    rig = Rig(tmp_path, split_s=60.0, keep_s=1e6, keep_bytes=0)
    rig.series.adopt(tmp_path)
    rig.settle()
    rig.add()
    rig.series.close()
    assert "a.mcap" not in rig.numbers()


def test_a_full_disk_costs_messages_and_the_series_goes_on_with_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = [2**20]
    # The edge of the hardware: a disk with this room.
    disk = SimpleNamespace(f_frsize=1)
    monkeypatch.setattr("os.statvfs", lambda _: (setattr(disk, "f_bavail", free[0]), disk)[1])
    limits = WriterLimits(chunk_bytes=200, chunk_s=0.06, least_free=2**30)
    blocked = Rig(tmp_path, writer=limits)
    assert "are free on the disk" in blocked.series.state.fault
    blocked.add(3)
    blocked.series.look()
    assert dict(blocked.series.state.lost) == {TOPIC.name: 3}
    free[0] = 2**40
    blocked.clock.now += RETRY_S
    blocked.series.look()
    assert blocked.series.state.fault == ""
    blocked.add()
    state = blocked.series.close()
    assert (state.messages, dict(state.lost)) == (1, {TOPIC.name: 3})


def test_a_disk_that_hangs_at_the_end_is_waited_for_no_longer_than_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = threading.Event()
    # The edge of the hardware: a disk that does not say that it has the data.
    monkeypatch.setattr("os.fdatasync", lambda _: answers.wait(20.0))
    rig = Rig(tmp_path)
    rig.add()
    state = rig.series.close(0.05)
    assert not answers.is_set()
    assert state.fault.endswith("a.mcap has no end yet: the disk has not taken it for 0.05 s")
    answers.set()
    until(lambda: rig.series.settled, 10.0)
    assert rig.numbers() == {"a.mcap": [1]}


def test_a_disk_that_stays_full_gets_no_more_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = Rig(tmp_path)
    # The edge of the hardware: a disk that is full, then nearly full, then is not.
    disk = SimpleNamespace(f_frsize=1, f_bavail=0)
    monkeypatch.setattr("os.statvfs", lambda _: disk)
    rig.series.split()
    for free in (0, 1000, 999_999):
        disk.f_bavail = free
        rig.add()
        rig.clock.now += RETRY_S
        rig.series.look()
    assert rig.series.state.files == 1
    assert rig.series.state.lost == {TOPIC.name: 3}
    disk.f_bavail = 1_000_000
    rig.clock.now += RETRY_S
    rig.series.look()
    assert rig.series.state.fault == ""
    assert rig.series.close().files == 2
    assert rig.said == [
        f"nothing is recorded: only 0 MB are free on the disk of {tmp_path}",
        f"recording goes on in {tmp_path / 'a_1.mcap'}",
    ]


def test_a_date_that_is_set_moves_no_stamp_within_a_file(tmp_path: Path) -> None:
    rig = Rig(tmp_path, split_s=60.0)
    rig.add()
    rig.clock.date += 3600.0
    rig.clock.now += 1.0
    rig.add()
    rig.clock.now += 60.0
    rig.series.look()
    rig.add()
    rig.series.close()
    with Recording.open(tmp_path / "a.mcap") as one, Recording.open(tmp_path / "a_1.mcap") as two:
        assert one.end - one.start == 1_000_000_000
        assert two.start - one.end == 3_660_000_000_000
        assert one.anchor is not None
        assert two.anchor is not None
        assert two.anchor.moment(two.start) - one.anchor.moment(one.end) == pytest.approx(60.0)
