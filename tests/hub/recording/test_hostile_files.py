"""Files that are damaged, or made to do harm, cost a sentence, and little memory and time."""

from __future__ import annotations

import resource
import struct
import subprocess
import sys
import textwrap
import time
import zlib
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.errors import RecordingError
from hub.recording.new_recording import NewRecording
from hub.recording.reader import Recording
from hub.recording.records import (
    ATTACHMENT,
    CHANNEL,
    CHUNK,
    HEADER,
    MAGIC,
    MESSAGE,
    METADATA,
    RECORD,
    SCHEMA,
)
from hub.recording.topics import RecordedTopic

MOST_MEMORY = 700 * 1024 * 1024
"""Address space that reading a hostile file may take besides what Python has [bytes]."""


def record(kind: int, content: bytes) -> bytes:
    return RECORD.pack(kind, len(content)) + content


def message(channel: int, stamp: int, payload: bytes = b"x") -> bytes:
    return record(MESSAGE, struct.pack("<HIQQ", channel, 1, stamp, stamp) + payload)


def chunk(
    records: bytes, start: int, end: int, name: str = "", packed: bytes = b"", size: int = -1
) -> bytes:
    packed = packed or records
    size = len(records) if size < 0 else size
    head = struct.pack("<QQQI", start, end, size, 0) + struct.pack("<I", len(name)) + name.encode()
    return record(CHUNK, head + struct.pack("<Q", len(packed)) + packed)


BEGIN = MAGIC + record(HEADER, bytes(8))
TOPIC = record(CHANNEL, struct.pack("<HHI", 1, 0, 2) + b"/t" + bytes(8))


def read_all(path: Path) -> tuple[int, list[str]]:
    """All that a reader asks; number of messages and faults."""
    with Recording.open(path) as recording:
        messages = list(recording.messages())
        stamps = [each.stamp for each in messages]
        assert stamps == sorted(stamps)
        assert all(each.channel in recording.channels for each in messages)
        assert len(list(recording.messages(reverse=True))) == len(messages)
        newest = recording.newest(recording.end)
        assert all(each.stamp <= recording.end for each in newest.values())
        assert sum(len(each.stamps) for each in recording.facts()) == len(messages)
        assert len(list(recording.salvage())) >= len(messages)
        for place in recording.attachments:
            try:
                recording.attachment(place)
            except RecordingError:
                continue
        return len(messages), recording.faults


def good(path: Path, *, compression: str = "lz4") -> bytes:
    with NewRecording(path, compression=compression, replace=True) as new:
        new.add_facts("rune", {"wall_ns": "1", "monotonic": "2"})
        new.attach("a.xml", "text/xml", b"<a/>")
        for number in range(60):
            topic = RecordedTopic(f"/r/T{number % 3}", "a/msg/B", "ros2msg", b"int8 x\n")
            new.add(topic, number, number, number, bytes(number))
            if number % 20 == 19:
                new.add_facts("other", {"n": str(number)})  # ends the chunk
    return path.read_bytes()


@settings(deadline=None, max_examples=300)
@given(data=st.data())
def test_any_damage_is_a_sentence(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged.mcap"
    compression = data.draw(st.sampled_from(["lz4", "zstd", "none"]))
    raw = bytearray(good(path, compression=compression))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(raw) - 1))
        match data.draw(st.sampled_from(["flip", "cut", "insert", "number", "remove"])):
            case "flip":
                raw[at] ^= 1 << data.draw(st.integers(0, 7))
            case "cut":
                del raw[max(9, at) :]
            case "insert":
                raw[at:at] = data.draw(st.binary(max_size=40))
            case "number":
                raw[at : at + 8] = struct.pack("<Q", data.draw(st.integers(0, 2**64 - 1)))
            case _:
                del raw[at : at + data.draw(st.integers(1, 100))]
        raw = raw or bytearray(b"x")
    path.write_bytes(raw)
    if raw.startswith(MAGIC):
        count, _ = read_all(path)
        assert count <= 60
    else:
        with pytest.raises(RecordingError, match="it is no MCAP file"):
            read_all(path)


