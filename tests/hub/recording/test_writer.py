"""What a crash, a full or slow disk, and a date that is set cost a recording."""

from __future__ import annotations

import errno
import io
import itertools
import random
import shutil
import signal
import struct
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

import pytest

from hub.recording.anchor import TimeAnchor
from hub.recording.reader import Recording
from hub.recording.topics import RecordedTopic
from hub.recording.writer import RecordingWriter, WriterLimits
from tests.support.full_disk import files_no_longer_than
from tests.support.repetitions import repetitions
from tests.support.waiting import until

ROOT = Path(__file__).parents[3]
ANCHOR = TimeAnchor(1_700_000_000_000_000_000, 50.0)
LIMITS = WriterLimits(least_free=0)
TOPIC = RecordedTopic("/rover/T")
KILLED = textwrap.dedent("""
    import os, struct, sys, time
    from pathlib import Path
    from hub.recording.anchor import TimeAnchor
    from hub.recording.topics import RecordedTopic
    from hub.recording.writer import RecordingWriter, WriterLimits
    writer = RecordingWriter(Path(sys.argv[1]), TimeAnchor.now(), {}, WriterLimits(least_free=0))
    number = 0
    while True:
        number += 1
        now = time.monotonic()
        writer.add(RecordedTopic("/rover/T"), number.to_bytes(300, "little"), now, now, number)
        os.write(1, struct.pack("<Qd", number, now))
        time.sleep(0.002)
""")


def read(path: Path) -> list[int]:
    """The numbers of the messages in a file."""
    with Recording.open(path) as recording:
        assert recording.finished
        return [each.number for each in recording.messages()]


