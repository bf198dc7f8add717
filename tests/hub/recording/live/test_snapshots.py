"""Snapshots that a recorder did not finish are written by the next one."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

import pytest

from hub.recording.anchor import TimeAnchor
from hub.recording.live.places import numbered
from hub.recording.live.series import RecordingSeries, SeriesLimits
from hub.recording.live.snapshots import Snapshot, left_snapshots
from hub.recording.reader import Recording
from hub.recording.topics import RecordedTopic
from hub.recording.writer import RecordingWriter, WriterLimits, boot
from tests.support.waiting import until

TOPIC = RecordedTopic("/rover/T")
LIMITS = WriterLimits(least_free=0)


class Clock:
    """A monotonic clock that is set."""

    def __init__(self, now: float) -> None:
        self.now = now

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def left(tmp_path: Path) -> Path:
    """A snapshot of which one of two files has its second name, and what else was under way."""
    ring, folder = tmp_path / "ring", tmp_path / "snapshots" / "bump.parts"
    ring.mkdir()
    folder.mkdir(parents=True)
    for name, moments in (("a", (1.0, 2.0, 3.0)), ("b", (4.0, 5.0, 6.0))):
        writer = RecordingWriter(ring / f"{name}.mcap", TimeAnchor(10**18, 0.0), {}, LIMITS)
        for moment in moments:
            writer.add(TOPIC, b"x", moment, moment, round(moment))
        writer.close()
    (folder / "00000-a.mcap").hardlink_to(ring / "a.mcap")
    note = {"begin": 2.0, "end": 5.0, "since": 0.0, "folder": str(ring)}
    (folder / "span.json").write_text(json.dumps(note))
    (folder.parent / ".bump.mcap.99999999.partial").write_bytes(b"half")
    return folder


def numbers(path: Path) -> list[int]:
    with Recording.open(path) as recording:
        return [each.number for each in recording.messages()]


def test_a_snapshot_that_a_crash_cut_is_finished(left: Path) -> None:
    (snapshot,) = left_snapshots(left.parent, lambda: None)

    def done() -> bool:
        snapshot.look(time.monotonic())
        return snapshot.done

    until(done, 30.0)
    assert snapshot.fault == ""
    # It begins with the newest message before the span.
    assert numbers(left.parent / "bump.mcap") == [1, 2, 3, 4, 5]
    assert [each.name for each in left.parent.iterdir()] == ["bump.mcap"]


@pytest.mark.parametrize("goes_on", [True, False])
def test_the_rest_of_a_span_is_waited_for_and_a_gap_is_named(left: Path, *, goes_on: bool) -> None:
    """The first recorder ended 2 s ago, 1 s after the begin; 6 s of the span are left."""
    now, date = time.monotonic(), time.time()
    begin, end, ring = now - 3.0, now + 6.0, left.parent.parent / "ring"
    for name in ("a", "b"):
        os.utime(ring / f"{name}.mcap", (date - 2.0, date - 2.0))
    note = {"begin": begin, "end": end, "since": date - 3.0, "folder": str(ring)}
    machine = boot() if goes_on else "before it was switched on again"
    (left / "span.json").write_text(json.dumps({**note, "boot": machine}))
    clock, begun = Clock(now), list[RecordingSeries]()
    (snapshot,) = left_snapshots(left.parent, lambda: begun[0] if begun else None)
    series = RecordingSeries(
        numbered(ring / "c.mcap"), {}, SeriesLimits(writer=LIMITS), latched={}, clock=clock
    )
    begun.append(series)

    def written() -> bool:
        snapshot.look(clock.now)
        return snapshot.done

    if goes_on:
        snapshot.look(clock.now)
        for number in (7, 8, 9):
            clock.now += 2.0
            series.add(TOPIC, b"x", clock.now - 0.1, clock.now - 0.1, number)
            assert not list(left.parent.glob("bump.mcap"))
            snapshot.look(clock.now - 0.1)
    until(written, 30.0)
    series.close()
    missing = 2.0 if goes_on else 8.0
    assert f"it lacks {missing:.1f} of 9.0 s" in snapshot.fault
    assert {7, 8, 9}.issubset(numbers(left.parent / "bump.mcap")) is goes_on


def test_a_snapshot_of_a_recording_that_ended_opens_no_file(tmp_path: Path) -> None:
    clock = Clock(100.0)
    series = RecordingSeries(
        numbered(tmp_path / "c.mcap"), {}, SeriesLimits(writer=LIMITS), latched={}, clock=clock
    )
    series.add(TOPIC, b"x", 100.0, 100.0, 1)
    snapshot = Snapshot(series, tmp_path / "kept" / "bump.mcap", 99.0, 101.0)
    series.close()

    def written() -> bool:
        snapshot.look(102.0)
        return snapshot.done

    until(written, 30.0)
    assert numbers(tmp_path / "kept" / "bump.mcap") == [1]
    assert [each.name for each in tmp_path.glob("*.mcap")] == ["c.mcap"]


def test_a_finished_snapshot_needs_its_parts_no_more(left: Path) -> None:
    (left.parent / "bump.mcap").write_bytes(b"whole")
    assert left_snapshots(left.parent, lambda: None) == []
    assert [each.name for each in left.parent.iterdir()] == ["bump.mcap"]


@pytest.mark.parametrize("note", ["", "{}", "[]", '{"begin": "x", "end": 1, "since": 0}'])
def test_a_damaged_note_is_named_and_its_parts_stay(
    left: Path, note: str, caplog: pytest.LogCaptureFixture
) -> None:
    (left / "span.json").write_text(note)
    assert left_snapshots(left.parent, lambda: None) == []
    assert f"snapshot {left.parent / 'bump.mcap'} cannot be finished" in caplog.text
    assert (left / "00000-a.mcap").exists()
