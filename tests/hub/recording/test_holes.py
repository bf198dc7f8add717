"""A few wrong stamps make no recording years long, and long holes are named."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from hub.recording.anchor import TimeAnchor
from hub.recording.holes import said_of_holes
from hub.recording.recording_set import RecordingSet
from hub.recording.topics import RecordedTopic
from hub.recording.writer import RecordingWriter, WriterLimits

NOW, SECOND, HOUR = 1_790_000_000 * 10**9, 10**9, 3600 * 10**9
USUAL = [NOW + number * SECOND // 20 for number in range(200)]
TOPIC = RecordedTopic("/r/T")


def recorded(path: Path, stamps: list[int], **limits: int) -> RecordingSet:
    anchor = TimeAnchor(0, 0.0)
    writer = RecordingWriter(path, anchor, {}, WriterLimits(least_free=0, **limits))
    for stamp in stamps:
        writer.add(TOPIC, b"x", stamp / SECOND, stamp / SECOND)
    writer.close()
    return RecordingSet.open([path])


@pytest.mark.parametrize(
    ("outliers", "said"),
    [
        ([0, 0, 0], "3 messages at 1970"),
        ([7 * SECOND], "1 message at 1970"),
        ([2**63 - 1], "1 message at 2262"),
        ([NOW + 900 * 24 * HOUR], "1 message at 2029"),
        ([0, NOW - 9 * HOUR, 2**62], "1 message at 1970"),
    ],
)
@pytest.mark.parametrize("chunk_bytes", [100, 10**6])
def test_outliers_at_the_ends_are_left_out(
    tmp_path: Path, outliers: list[int], said: str, chunk_bytes: int
) -> None:
    stamps = [*outliers[:1], *USUAL, *outliers[1:]]
    with recorded(tmp_path / "a.mcap", stamps, chunk_bytes=chunk_bytes) as recording:
        recording.drop_outliers()
        times = [each.stamp for each in recording.messages()]
        assert len(times) == len(USUAL)
        assert recording.start // SECOND == NOW // SECOND
        assert recording.end - recording.start < 11 * SECOND
        assert recording.holes == ()
        assert len(recording.faults) == len(set(outliers))
        assert recording.faults[0].startswith(said)
        assert recording.faults[0].endswith("are far from all others, and left out")
        newest = recording.newest(recording.start - 1)
        assert bool(newest) == (min(outliers) < NOW), "what was said once holds on"


def test_a_recording_of_a_simulation_stays_in_1970(tmp_path: Path) -> None:
    with recorded(tmp_path / "a.mcap", [each - NOW for each in USUAL]) as recording:
        recording.drop_outliers()
        assert (recording.start, recording.holes, recording.faults) == (0, (), [])


def test_two_drives_stay_and_the_hole_between_them_is_named(tmp_path: Path) -> None:
    second = [each + 50 * HOUR for each in USUAL]
    with recorded(tmp_path / "a.mcap", [*USUAL, *second]) as recording:
        recording.drop_outliers()
        assert sum(1 for _ in recording.messages()) == 400
        ((begin, end),) = recording.holes
        assert end - begin == pytest.approx(50 * HOUR - 9.95 * SECOND, abs=SECOND)
        (said,) = said_of_holes(recording.holes)
        assert said.startswith("no message from 2026-09-2")
        assert recording.faults == [], "nothing of the file is damaged or left out"


def test_databases_have_negative_stamps_too(tmp_path: Path) -> None:
    path = tmp_path / "a.db3"
    with sqlite3.connect(path) as database:
        database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
            "data BLOB);"
            "CREATE INDEX timestamp_idx ON messages(timestamp);"
            "INSERT INTO topics VALUES (1, '/t', 'std_msgs/msg/Bool', 'cdr');"
        )
        rows = [(stamp, b"\0\1\0\0\1") for stamp in (-(2**62), *USUAL)]
        database.executemany(
            "INSERT INTO messages(topic_id, timestamp, data) VALUES (1, ?, ?)", rows
        )
    database.close()
    with RecordingSet.open([path]) as recording:
        recording.drop_outliers()
        assert recording.end - recording.start < 11 * SECOND
        (fault,) = recording.faults
        assert fault.startswith("1 message before 1970"), fault
