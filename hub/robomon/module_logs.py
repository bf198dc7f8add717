"""The modules' output: read at once, and kept in files that rotate.

One thread reads all the pipes, and waits for nothing else. A second one writes files and standard
error, which may be slow. It drops lines that it cannot write in time, and writes their number.
"""

from __future__ import annotations

import contextlib
import fcntl
import logging
import math
import os
import queue
import selectors
import threading
import time
from collections import deque
from dataclasses import field
from pathlib import Path
from typing import IO

from hub import nonblocking_logging, paths
from hub.plain_text import plain
from hub.robomon.log_file import RETRY_S, LogFile
from hub.values import dataclass

_logger = logging.getLogger(__name__)

REMEMBERED_LINES = 1000
"""Number of lines that are kept of each module."""
LINE_BYTES = 4096
"""Longest line; a longer one is cut."""
BYTES_PER_S = 200_000
"""Most output of a module; more is dropped."""
ROOM = 5000
_CHUNK = 65_536
_LAST_WORDS_S = 1.0
_FOLDERS = 9


@dataclass(slots=True)
class _Source:
    """One module's output."""

    name: str
    pending: bytes = b""
    lines: deque[str] = field(default_factory=lambda: deque(maxlen=REMEMBERED_LINES))
    count: int = 0
    second: int = 0
    read: int = 0
    left_out: int = 0
    unwritten: int = 0

    def missing(self) -> str:
        """A line with the number of lines dropped since the last one; empty: none."""
        count, self.unwritten = self.unwritten, 0
        subject = (
            f"{count} lines of {self.name} were" if count > 1 else f"a line of {self.name} was"
        )
        return f"({subject} left out here, as the disk was too slow)\n" if count else ""


