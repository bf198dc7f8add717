"""Snapshots that a recorder did not finish are written by the next one."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest

from hub.recording.anchor import TimeAnchor
from hub.recording.live.snapshots import left_snapshots
from hub.recording.reader import Recording
from hub.recording.topics import RecordedTopic
from hub.recording.writer import RecordingWriter, WriterLimits
from tests.support.waiting import until

TOPIC = RecordedTopic("/rover/T")
LIMITS = WriterLimits(least_free=0)


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
    (snapshot,) = left_snapshots(left.parent)

    def done() -> bool:
        snapshot.look(time.monotonic())
        return snapshot.done

    until(done, 30.0)
    assert snapshot.fault == ""
    # It begins with the newest message before the span.
    assert numbers(left.parent / "bump.mcap") == [1, 2, 3, 4, 5]
    assert [each.name for each in left.parent.iterdir()] == ["bump.mcap"]


def test_a_finished_snapshot_needs_its_parts_no_more(left: Path) -> None:
    (left.parent / "bump.mcap").write_bytes(b"whole")
    assert left_snapshots(left.parent) == []
    assert [each.name for each in left.parent.iterdir()] == ["bump.mcap"]


@pytest.mark.parametrize("note", ["", "{}", "[]", '{"begin": "x", "end": 1, "since": 0}'])
def test_a_damaged_note_is_named_and_its_parts_stay(
    left: Path, note: str, caplog: pytest.LogCaptureFixture
) -> None:
    (left / "span.json").write_text(note)
    assert left_snapshots(left.parent) == []
    assert f"snapshot {left.parent / 'bump.mcap'} cannot be finished" in caplog.text
    assert (left / "00000-a.mcap").exists()