@pytest.mark.parametrize("seed", range(repetitions(2, 20)))
def test_a_killed_writer_loses_half_a_second(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "x.mcap"
    child = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE, cwd=ROOT, bufsize=0
    )
    assert child.stdout is not None
    raw = bytearray()
    wanted = random.Random(seed).randrange(200, 1200)
    while len(raw) < 16 * wanted:
        raw += child.stdout.read(65536)
    child.send_signal(signal.SIGKILL)
    child.wait()
    raw += child.stdout.read()
    child.stdout.close()
    said = list(struct.iter_unpack("<Qd", raw[: len(raw) // 16 * 16]))
    with Recording.open(path) as recording:
        kept = [each.number for each in recording.messages()]
    assert kept == list(range(1, len(kept) + 1))
    moments = [moment for _, moment in said]
    busy = max(b - a for a, b in itertools.pairwise(moments))  # of a busy machine
    assert moments[-1] - moments[len(kept) - 1] <= 0.5 + 4 * busy


def test_a_full_disk_ends_the_recording_and_is_counted(tmp_path: Path) -> None:
    program = textwrap.dedent("""
        import random, sys
        from pathlib import Path
        from hub.recording.anchor import TimeAnchor
        from hub.recording.reader import Recording
        from hub.recording.topics import RecordedTopic
        from hub.recording.writer import RecordingWriter, WriterLimits
        path, chance = Path(sys.argv[1]) / "x.mcap", random.Random(1)
        limits = WriterLimits(least_free=0, chunk_bytes=20_000)
        writer = RecordingWriter(path, TimeAnchor(10**18, 0.0), {}, limits)
        for number in range(1, 4001):
            writer.add(RecordedTopic("/t"), chance.randbytes(1000), number / 100, 0.0, number)
        writer.close()
        state = writer.state
        with Recording.open(path) as recording:
            kept = [each.number for each in recording.messages()]
            assert recording.faults == [], recording.faults
        assert kept == list(range(1, len(kept) + 1))
        assert 900 < len(kept) < 2000, len(kept)
        assert state.messages == len(kept), (state.messages, len(kept))
        assert state.messages + state.lost["/t"] == 4000
        assert state.bytes == path.stat().st_size
        print(state.fault, "|", recording.finished)
    """)
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = f'mount -t tmpfs -o size=1500k none {disk} && exec {sys.executable} -c "$0" {disk}'
    unshare = shutil.which("unshare")
    if unshare is None:
        pytest.skip("unshare is missing")
    allowed = subprocess.run(
        [unshare, "-rm", "mount", "-t", "tmpfs", "none", str(disk)],
        capture_output=True,
        check=False,
    )
    if allowed.returncode:
        pytest.skip("this user may not mount a small disk")
    done = subprocess.run(
        [unshare, "-rm", "sh", "-c", mount, program],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "x.mcap cannot be written: No space left on device | True" in done.stdout


def test_a_file_that_may_not_grow_keeps_its_complete_parts(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    chance = random.Random(1)
    with files_no_longer_than(100_000):
        writer = RecordingWriter(path, ANCHOR, {}, WriterLimits(least_free=0, chunk_bytes=10_000))
        for number in range(1, 201):
            writer.add(TOPIC, chance.randbytes(1000), 50 + number / 100, 50.0, number)
        writer.close()
    state = writer.state
    with Recording.open(path) as recording:
        kept = [each.number for each in recording.messages()]
        assert recording.faults == []
    assert kept == list(range(1, len(kept) + 1))
    assert len(kept) > 50
    assert (state.messages, state.lost) == (len(kept), {"/rover/T": 200 - len(kept)})
    assert "x.mcap cannot be written: File too large" in state.fault


def test_a_disk_with_too_little_room_ends_the_recording_with_an_index(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    writer = RecordingWriter(path, ANCHOR, {}, WriterLimits(least_free=1 << 60, chunk_s=0.1))
    writer.add(TOPIC, b"x", 50.0, 50.0, 1)
    until(lambda: writer.state.fault, 10.0)
    writer.add(TOPIC, b"x", 51.0, 51.0, 2)
    writer.close()
    assert "MB are free on the disk of" in writer.state.fault
    assert read(path) == [1]
    assert writer.state.lost == {"/rover/T": 1}


def test_a_deleted_file_ends_the_recording_and_costs_all_of_it(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    writer = RecordingWriter(path, ANCHOR, {}, WriterLimits(least_free=0, chunk_s=0.1))
    writer.add(TOPIC, b"x", 50.0, 50.0, 1)
    until(lambda: writer.state.messages == 1, 10.0)
    path.unlink()
    writer.add(TOPIC, b"x", 51.0, 51.0, 2)
    until(lambda: writer.state.fault, 10.0)
    writer.close()
    assert writer.state.fault == f"{path} was deleted"
    assert (writer.state.messages, writer.state.lost) == (0, {TOPIC.name: 2})
    assert not path.exists()


class SlowFile(io.FileIO):
    """A file on a disk that does not answer until it is let go."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "xb")
        self.answers = threading.Event()
        self.writes = 0
        self.refused = 0
        """Number of the write that this disk refuses, and all after it; 0: none."""
        self.refuses = threading.Event()

    def write(self, data: Any) -> int:
        self.writes += 1
        if self.writes > 1:  # the first is that of the metadata
            self.answers.wait()
        if 0 < self.refused <= self.writes:
            self.refuses.wait()
            raise OSError(errno.EIO, "Input/output error")
        return super().write(data)


class SlowPath(type(Path())):  # type: ignore[misc]
    """The path of such a file."""

    def open(self, *_: Any, **__: Any) -> SlowFile:
        self.__class__.opened = SlowFile(Path(self))
        return self.__class__.opened


def test_a_slow_disk_costs_messages_by_topic_and_no_time(tmp_path: Path) -> None:
    limits = WriterLimits(least_free=0, chunk_bytes=1000, waiting_bytes=100_000)
    writer = RecordingWriter(SlowPath(tmp_path / "x.mcap"), ANCHOR, {}, limits)
    file: SlowFile = SlowPath.opened
    pictures = RecordedTopic("/rover/Pictures")
    before = time.thread_time()
    for number in range(1, 201):
        writer.add(TOPIC, bytes(100), 50 + number / 10, 50.0, number)
        writer.add(pictures, [bytes(1000), memoryview(bytes(1000))], 50 + number / 10, 50.0, number)
    assert time.thread_time() - before < 1.0
    until(lambda: file.writes > 1, 10.0)
    lost = writer.state.lost
    assert lost[pictures.name] > 100
    assert sum(lost.values()) > 100
    writer.close(patience=0.05)  # the disk does not answer, and closing ends all the same
    writer.add(TOPIC, bytes(100), 90.0, 90.0, 201)
    file.answers.set()
    until(lambda: file.closed, 10.0)
    lost = writer.state.lost
    with Recording.open(tmp_path / "x.mcap") as recording:
        kept = [recording.channels[each.channel].name for each in recording.messages()]
        assert recording.finished
    assert kept.count(TOPIC.name) + lost[TOPIC.name] in (200, 201)
    assert kept.count(pictures.name) + lost[pictures.name] == 200


def test_a_recording_keeps_nothing_that_its_disk_refuses_later(tmp_path: Path) -> None:
    for closed in (False, True):  # while it is asked
        path = SlowPath(tmp_path / f"{closed}.mcap")
        writer = RecordingWriter(path, ANCHOR, {}, WriterLimits(least_free=0, chunk_bytes=1000))
        file: SlowFile = SlowPath.opened
        # The first ends a part of the file, which the disk holds up; the second waits for its own.
        writer.add_all([(TOPIC, bytes(size), 50.0, 50.0, 1, size) for size in (2000, 10)])
        until(lambda file=file: file.writes > 1, 10.0)
        file.refused = 3
        with ThreadPoolExecutor() as others:
            kept = others.submit(writer.keeps, 10.0)
            if closed:
                until(kept.running, 10.0)
                writer.close(patience=0.05)
            file.answers.set()
            until(lambda file=file: file.writes > 2, 10.0)
            wait([kept], 0.1)  # an answer before the disk's would be wrong
            file.refuses.set()
            assert not kept.result()
        writer.close()


def test_a_date_that_is_set_moves_no_stamp(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "x.mcap"
    writer = RecordingWriter(path, TimeAnchor.now(), {}, LIMITS)
    begun = time.monotonic()
    for number in range(1, 101):
        if number == 50:
            monkeypatch.setattr(time, "time", lambda: 0.0)
            monkeypatch.setattr(time, "time_ns", lambda: 0)
        writer.add(TOPIC, b"x", begun + number, begun + number, number)
    writer.close()
    with Recording.open(path) as recording:
        messages = list(recording.messages())
    assert [each.number for each in messages] == list(range(1, 101))
    steps = [b.stamp - a.stamp for a, b in itertools.pairwise(messages)]
    assert all(abs(step - 1_000_000_000) < 1000 for step in steps)


def test_what_comes_while_a_recording_ends_is_written_or_counted(tmp_path: Path) -> None:
    for attempt in range(repetitions(10, 200)):
        path = tmp_path / f"{attempt}.mcap"
        writer = RecordingWriter(path, ANCHOR, {}, LIMITS)
        begin = threading.Barrier(4)

        def add(first: int, writer=writer, begin=begin) -> None:
            begin.wait()
            for number in range(first, first + 300):
                writer.add(TOPIC, b"x", 50 + number / 1000, 50.0, number)

        threads = [threading.Thread(target=add, args=(1 + 300 * n,)) for n in range(3)]
        for thread in threads:
            thread.start()
        begin.wait()
        writer.close()
        for thread in threads:
            thread.join()
        kept, state = read(path), writer.state
        assert len(kept) == state.messages
        assert len(kept) + state.lost.get(TOPIC.name, 0) == 900


def test_what_cannot_be_written_is_counted_and_costs_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    writer = RecordingWriter(path, ANCHOR, {}, LIMITS)
    wrong: list[tuple[Any, float]] = [
        (b"x", float("nan")),
        (b"x", float("inf")),
        (["text"], 50.0),
        (["a", b"b"], 50.0),
    ]
    for payload, moment in wrong:
        writer.add(TOPIC, b"before", 51.0, 51.0, 1)
        writer.add(RecordedTopic("/wrong"), payload, moment, 50.0, 1)
    writer.add(TOPIC, memoryview(b"12345678").cast("d"), 1e12, -1e12, 2**40 + 7)
    writer.close()
    assert writer.state.lost == {"/wrong": 4}
    with Recording.open(path) as recording:
        *before, last = recording.messages()
    assert [each.payload for each in before] == [b"before"] * 4
    assert (last.payload, last.number, last.published) == (b"12345678", 7, 0)
    assert last.stamp == 2**63 - 1
