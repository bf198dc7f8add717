"""Small files that say that they are endless: each gets a sentence, and costs little."""

from __future__ import annotations

import sqlite3
import struct
from pathlib import Path

import pytest
import zstandard

from hub.errors import RecordingError
from hub.recording import records as rc
from hub.recording.recording_set import RecordingSet
from tests.support.command_line import rune_hub

NOW = 1_790_000_000 * 10**9
PART = 64_000_000


def record(kind: int, content: bytes) -> bytes:
    return rc.RECORD.pack(kind, len(content)) + content


def text(words: str | bytes) -> bytes:
    raw = words.encode() if isinstance(words, str) else words
    return struct.pack("<I", len(raw)) + raw


def message(number: int, payload: bytes = b"") -> bytes:
    return record(rc.MESSAGE, struct.pack("<HIQQ", 1, number, NOW + number, NOW) + payload)


def chunk(packed: bytes, size: int, coding: str = "zstd") -> bytes:
    times = struct.pack("<QQQI", NOW, NOW + 10**9, size, 0)
    return record(rc.CHUNK, times + text(coding) + struct.pack("<Q", len(packed)) + packed)


HEAD = (
    rc.MAGIC
    + record(rc.HEADER, text("ros2") + text("x"))
    + record(
        rc.SCHEMA,
        struct.pack("<H", 1) + text("a/msg/B") + text("ros2msg") + text("string data"),
    )
    + record(rc.CHANNEL, struct.pack("<HH", 1, 1) + text("/a") + text("cdr") + struct.pack("<I", 0))
)
END = record(rc.DATA_END, bytes(4)) + record(rc.FOOTER, bytes(20)) + rc.MAGIC


def packed(content: bytes) -> bytes:
    return zstandard.ZstdCompressor().compress(content)


def zeros(count: int) -> bytes:
    """The message `message(0)`, and behind it one with this many zeros, packed."""
    head = struct.pack("<BQHIQQ", rc.MESSAGE, 22 + count, 1, 1, NOW + 1, NOW)
    compressor = zstandard.ZstdCompressor().compressobj()
    found = compressor.compress(message(0) + head)
    for _ in range(count >> 20):
        found += compressor.compress(bytes(1 << 20))
    return found + compressor.flush()


def read(path: Path, unpacked: int = 0) -> tuple[int, list[str]]:
    """The number of messages that are read, and the faults."""
    with RecordingSet.open([path], unpacked=unpacked) as recording:
        return sum(1 for _ in recording.messages()), recording.faults


def test_a_part_that_unpacks_to_too_much_is_left_out(tmp_path: Path) -> None:
    path, size = tmp_path / "a.mcap", 62 + (80 << 20)
    path.write_bytes(HEAD + chunk(zeros(80 << 20), size) * 3 + chunk(packed(message(7)), 31) + END)
    count, faults = read(path)
    sentence = f"a part of it unpacks to {size} bytes, more than {PART}, and is left out"
    assert (count, faults) == (
        1,
        [f"{sentence}; if you trust the file, read more of it with --unpack 10GB"],
    )
    assert read(path, 10**9) == (7, [])
    done = rune_hub("log", "info", str(path))
    assert (done.returncode, sentence in done.stdout) == (1, True)


