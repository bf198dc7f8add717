"""Programs that the console starts: they say when they are ready, and end with the console."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from hub.plain_text import plain
from rune_tui.errors import OwnHubError

_SAID = "rune-hub: "
"""Begins the line in which the program says why it ends."""
_LONGEST_LOG = 100_000
_START_S, _LONGEST_START_S = 10.0, 60.0
"""Time to start; longest time for a program that uses the processor meanwhile [s]."""
_STOP_S = 8.0


def hub_command(*words: str) -> list[str]:
    """The command of a `rune-hub` that says what happens, and ends with its standard input."""
    return [sys.executable, "-m", "hub", *words, "--json", "--stop-with-stdin"]


class OwnProgram:
    """A program that ends with its standard input: with this process at any kind of end."""

    def __init__(
        self,
        what: str,
        command: Sequence[str],
        log: Path,
        environment: Mapping[str, str] | None = None,
        *,
        asks: bool = False,
    ) -> None:
        """Start the process; its start continues in parallel with the console's.

        Args:
            what: What it is, in the words of errors.
            command: The command.
            log: File for what it writes.
            environment: Further variables of its environment.
            asks: Whether it may ask the operator at the terminal.

        Raises:
            OwnHubError: The process cannot be started.
        """
        self._what, self._log = what, log
        try:
            with log.open("ab") as file:
                self._written = file.tell()
                self._process = subprocess.Popen(
                    command,
                    bufsize=0,  # what it says in one go is not kept from the selector
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=file,
                    process_group=None if asks else 0,
                    env={**os.environ, **(environment or {})},
                )
        except OSError as error:
            text = f"{what} cannot be started: {error}"
            raise OwnHubError(text) from error

    def listening(self) -> dict[str, Any]:
        """Wait until it listens; returns what it says then.

        Raises:
            OwnHubError: It ended, or takes too long.
        """
        began, used = time.monotonic(), -1
        while time.monotonic() - began < _LONGEST_START_S and self._used() > used:
            used = self._used()
            said = self.said(lambda said: said.get("event") == "listening", _START_S)
            if said is not None:
                return said
        late = time.monotonic() - began
        if self.reason:
            text = f"{self._what} did not start: {self.reason}"
        elif self.code(0.0) is None:
            text = (
                f"{self._what} did not start within {late:.0f} s{_load()}; its log is {self._log}"
            )
        else:
            text = f"{self._what} ended at its start; {self._log} says why"
        raise OwnHubError(text)

    def _used(self) -> int:
        """The processor time that it has used [ticks]; 0 where the system does not say it."""
        with contextlib.suppress(OSError, ValueError, IndexError):
            fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
            return int(fields[11]) + int(fields[12])  # utime and stime of proc_pid_stat(5)
        return 0

    def said(
        self, wanted: Callable[[dict[str, Any]], bool], within: float
    ) -> dict[str, Any] | None:
        """Wait until it says something wanted; None: it ended, or takes longer than this [s]."""
        pipe = self._process.stdout
        if pipe is None:
            return None
        deadline = time.monotonic() + within
        with selectors.DefaultSelector() as selector:
            selector.register(pipe, selectors.EVENT_READ)
            while selector.select(max(0.0, deadline - time.monotonic())):
                line = pipe.readline()
                if not line:
                    break
                with contextlib.suppress(ValueError):  # a login may print something of its own
                    said = json.loads(line)
                    if isinstance(said, dict) and wanted(said):
                        return said
        return None

    def code(self, within: float = _STOP_S) -> int | None:
        """Its exit code; None: it runs longer than this [s]."""
        try:
            return self._process.wait(within)
        except subprocess.TimeoutExpired:
            return None

    @property
    def reason(self) -> str:
        """What it said before it ended; empty: nothing."""
        lines = self.written
        said = (line.removeprefix(_SAID) for line in lines if line.startswith(_SAID))
        return plain(next(said, ""))

    @property
    def written(self) -> list[str]:
        """The lines that it wrote to its log."""
        with self._log.open("rb") as file:
            file.seek(self._written)
            return file.read(_LONGEST_LOG).decode(errors="replace").splitlines()

    def begin_end(self) -> None:
        """Have it end, and do not wait."""
        if self._process.stdin is not None:
            self._process.stdin.close()

    def close(self) -> None:
        """End it."""
        self.begin_end()
        try:
            self._process.wait(_STOP_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()


def _load() -> str:
    """The load of the machine, for an error; empty: the system does not say it."""
    if not hasattr(os, "getloadavg"):
        return ""
    return f" (load {os.getloadavg()[0]:.0f} on {os.cpu_count()} processors)"
