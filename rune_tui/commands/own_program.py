"""A program that the console starts: it says when it is ready, and ends with the console."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hub.plain_text import plain
from rune_tui.errors import OwnHubError

_SAID = "rune-hub: "
"""Begins the line in which the program says why it ends."""
_LONGEST_LOG = 100_000
_START_S = 10.0
_STOP_S = 8.0


class OwnProgram:
    """A command of `rune-hub`; it ends with this process at any kind of end."""

    def __init__(
        self, what: str, command: Sequence[str], log: Path, environment: Mapping[str, str]
    ) -> None:
        """Start the process; its start continues in parallel with the console's.

        Args:
            what: What it is, in the words of errors.
            command: The command, without `rune-hub`.
            log: File for what it writes.
            environment: Further variables of its environment.

        Raises:
            OwnHubError: The process cannot be started.
        """
        self._what, self._log = what, log
        try:
            with log.open("ab") as file:
                self._written = file.tell()
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "hub", *command, "--json", "--stop-with-stdin"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=file,
                    process_group=0,
                    env={**os.environ, **environment},
                )
        except OSError as error:
            text = f"{what} cannot be started: {error}"
            raise OwnHubError(text) from error

    def listening(self) -> dict[str, Any]:
        """Wait until it listens; returns what it says then.

        Raises:
            OwnHubError: It ended, or takes too long.
        """
        pipe = self._process.stdout
        if pipe is None:
            text = f"{self._what} has no output"
            raise OwnHubError(text)
        deadline = time.monotonic() + _START_S
        with selectors.DefaultSelector() as selector:
            selector.register(pipe, selectors.EVENT_READ)
            while selector.select(max(0.0, deadline - time.monotonic())):
                line = pipe.readline()
                if not line:
                    break
                said: dict[str, Any] = json.loads(line)
                if said["event"] == "listening":
                    return said
        reason = self._reason()
        why = f": {reason}" if reason else f"; {self._log} says why"
        text = f"{self._what} did not start{why}"
        raise OwnHubError(text)

    def _reason(self) -> str:
        """What it said before it ended; empty: nothing."""
        with self._log.open("rb") as file:
            file.seek(self._written)
            lines = file.read(_LONGEST_LOG).decode(errors="replace").splitlines()
        said = (line.removeprefix(_SAID) for line in lines if line.startswith(_SAID))
        return plain(next(said, ""))

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