def test_each_flipped_bit_of_a_chunk_costs_that_chunk_at_most(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    whole = good(path)
    begin = whole.index(b"lz4")
    for at in range(begin, begin + 400, 7):
        raw = bytearray(whole)
        raw[at] ^= 0x10
        path.write_bytes(raw)
        count, faults = read_all(path)
        assert count >= 40
        assert count == 60 or faults


def test_a_scan_goes_on_behind_damage(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    raw = bytearray(good(path)[:-60])  # without an end
    second = raw.index(b"lz4", raw.index(b"lz4") + 1)
    at = second - 4 - 28 - 8  # the length of the second chunk's record
    raw[at : at + 8] = struct.pack("<Q", 2**62)
    path.write_bytes(raw)
    count, faults = read_all(path)
    assert count == 40
    assert "bytes cannot be read" in faults[0]


def packed_zeros(size: int, name: str) -> bytes:
    """Zeros that are packed into almost nothing."""
    if name == "lz4":
        pack = lz4.frame.LZ4FrameCompressor()
        parts = [pack.begin()]
        parts += [pack.compress(bytes(1 << 20)) for _ in range(size >> 20)]
        return b"".join(parts) + pack.flush()
    compressor = zstandard.ZstdCompressor(level=1).compressobj()
    parts = [compressor.compress(bytes(1 << 20)) for _ in range(size >> 20)]
    return b"".join(parts) + compressor.flush()


def hostile_files(folder: Path) -> dict[str, Path]:
    sized = struct.pack("<I", 0xFFFFFFF0)
    pieces = {
        "message of 10 GB": TOPIC + RECORD.pack(MESSAGE, 10**10) + bytes(30),
        "chunk of 10 GB": RECORD.pack(CHUNK, 10**10) + bytes(100),
        "chunk that says 10 GB": chunk(message(1, 5), 5, 5, "lz4", b"x" * 50, 10**10),
        "chunk that says 200 MB": chunk(
            b"", 5, 5, "zstd", packed_zeros(1 << 20, "zstd"), 200 << 20
        ),
        "unknown packing": chunk(message(1, 5), 5, 5, "magic", b"x"),
        "name of 4 GB": record(METADATA, sized + b"x"),
        "map of 4 GB": record(METADATA, struct.pack("<I", 1) + b"a" + sized),
        "schema of 4 GB": record(SCHEMA, struct.pack("<H", 1) + sized),
        "attachment of 10 GB": record(ATTACHMENT, bytes(24) + struct.pack("<Q", 10**10)),
        "records of nothing": bytes(1 << 20),
        "endless chunks": chunk(b"", 0, 0) * 20_000,
        "stamps of the end of time": TOPIC + message(1, 2**64 - 1) + message(1, 0),
        "message without a topic": message(7, 5),
    }
    bombs = {
        name: chunk(b"", 5, 5, name, packed_zeros(300 << 20, name), 1 << 20)
        for name in ("lz4", "zstd")
    }
    found = {}
    for name, piece in {**pieces, **bombs}.items():
        found[name] = folder / f"{name}.mcap"
        found[name].write_bytes(BEGIN + piece)
    sparse = folder / "sparse.mcap"
    sparse.write_bytes(BEGIN + TOPIC + RECORD.pack(MESSAGE, 10**10))
    with sparse.open("r+b") as file:
        file.truncate(10**10 + 1000)
    found["a message of 10 GB that is there"] = sparse
    return found


def test_what_announces_much_takes_little(tmp_path: Path) -> None:
    program = textwrap.dedent("""
        import resource, sys
        from pathlib import Path
        from tests.hub.recording.test_hostile_files import MOST_MEMORY, read_all
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + MOST_MEMORY,) * 2)
        for path in sys.argv[1:]:
            count, faults = read_all(Path(path))
            print(count, len(faults), Path(path).stem, faults[:1])
    """)
    paths = [str(path) for path in hostile_files(tmp_path).values()]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-c", program, *paths],
        capture_output=True, text=True, timeout=50, check=False, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == len(paths)
    silent = {"endless chunks", "stamps of the end of time"}
    for line in lines:
        count, faults, name = line.split(" ", 2)
        assert int(faults) > 0 or name.partition(" [")[0] in silent, line
        assert int(count) == (2 if "end of time" in name else 0), line
    assert after.ru_utime - before.ru_utime < 20.0


def test_ten_thousand_topics(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with NewRecording(path) as new:
        for stamp in range(3):
            for number in range(10_000):
                new.add(RecordedTopic(f"/t{number}"), stamp * 10**6 + number, 0, 1, b"x" * 20)
    before = time.process_time()
    with Recording.open(path) as recording:
        newest = recording.newest(10**6 + 5000)
        assert len(newest) == 10_000
        assert newest[5001].stamp == 10**6 + 5000
        assert newest[5002].stamp == 5001
        assert sum(1 for _ in recording.messages()) == 30_000
    assert time.process_time() - before < 15.0


def test_too_many_topics_are_refused_in_a_sentence(tmp_path: Path) -> None:
    with NewRecording(tmp_path / "x.mcap") as new:
        for number in range(65_535):
            new.add(RecordedTopic(f"/t{number}"), 0, 0, 1, b"")
        with pytest.raises(RecordingError, match="at most 65535 topics"):
            new.add(RecordedTopic("/another"), 0, 0, 1, b"")


def test_an_index_that_points_elsewhere_is_not_believed(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    whole = good(path)
    names = bytearray(whole)
    tail = struct.unpack_from("<Q", whole, len(whole) - 28)[0]
    for at in range(tail, len(whole) - 60, 3):
        raw = bytearray(names)
        raw[at] ^= 0x01
        begin, end = len(raw) - 37, len(raw) - 12
        checksum = zlib.crc32(raw[tail:begin] + raw[begin:end])
        raw[end : end + 4] = struct.pack("<I", checksum)  # so that the index looks right
        path.write_bytes(raw)
        count, faults = read_all(path)
        assert count == 60 or faults or count in (20, 40), at


def test_parts_that_overlap_come_in_order(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    chunks = [
        chunk(b"".join(message(1, stamp) for stamp in stamps), min(stamps), max(stamps))
        for stamps in ([9, 1], [5, 5, 2], [100, 3], [0, 200])
    ]
    path.write_bytes(BEGIN + TOPIC + b"".join(chunks))
    with Recording.open(path) as recording:
        stamps = [each.stamp for each in recording.messages()]
        assert stamps == [0, 1, 2, 3, 5, 5, 9, 100, 200]
        assert recording.newest(8)[1].stamp == 5
        assert recording.newest(2**64)[1].stamp == 200
        assert recording.newest(-1) == {}


def test_stamps_near_to_each_other_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    begin = 1_790_000_000_000_000_000
    with NewRecording(path) as new:
        for number in range(10):
            new.add(RecordedTopic("/t"), begin + number, 0, number, b"x")
            new.add_facts("part", {})  # ends the chunk
    with Recording.open(path) as recording:
        for number in range(10):
            assert recording.newest(begin + number)[1].number == number


def test_a_chunk_whose_times_are_wrong_is_saved_by_recovery(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(BEGIN + TOPIC + chunk(message(1, 5) + message(1, 50), 5, 10))
    with Recording.open(path) as recording:
        assert [each.stamp for each in recording.messages()] == [5]
        assert "1 messages are of other times than the file says" in recording.faults[0]
        assert [each.stamp for each in recording.salvage()] == [5, 50]