def test_a_part_that_says_a_smaller_size_than_it_has_is_damaged(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(HEAD + chunk(zeros(80 << 20), 1000) + chunk(packed(message(7)), 31) + END)
    count, (fault,) = read(path)
    assert (count, "the checksum of a part of it is wrong" in fault) == (1, True)


def test_all_parts_together_have_a_limit(tmp_path: Path) -> None:
    path, size = tmp_path / "a.mcap", 62 + (8 << 20)
    path.write_bytes(HEAD + chunk(zeros(8 << 20), size) * 5 + END)
    count, (fault,) = read(path, 3 * size)
    assert count == 6
    assert fault.startswith(f"it unpacks to more than {3 * size} bytes, and the rest is left out")
    with RecordingSet.open([path], unpacked=5 * size) as recording:
        for _ in range(3):  # a part counts once
            assert sum(1 for _ in recording.messages()) == 10
        assert recording.faults == []


def test_parts_of_countless_records_are_left_out(tmp_path: Path) -> None:
    path, unpacked = tmp_path / "a.mcap", 3_200_000
    private = rc.RECORD.pack(0x80, 0)
    for many in (message(0) * 100_001, message(0) + private * 100_000):
        path.write_bytes(HEAD + chunk(packed(many), len(many)) + END)
        count, (fault,) = read(path, unpacked)
        assert (count, "more than 100000 records" in fault) == (0, True)
    some = message(0) + private * 60_000
    path.write_bytes(HEAD + chunk(packed(some), len(some)) * 2 + END)
    count, (fault,) = read(path, unpacked)
    assert (count, "more records than its size explains" in fault) == (1, True)


def test_an_index_cannot_name_one_part_many_times(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    part = chunk(packed(message(0)), 31)
    place = struct.pack("<QQQQI", NOW, NOW, len(HEAD), len(part), 0) + struct.pack("<Q", 0)
    index = record(rc.CHUNK_INDEX, place + text("zstd") + struct.pack("<QQ", len(part), 31))
    facts = HEAD[len(rc.MAGIC) + len(record(rc.HEADER, text("ros2") + text("x"))) :]
    begin = len(HEAD) + len(part) + 13
    footer = record(rc.FOOTER, struct.pack("<QQI", begin, 0, 0))
    data_end = record(rc.DATA_END, bytes(4))
    path.write_bytes(HEAD + part + data_end + facts + index * 1000 + footer + rc.MAGIC)
    assert read(path) == (1, [])


def test_a_packed_file_does_not_fill_the_disk(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap.zstd"
    path.write_bytes(packed(HEAD + message(0, bytes(4 << 20)) + END))
    assert read(path) == (1, [])
    with pytest.raises(RecordingError, match="unpacks to more than 2000000 bytes; if you trust"):
        read(path, 2_000_000)


def test_packed_files_of_a_folder_have_a_limit_together(tmp_path: Path) -> None:
    for name in ("a.mcap.zstd", "b.mcap.zstd"):
        (tmp_path / name).write_bytes(packed(HEAD + message(0, bytes(4 << 20)) + END))
    assert read(tmp_path, 9 << 20) == (2, [])
    count, (fault,) = read(tmp_path, 7 << 20)
    assert (count, f"b.mcap.zstd unpacks to more than {7 << 20} bytes" in fault) == (1, True)


def test_packed_messages_count_as_long_as_they_are(tmp_path: Path) -> None:
    path, one = tmp_path / "a.mcap", 4 << 20

    def whole(stamps: list[int], unpacked: int) -> tuple[int, list[str]]:
        found = packed(bytes(one))
        path.write_bytes(HEAD + b"".join(message(each, found) for each in stamps) + END)
        with RecordingSet.open([path], unpacked=unpacked) as recording:
            for _ in range(3):  # each reading may unpack as much
                count = sum(len(each.payload) == one for each in recording.messages())
            return count, recording.faults

    assert whole([*range(20)], 0) == (20, [])
    count, (fault,) = whole([7] * 20, 3 * one)  # one stamp for all
    assert (count, f"unpacks to more than {3 * one} bytes" in fault) == (3, True)


def test_a_packed_message_counts(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(HEAD + message(0, packed(bytes(4 << 20))) + END)
    with RecordingSet.open([path]) as recording:
        assert [len(each.payload) for each in recording.messages()] == [4 << 20]
    count, (fault,) = read(path, 2_000_000)
    assert (count, "unpacks to more than 2000000 bytes" in fault) == (1, True)


def test_a_database_that_computes_its_messages_is_no_bag(tmp_path: Path) -> None:
    path = tmp_path / "a.db3"
    with sqlite3.connect(path) as database:
        database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
            "data BLOB GENERATED ALWAYS AS (zeroblob(400000000)));"
            "INSERT INTO messages(topic_id, timestamp) VALUES (1, 1);"
        )
    database.close()
    with pytest.raises(RecordingError, match="its table 'messages' computes values"):
        read(path)


def test_false_chunks_behind_damage_are_not_all_read(tmp_path: Path) -> None:
    path, size = tmp_path / "a.mcap", 2 << 20
    fake = chunk(b"", 1 << 20)[:-8] + struct.pack("<Q", size)
    fake = rc.RECORD.pack(rc.CHUNK, 40 + 4 + size) + fake[rc.RECORD.size :]
    path.write_bytes(HEAD + b"\0" + fake * 20_000 + bytes(size))
    count, faults = read(path)
    assert (count, len(faults)) == (0, 1)
    assert "bytes cannot be read" in faults[0]
