"""What becomes of modules' output: lines fit to be read, and files that survive trouble."""

from __future__ import annotations

import errno
import os
import shutil
import stat
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.supervision import LOG_LINES, LogLines
from hub.robomon import log_file
from hub.robomon import module_logs as robomon_outputs
from hub.robomon.log_file import FILES, RETRY_S, LogFile
from hub.robomon.module_logs import LINE_BYTES, REMEMBERED_LINES, ModuleLogs, readable
from tests.support.waiting import until


@pytest.fixture
def file(tmp_path: Path) -> Iterator[LogFile]:
    with closing(LogFile(tmp_path / "robot" / "one.log")) as made:
        yield made


def path_of(folder: Path) -> Path:
    return folder / "robot" / "one.log"


def test_deleted_file_and_lost_folder_are_made_anew(file: LogFile, tmp_path: Path) -> None:
    path = path_of(tmp_path)
    file.write("a\n", 0.0)
    path.unlink()
    file.write("b\n", 0.0)
    assert path.read_text() == "b\n"
    shutil.rmtree(path.parent)
    file.write("c\n", 0.0)
    assert path.read_text() == "c\n"


def test_file_that_cannot_be_written_is_said_once_and_tried_again(
    file: LogFile, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = path_of(tmp_path)
    path.parent.write_text("no folder")
    for now in (0.0, 0.1, RETRY_S + 0.1, 2.0 * RETRY_S + 0.2):
        file.write("lost\n", now)
    assert caplog.text.count("cannot be written") == 1
    path.parent.unlink()
    file.write("lost as well\n", 2.0 * RETRY_S + 0.3)
    file.write("kept\n", 4.0 * RETRY_S)
    assert path.read_text() == "(5 lines were lost here: File exists)\nkept\n"
    assert file.lost == 5


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux only")
def test_full_disk_is_no_fault(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "full.log").symlink_to("/dev/full")
    with closing(LogFile(tmp_path / "full.log")) as file:
        file.write("lost\n", 0.0)
    assert "No space left on device" in caplog.text


class Disk:
    """A disk with so much room for os.write, real files on it [bytes]."""

    def __init__(self, room: int) -> None:
        self.room = room
        self._write = os.write

    def write(self, file: int, data: bytes) -> int:
        if not stat.S_ISREG(os.fstat(file).st_mode):
            return self._write(file, data)
        if not self.room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = self._write(file, data[: self.room])
        self.room -= written
        return written


@pytest.mark.parametrize("room", range(24, 40))
def test_full_disk_leaves_whole_lines_and_says_how_many_are_missing(
    file: LogFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, room: int
) -> None:
    disk = Disk(room)
    monkeypatch.setattr(os, "write", disk.write)
    for number in range(10):
        file.write(f"line {number}\n", number * RETRY_S)
    kept = room // len("line 0\n")
    whole = "".join(f"line {number}\n" for number in range(kept))
    assert path_of(tmp_path).read_text() == whole
    assert file.lost == 10 - kept
    disk.room = 1 << 20
    file.write("line 10\n", 100.0)
    file.write("line 11\n", 100.0)
    said = f"({10 - kept} lines were lost here: No space left on device)\n"
    assert path_of(tmp_path).read_text() == f"{whole}{said}line 10\nline 11\n"


def test_lost_lines_are_told_of_with_the_module_and_in_its_file_without_another_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = Disk(2)
    monkeypatch.setattr(os, "write", disk.write)
    with closing(ModuleLogs(tmp_path)) as outputs:
        source, pipe = os.pipe()
        outputs.add("one", source)
        with os.fdopen(pipe, "wb", buffering=0) as file:
            file.write(b"0\n1\n2\n")
            said = "has lost 2 lines of its log: No space left on device"
            until(lambda: outputs.fault("one") == said, 5.0)
            disk.room = 1 << 20
            log = tmp_path / "one.log"
            told = "(2 lines were lost here: No space left on device)\n"
            until(lambda: log.read_text() == f"0\n{told}", 10.0)
            assert outputs.fault("one") == said
            assert outputs.fault("another") == ""


def test_pipe_that_nobody_reads_in_the_place_of_a_file_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.log")
    with closing(LogFile(tmp_path / "pipe.log")) as file:
        file.write("lost\n", 0.0)


def test_files_rotate(file: LogFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_file, "FILE_BYTES", 10)
    for number in range(20):
        file.write(f"{number:04}\n", 0.0)
    path = path_of(tmp_path)
    assert len(list(path.parent.iterdir())) == 1 + FILES
    assert path.read_text() == "0018\n0019\n"
    assert Path(f"{path}.{FILES}").read_text() == "0012\n0013\n"
    with closing(LogFile(path)) as other:
        other.write("0020\n", 0.0)
    assert path.read_text() == "0020\n"


def spoken(said: bytes) -> list[str]:
    outputs = ModuleLogs(None)
    source, pipe = os.pipe()
    outputs.add("one", source)
    with os.fdopen(pipe, "wb") as file:
        file.write(said)
    until(lambda: not said or outputs.recent("one", 0, 1)[1], 5.0)
    outputs.close()
    return outputs.recent("one", 0, REMEMBERED_LINES)[1]


def test_what_commands_a_terminal_is_shown_instead() -> None:
    lines = spoken(b"\x1b]52;c;aGk=\x07 \xc2\x9b2J\0\ttab \xc3\xa9 \xff\r\n")
    assert lines == ["\\x1b]52;c;aGk=\\x07 \\x9b2J\\x00\ttab \xe9 \ufffd\n"]


@given(st.binary(max_size=300))
def test_any_output_fits_into_an_answer(said: bytes) -> None:
    text = "".join(_lines(said))
    payload = b"".join(LOG_LINES.encode(LogLines(first=1, next=2, text=text)))
    assert LOG_LINES.decode(payload).text == text
    assert all(c == "\t" or c == "\n" or c.isprintable() or ord(c) >= 160 for c in text)


def _lines(said: bytes) -> list[str]:
    return [readable(line) + "\n" for line in said.split(b"\n")]


def test_lines_left_out_for_a_slow_disk_are_counted_where_they_are_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk, waiting = threading.Event(), threading.Event()

    class Slow(LogFile):
        def write(self, text: str, now: float) -> None:
            waiting.set()
            disk.wait(10.0)
            super().write(text, now)

    monkeypatch.setattr(robomon_outputs, "LogFile", Slow)
    monkeypatch.setattr(robomon_outputs, "ROOM", 2)
    log = tmp_path / "one.log"
    log.touch()
    with closing(ModuleLogs(tmp_path)) as outputs:
        source, pipe = os.pipe()
        outputs.add("one", source)
        with os.fdopen(pipe, "wb", buffering=0) as file:
            file.write(b"0\n")
            until(waiting.is_set, 5.0)
            file.write(b"1\n2\n3\n4\n5\n")
            until(lambda: len(outputs.recent("one", 0, 9)[1]) == 6, 5.0)
            disk.set()
            said = "(3 lines of one were left out here, as the disk was too slow)\n"
            until(lambda: log.read_text() == f"0\n1\n2\n{said}", 5.0)


def test_endless_line_is_cut() -> None:
    assert max(map(len, spoken(b"x" * 100_000))) == LINE_BYTES + 1


def test_end_of_the_reader_before_it_was_woken_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    outputs = ModuleLogs(None)
    reader = next(each for each in threading.enumerate() if each.name == "outputs")
    write = os.write

    def late(file: int, data: bytes) -> int:
        write(file, data)
        reader.join()
        return write(file, data)

    monkeypatch.setattr(os, "write", late)
    outputs.close()
    monkeypatch.undo()
    outputs.close()
