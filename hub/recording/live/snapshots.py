"""Keeps the time around a moment as a file of its own, from the files of a series.

| state | next |
| --- | --- |
| waits for the end of the span | the series goes on in another file |
| waits until the files of the span are complete | second names keep them from a ring |
| a program writes them into one file | the second names are removed |

The folder of the second names has a note of the span from the begin on: a recorder that ends before
leaves it. The next one waits for the rest of the span, and writes the snapshot from the files of
both. It says how much is missing between them.
"""

from __future__ import annotations

import contextlib
import json
import logging
import math
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, Protocol, Self

from hub import files
from hub.recording.live.places import SUFFIX
from hub.recording.new_recording import PARTIAL
from hub.recording.writer import boot

_logger = logging.getLogger(__name__)

MOST = 20
"""Most snapshots under way at once."""
_SHORT_S = 0.5
"""Time that a snapshot may lack without a word: a killed recorder loses as much [s]."""
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


Following = Callable[[], SnapshotSource | None]
"""Finds what is recorded now; None: nothing."""


class Snapshot:
    """One snapshot under way.

    Attributes:
        target: Its file.
        done: Whether nothing is left to do.
        fault: Why there is no file, or what it lacks; empty: it is whole, or will be.
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
        since = time.time() + self._begin - time.monotonic()
        note = _Note(self._begin, self._end, since, folder, boot())
        try:
            self._links.mkdir(parents=True, exist_ok=True)
            note.write(self._links)
        except OSError as error:
            _logger.warning("a crash would end snapshot %s: %s", self.target, error)

    def _wait_for_end(self, now: float) -> None:
        left = isinstance(self._source, _LeftFiles) and not self._source.goes_on(now)
        if now >= self._end or left:
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
        missing = self._source.missing if isinstance(self._source, _LeftFiles) else 0.0
        with contextlib.suppress(OSError):
            shutil.rmtree(self._links)
        if missing > _SHORT_S:
            length = self._end - self._begin
            self._end_with(f"it lacks {missing:.1f} of {length:.1f} s: no recorder ran then")
            return
        self.done = True
        _logger.info("snapshot %s is written", self.target)

    def _end_with(self, fault: str) -> None:
        self.done, self.fault = True, f"snapshot {self.target.name}: {fault}"[:1000]
        _logger.warning("%s", self.fault)


class _LeftFiles:
    """The files of an earlier recorder and of this one, for a snapshot that was not finished."""

    def __init__(self, left: Path, note: _Note, following: Following) -> None:
        """Find them: those that have second names, and those with anything after a date.

        The others get second names as well, which keep them from a ring.
        """
        found = {each.stat().st_ino: each for each in left.glob(f"*{SUFFIX}")}
        for each in note.folder.glob(f"*{SUFFIX}"):
            status = each.stat()
            if status.st_mtime >= note.since and status.st_ino not in found:
                second = left / each.name
                try:
                    second.hardlink_to(each)
                except OSError:  # on another disk
                    second = each
                found[status.st_ino] = second
        self._files = sorted(found.values(), key=lambda each: each.stat().st_mtime)
        self._left, self._note, self._find = left, note, following
        self._following: SnapshotSource | None = None

    def goes_on(self, now: float) -> bool:
        """Whether messages of the span come at `now` [s], or may come yet."""
        if self._note.boot == "" or self._note.boot != boot():  # the clock is another one
            return False
        if self._following is None:
            self._following = self._find()
            if self._following is not None:
                self._note = self._note._replace(missing=self._missing_until(now))
                with contextlib.suppress(OSError):
                    self._note.write(self._left)
        return True

    @property
    def missing(self) -> float:
        """How long no recorder ran within the span [s]."""
        return self._missing_until(math.inf) if self._following is None else self._note.missing

    def _missing_until(self, moment: float) -> float:
        note = self._note
        last = max((each.stat().st_mtime for each in self._files), default=note.since)
        left_off = note.begin + last - note.since
        return note.missing + max(0.0, min(note.end, moment) - max(note.begin, left_off))

    @property
    def settled(self) -> bool:
        """Whether the files are complete."""
        return self._following is None or self._following.settled

    def split(self) -> None:
        """Complete the present file."""
        if self._following is not None:
            self._following.split()

    def files(self, begin: float, end: float) -> list[Path]:
        """All of them; what is not in the span is left out when they are read."""
        if self._following is None:
            return self._files
        left = {each.stat().st_ino for each in self._files}
        later = self._following.files(begin, end)
        return [*self._files, *(each for each in later if each.stat().st_ino not in left)]


class _Note(NamedTuple):
    """What a recorder noted of a snapshot.

    Attributes:
        begin: First moment of the span, on the monotonic clock [s].
        end: Last moment.
        since: Date of the first moment [s since 1970].
        folder: The folder of the files.
        boot: The run of the machine that the clock belongs to; empty: unknown.
        missing: How long no recorder ran within it so far [s].
    """

    begin: float
    end: float
    since: float
    folder: Path
    boot: str
    missing: float = 0.0

    def write(self, links: Path) -> None:
        """Write it into the folder of second names.

        Raises:
            OSError: It cannot be written.
        """
        content = {**self._asdict(), "folder": str(self.folder)}
        files.replace(links / _NOTE, json.dumps(content).encode())

    @classmethod
    def read(cls, links: Path) -> Self:
        """Read it from there.

        Raises:
            OSError, ValueError, KeyError, TypeError: It cannot be read, or is damaged.
        """
        note = json.loads((links / _NOTE).read_text())
        begin, end, since = (float(note[name]) for name in ("begin", "end", "since"))
        missing = float(note.get("missing", 0.0))
        return cls(begin, end, since, Path(note["folder"]), str(note.get("boot", "")), missing)


def left_snapshots(folder: Path, following: Following) -> list[Snapshot]:
    """The snapshots that an earlier recorder did not finish.

    Call it before this recorder has files.

    Args:
        folder: The folder of snapshots.
        following: Finds what this recorder writes, which has the rest of their spans.
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
            note = _Note.read(left)
            source = _LeftFiles(left, note, following)
            found.append(Snapshot(source, target, note.begin, note.end))
        except (OSError, ValueError, KeyError, TypeError) as error:
            _logger.warning("snapshot %s cannot be finished: %s; see %s", target, error, left)
        else:
            _logger.warning("snapshot %s was not finished; this recorder goes on with it", target)
    return found
