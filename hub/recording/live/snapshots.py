"""Keeps the time around a moment as a file of its own, from the files of a series.

| state | next |
| --- | --- |
| waits for the end of the span | the series goes on in another file |
| waits until the files of the span are complete | second names keep them from a ring |
| a program writes them into one file | the second names are removed |
"""

from __future__ import annotations

import contextlib
import logging
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from hub.recording.live.series import RecordingSeries

_logger = logging.getLogger(__name__)

MOST = 20
"""Most snapshots under way at once."""


class Snapshot:
    """One snapshot under way.

    Attributes:
        target: Its file.
        done: Whether nothing is left to do.
        fault: Why there is no file; empty: there is one, or there will be.
    """

    def __init__(self, series: RecordingSeries, target: Path, begin: float, end: float) -> None:
        """Begin.

        Args:
            series: Where its messages are.
            target: Its file.
            begin: First moment of the span, on the monotonic clock [s].
            end: Last moment.
        """
        self.target = target
        self.done = False
        self.fault = ""
        self._series, self._begin, self._end = series, begin, end
        self._links = target.with_suffix(".parts")
        self._process: subprocess.Popen[bytes] | None = None
        self._step: Callable[[float], None] = self._wait_for_end

    def look(self, now: float) -> None:
        """Do what is due at `now` [s]."""
        try:
            self._step(now)
        except OSError as error:
            self._end_with(error.strerror or str(error))

    def _wait_for_end(self, now: float) -> None:
        if now >= self._end:
            self._series.split()
            self._step = self._wait_for_files

    def _wait_for_files(self, _now: float) -> None:
        if not self._series.settled:
            return
        files = self._series.files(self._begin, self._end)
        self._links.mkdir(parents=True, exist_ok=True)
        links = []
        for number, path in enumerate(files):
            links.append(self._links / f"{number}-{path.name}")
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
