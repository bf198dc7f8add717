"""A hub that the console starts: a process of its own, on a free loopback port."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from hub.plain_text import plain
from rune_tui.errors import OwnHubError

_SAID = "rune-hub: "
"""Begins the line in which the hub says why it ends."""
_LONGEST_LOG = 100_000
_START_S = 10.0
_STOP_S = 8.0


class OwnHub:
    """`rune-hub run` of a robot; it ends with this process at any kind of end."""

    def __init__(
        self, robot: str, log: Path, settings: Sequence[str] = (), *, keeps: bool = False
    ) -> None:
        """Start the process; its start continues in parallel with the console's.

        Args:
            robot: Name of a shipped robot, or path of a robot file.
            log: File for the hub's log.
            settings: Values that replace the robot file's, such as "simulation.arena=empty".

            keeps: Whether maps and missions stay after its end.

        Raises:
            OwnHubError: The process cannot be started.
        """
        self._log = log
        self._endpoint = ""
        command = [sys.executable, "-m", "hub", "run", robot, "--port", "0", "--json"]
        command += [word for setting in settings for word in ("--set", setting)]
        # A demo's data end with it, so that the next one begins with an empty map.
        self._data = tempfile.TemporaryDirectory(prefix="rune-demo-", ignore_cleanup_errors=True)
        folder = {} if keeps else {"STATE_DIRECTORY": self._data.name}
        try:
            with log.open("ab") as file:
                self._written = file.tell()
                self._process = subprocess.Popen(
                    [*command, "--stop-with-stdin"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=file,
                    process_group=0,
                    env={**os.environ, **folder},
                )
        except OSError as error:
            text = f"the robot's hub cannot be started: {error}"
            raise OwnHubError(text) from error

    def endpoint(self) -> str:
        """Wait until the hub listens; returns its endpoint.

        Raises:
            OwnHubError: The hub ended, or takes too long.
        """
        if not self._endpoint:
            self._endpoint = self._said()
        return self._endpoint

    def _said(self) -> str:
        pipe = self._process.stdout
        if pipe is None:
            text = "the robot's hub has no output"
            raise OwnHubError(text)
        deadline = time.monotonic() + _START_S
        with selectors.DefaultSelector() as selector:
            selector.register(pipe, selectors.EVENT_READ)
            while selector.select(max(0.0, deadline - time.monotonic())):
                line = pipe.readline()
                if not line:
                    break
                said = json.loads(line)
                if said["event"] == "listening":
                    return str(said["hub"])
        reason = self._reason()
        why = f": {reason}" if reason else f"; {self._log} says why"
        text = f"the robot's hub did not start{why}"
        raise OwnHubError(text)

    def _reason(self) -> str:
        """What the hub said before it ended; empty: nothing."""
        with self._log.open("rb") as file:
            file.seek(self._written)
            lines = file.read(_LONGEST_LOG).decode(errors="replace").splitlines()
        said = (line.removeprefix(_SAID) for line in lines if line.startswith(_SAID))
        return plain(next(said, ""))

    def begin_end(self) -> None:
        """Have the hub and all its modules end, and do not wait."""
        if self._process.stdin is not None:
            self._process.stdin.close()

    def close(self) -> None:
        """End the hub and all its modules."""
        self.begin_end()
        try:
            self._process.wait(_STOP_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._data.cleanup()
