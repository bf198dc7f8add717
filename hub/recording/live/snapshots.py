"""Keeps the time around a moment as a file of its own, from the files of a series.

| state | next |
| --- | --- |
| waits for the end of the span | the series goes on in another file |
| waits until the files of the span are complete | second names keep them from a ring |
| a program writes them into one file | the second names are removed |

The folder of the second names has a note of the span from the begin on: a recorder that ends before
leaves it, and the next one writes the snapshot from the files that there are.
"""

from __future__ import annotations

import contextlib
import json
import logging
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from hub import files
from hub.recording.live.places import SUFFIX
from hub.recording.new_recording import PARTIAL

_logger = logging.getLogger(__name__)

MOST = 20
"""Most snapshots under way at once."""
_PARTS = ".parts"
_NOTE = "span.json"


class SnapshotSource(Protocol):
    """Files with messages."""

    @property
    def settled(self) -> bool:
        """Whether the files are complete."""

    def split(self) -> None:
        """Complete the present file."""

    def files(self, begin: float, end: float) -> list[Path]:
        """The complete files with anything from `begin` to `end` [s], in order."""


class Snapshot:
    """One snapshot under way.

    Attributes:
        target: Its file.
        done: Whether nothing is left to do.
        fault: Why there is no file; empty: there is one, or there will be.
    """

    def __init__(self, source: SnapshotSource, target: Path, begin: float, end: float) -> None:
        """Begin.

        Args:
            source: Where its messages are.
            target: Its file.
            begin: First moment of the span, on the monotonic clock [s].
            end: Last moment.
        """
        self.target = target
        self.done = False
        self.fault = ""
        self._source, self._begin, self._end = source, begin, end
        self._links = target.with_suffix(_PARTS)
        self._process: subprocess.Popen[bytes] | None = None
        self._step: Callable[[float], None] = self._wait_for_end

    def look(self, now: float) -> None:
        """Do what is due at `now` [s]."""
        try:
            self._step(now)
        except OSError as error:
            self._end_with(error.strerror or str(error))

    def note(self, folder: Path) -> None:
        """Note what a later recorder needs to write it; `folder` has the files of its source."""
        note = {
            "begin": self._begin,
            "end": self._end,
            "since": time.time() + self._begin - time.monotonic(),
            "folder": str(folder),
        }
        try:
            self._links.mkdir(parents=True, exist_ok=True)
            files.replace(self._links / _NOTE, json.dumps(note).encode())
        except OSError as error:
            _logger.warning("a crash would end snapshot %s: %s", self.target, error)

    def _wait_for_end(self, now: float) -> None:
        if now >= self._end or isinstance(self._source, _LeftFiles):
            self._source.split()
            self._step = self._wait_for_files

    def _wait_for_files(self, _now: float) -> None:
        if not self._source.settled:
            return
        parts = self._source.files(self._begin, self._end)
        self._links.mkdir(parents=True, exist_ok=True)
        links = []
        for number, path in enumerate(parts):
            links.append(self._links / f"{number:05}-{path.name}")
            links[-1].unlink(missing_ok=True)
            try:
                links[-1].hardlink_to(path)
            except OSError:  # on another disk
                shutil.copyfile(path, links[-1])
        span = (repr(max(0.0, each)) for each in (self._begin, self._end))
        command = [sys.executable, "-m", "hub.recording.live.snapshot", str(self.target), *span]
        self._process = subprocess.Popen(
            [*command, *map(str, links)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        self._step = self._wait_for_program

    def _wait_for_program(self, _now: float) -> None:
        process = self._process
        if process is None or process.poll() is None:
            return
        said = process.communicate()[1].decode(errors="replace")
        if process.returncode:
            last = said.strip().splitlines()[-1:] or [f"exit code {process.returncode}"]
            self._end_with(f"{last[0]}; its parts are in {self._links}")
            return
        self.done = True
        with contextlib.suppress(OSError):
            shutil.rmtree(self._links)
        _logger.info("snapshot %s is written", self.target)

    def _end_with(self, fault: str) -> None:
        self.done, self.fault = True, f"snapshot {self.target.name}: {fault}"[:1000]
        _logger.warning("%s", self.fault)


class _LeftFiles:
    """The files of an earlier recorder, for a snapshot that it did not finish.

    Attributes:
        settled: Nothing is written into them any more.
    """

    settled = True

    def __init__(self, left: Path, folder: Path, since: float) -> None:
        """Find them: those that have second names, and those with anything after a date [s]."""
        found = {each.stat().st_ino: each for each in left.glob(f"*{SUFFIX}")}
        for each in folder.glob(f"*{SUFFIX}"):
            status = each.stat()
            if status.st_mtime >= since:
                found[status.st_ino] = each
        self._files = sorted(found.values(), key=lambda each: each.stat().st_mtime)

    def split(self) -> None:
        """There is nothing to split."""

    def files(self, _begin: float, _end: float) -> list[Path]:
        """All of them; what is not in the span is left out when they are read."""
        return self._files


def left_snapshots(folder: Path) -> list[Snapshot]:
    """The snapshots that an earlier recorder did not finish.

    Call it before this recorder has files.

    Args:
        folder: The folder of snapshots.
    """
    for partial in folder.glob(f".*{PARTIAL}"):
        if not Path("/proc", partial.name.split(".")[-2]).exists():
            partial.unlink(missing_ok=True)
    found = []
    for left in sorted(folder.glob(f"*{_PARTS}"))[:MOST]:
        target = left.with_suffix(SUFFIX)
        try:
            if target.exists():
                shutil.rmtree(left)
                continue
            note = json.loads((left / _NOTE).read_text())
            source = _LeftFiles(left, Path(note["folder"]), float(note["since"]))
            found.append(Snapshot(source, target, float(note["begin"]), float(note["end"])))
        except (OSError, ValueError, KeyError, TypeError) as error:
            _logger.warning("snapshot %s cannot be finished: %s; see %s", target, error, left)
        else:
            _logger.warning("snapshot %s was not finished and is written now", target)
    return found
