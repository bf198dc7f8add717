"""Several recordings lie on one time line, whatever their clocks."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hub.errors import RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.chunks import LoggedMessage
from hub.recording.reader import Recording
from hub.recording.recording_set import RecordingSet
from hub.recording.topics import RecordedTopic
from hub.recording.writer import RecordingWriter, WriterLimits

LIMITS = WriterLimits(least_free=0)
DATE = 1_700_000_000_000_000_000
SECOND = 1_000_000_000


def written(path: Path, anchor: TimeAnchor, topic: str, moments: list[float]) -> Path:
    path.parent.mkdir(exist_ok=True)
    writer = RecordingWriter(path, anchor, {}, LIMITS)
    writer.attach("name", "text/plain", topic.encode(), anchor.monotonic)
    for number, moment in enumerate(moments, 1):
        writer.add(RecordedTopic(topic), topic.encode(), moment, moment, number)
    writer.close()
    return path


def seen(messages: list[LoggedMessage], opened: RecordingSet) -> list[tuple[str, int]]:
    return [(opened.channels[each.channel].name, each.number) for each in messages]


def test_a_date_that_was_set_between_two_recordings_of_a_machine_moves_nothing(
    tmp_path: Path,
) -> None:
    hub = written(tmp_path / "hub.mcap", TimeAnchor(DATE, 50.0), "/a/X", [50.0, 52.0])
    late = TimeAnchor(DATE + 3600 * SECOND, 51.0)  # the date was set by an hour
    console = written(tmp_path / "console.mcap", late, "/b/Y", [51.0, 53.0])
    with RecordingSet.open([hub, console]) as opened:
        read = list(opened.messages())
        assert seen(read, opened) == [("/a/X", 1), ("/b/Y", 1), ("/a/X", 2), ("/b/Y", 2)]
        assert [each.stamp - DATE for each in read] == [0, SECOND, 2 * SECOND, 3 * SECOND]
        assert list(opened.messages(reverse=True)) == read[::-1]
        assert (opened.start, opened.end) == (DATE, DATE + 3 * SECOND)
        newest = opened.newest(DATE + 1_500_000_000)
        assert sorted(seen(list(newest.values()), opened)) == [("/a/X", 1), ("/b/Y", 1)]
        assert [opened.attachment(each) for each in opened.attachments] == [b"/a/X", b"/b/Y"]
        only = {number for number, topic in opened.channels.items() if topic.name == "/b/Y"}
        part = list(opened.messages(DATE + SECOND, DATE + 2 * SECOND, only))
        assert seen(part, opened) == [("/b/Y", 1)]


def test_recordings_of_two_machines_keep_their_dates(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hub = written(tmp_path / "hub.mcap", TimeAnchor(DATE, 50.0), "/a/X", [50.0])
    other = tmp_path / "boot_id"
    other.write_text("another\n")
    monkeypatch.setattr("hub.recording.writer.BOOT_FILE", other)
    far = written(tmp_path / "far.mcap", TimeAnchor(DATE - SECOND, 900.0), "/b/Y", [900.5])
    with RecordingSet.open([hub, far]) as opened:
        assert seen(list(opened.messages()), opened) == [("/b/Y", 1), ("/a/X", 1)]
        assert opened.shifts == (0, 0)


def test_a_folder_of_splits_is_one_recording_among_others(tmp_path: Path) -> None:
    anchor = TimeAnchor(DATE, 50.0)
    written(tmp_path / "splits/1.mcap", anchor, "/a/X", [50.0, 51.0])
    written(tmp_path / "splits/2.mcap", anchor, "/a/X", [52.0, 53.0])
    console = written(tmp_path / "console.mcap", anchor, "/a/X", [50.5])
    with RecordingSet.open([tmp_path / "splits", console]) as opened:
        numbers = [(each.channel, each.number) for each in opened.messages()]
        assert numbers == [(1, 1), (2, 1), (1, 2), (1, 1), (1, 2)]
        assert json.dumps(opened.counts) == json.dumps({1: 4, 2: 1})


def test_faults_name_the_file_and_a_missing_one_is_refused(tmp_path: Path) -> None:
    anchor = TimeAnchor(DATE, 50.0)
    good = written(tmp_path / "good.mcap", anchor, "/a/X", [50.0])
    cut = written(tmp_path / "cut.mcap", anchor, "/a/X", [50.0])
    cut.write_bytes(cut.read_bytes()[:200])
    with Recording.open(cut) as alone, RecordingSet.open([good, cut]) as opened:
        assert opened.faults == [f"cut.mcap: {fault}" for fault in alone.faults]
        assert len(alone.faults) == 1
        assert not opened.finished
    with pytest.raises(RecordingError, match=r"none\.mcap does not exist"):
        RecordingSet.open([good, tmp_path / "none.mcap"])