class ModuleLogs:
    """The outputs of all modules."""

    def __init__(self, folder: Path | None) -> None:
        """Start the threads.

        Args:
            folder: Folder of the files; None: no files.
        """
        self._folder = folder
        self._sources: dict[str, _Source] = {}
        self._files: dict[str, LogFile] = {}
        self._lock = threading.Lock()
        self._selector = selectors.DefaultSelector()
        self._wake, self._waker = os.pipe()
        self._selector.register(self._wake, selectors.EVENT_READ)
        self._added: queue.SimpleQueue[tuple[str, int]] = queue.SimpleQueue()
        self._written: queue.Queue[tuple[str, str] | None] = queue.Queue(ROOM)
        self._ended = threading.Event()
        self._reader = threading.Thread(target=self._read, name="outputs", daemon=True)
        self._writer = threading.Thread(target=self._write, name="log files", daemon=True)
        self._reader.start()
        self._writer.start()

    def add(self, name: str, pipe: int) -> None:
        """Read this pipe to its end, and close it."""
        with self._lock:
            self._sources.setdefault(name, _Source(name))
        os.set_blocking(pipe, False)
        self._added.put((name, pipe))
        os.write(self._waker, b"+")

    def recent(self, name: str, first: int, most: int) -> tuple[int, list[str]]:
        """Recent lines of a module.

        Args:
            name: Of the module.
            first: Number of the first line, from 1; 0: the last ones.
            most: Most lines.

        Returns:
            Number of the first line, and the lines.
        """
        with self._lock:
            source = self._sources.get(name)
            lines = list(source.lines) if source else []
            oldest = source.count - len(lines) + 1 if source else 1
        skip = max(0, first - oldest) if first > 0 else max(0, len(lines) - most)
        return oldest + min(skip, len(lines)), lines[skip : skip + most]

    def fault(self, name: str) -> str:
        """The fault of a module's log file, as words after its name; empty: none."""
        file = self._files.get(name)
        if file is None or not file.lost:
            return ""
        lines = f"{file.lost} lines" if file.lost > 1 else "a line"
        return f"has lost {lines} of its log: {file.reason}"

    def close(self) -> None:
        """Write the rest, and end the threads."""
        if self._ended.is_set():
            return
        self._ended.set()
        os.write(self._waker, b"-")
        self._reader.join(_LAST_WORDS_S)
        if not self._reader.is_alive():
            # Only now: another file may get the number after the thread's end.
            os.close(self._wake)
            os.close(self._waker)
        with contextlib.suppress(queue.Full):
            self._written.put(None, timeout=_LAST_WORDS_S)
            self._writer.join(_LAST_WORDS_S)

    def _read(self) -> None:
        end = float("inf")
        while time.monotonic() < end:
            for key, _ in self._selector.select(0.1 if self._ended.is_set() else None):
                if key.fd == self._wake:
                    os.read(self._wake, 64)
                else:
                    self._take(key.fd, key.data)
            while not self._added.empty():
                name, pipe = self._added.get()
                self._selector.register(pipe, selectors.EVENT_READ, self._sources[name])
            if self._ended.is_set():
                end = min(end, time.monotonic() + _LAST_WORDS_S / 2)
                if len(self._selector.get_map()) == 1:
                    break
        for key in list(self._selector.get_map().values()):
            if key.fd != self._wake:
                os.close(key.fd)
        self._selector.close()

    def _take(self, pipe: int, source: _Source) -> None:
        try:
            chunk = os.read(pipe, _CHUNK)
        except BlockingIOError:
            return
        except OSError:
            chunk = b""
        if not chunk:
            self._selector.unregister(pipe)
            os.close(pipe)
            if source.pending:
                self._keep(source, [source.pending])
                source.pending = b""
            return
        second = int(time.monotonic())
        if second != source.second:
            if source.left_out:
                notice = b"(%d bytes were left out: more than a module may write)" % source.left_out
                self._keep(source, [notice])
            source.second, source.read, source.left_out = second, 0, 0
        source.read += len(chunk)
        if source.read > BYTES_PER_S:
            source.left_out += len(chunk)
            source.pending = b""
            return
        *lines, source.pending = (source.pending + chunk).split(b"\n")
        if len(source.pending) > LINE_BYTES:
            lines.append(source.pending)
            source.pending = b""
        self._keep(source, lines)

    def _keep(self, source: _Source, lines: list[bytes]) -> None:
        texts = [readable(line[:LINE_BYTES]) + "\n" for line in lines]
        with self._lock:
            source.lines.extend(texts)
            source.count += len(texts)
            for text in texts:
                if self._written.full():
                    source.unwritten += 1
                else:
                    self._written.put_nowait((source.name, source.missing() + text))

    def _write(self) -> None:
        going_on = True
        while going_on:
            try:
                item = self._written.get(timeout=RETRY_S if self._any_lost() else None)
            except queue.Empty:
                for file in self._files.values():
                    file.retry(time.monotonic())
                continue
            going_on = item is not None
            written = [item] if item else []
            if self._written.empty():
                with self._lock:
                    missing = [(each.name, each.missing()) for each in self._sources.values()]
                written += [(name, text) for name, text in missing if text]
            for name, text in written:
                self._write_one(name, text)
        for file in self._files.values():
            file.retry(math.inf)
            file.close()

    def _any_lost(self) -> bool:
        return any(file.lost for file in self._files.values())

    def _write_one(self, name: str, text: str) -> None:
        nonblocking_logging.pass_on(text)
        if self._folder is None:
            return
        if name not in self._files:
            # A new table: another thread may read the old one.
            self._files = {**self._files, name: LogFile(self._folder / f"{name}.log")}
        self._files[name].write(text, time.monotonic())


def readable(line: bytes) -> str:
    """The text of a line, with control characters as numbers: they command terminals."""
    return plain(line.decode(errors="replace").rstrip("\r"), lines=True)


class LogFolder:
    """The folder of a robot's log files, for one daemon at a time."""

    def __init__(self, wanted: str, robot: str) -> None:
        """Make and claim it.

        Args:
            wanted: From the robot file; empty: the system's place for such files.
            robot: Name of the robot.
        """
        self.path: Path | None = None
        self._lock: IO[bytes] | None = None
        parent = paths.for_logs(wanted)
        for number in range(1, _FOLDERS + 1):
            path = parent / (robot if number == 1 else f"{robot}-{number}")
            try:
                path.mkdir(parents=True, exist_ok=True)
                self._lock = (path / ".lock").open("wb")
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue  # another daemon on this machine
            except OSError as error:
                _logger.warning("there are no log files: %s: %s", path, error.strerror)
                break
            self.path = path
            return
        else:
            _logger.warning("there are no log files: %d daemons write to %s", _FOLDERS, parent)

    def close(self) -> None:
        """Release it to other daemons."""
        if self._lock is not None:
            self._lock.close()
