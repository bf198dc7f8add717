"""The console of a trial: `rune run` in this terminal, conducted over a socket."""

from __future__ import annotations

import contextlib
import json
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from rune_study.errors import StudyError

_LONGEST = 65_536
_END_S = 8.0
"""Longest time of an orderly end before the process is ended by force [s]."""
_ANSWER_S = 10.0


class ConsoleProcess:
    """A console; it ends with this process at any kind of end."""

    def __init__(self, layout: str, options: Sequence[str]) -> None:
        """Start it in this terminal.

        Args:
            layout: Name or path of the layout.
            options: Further options of `rune run`.

        Raises:
            StudyError: It cannot be started.
        """
        ours, theirs = socket.socketpair()
        with theirs:
            handle = theirs.fileno()
            command = [sys.executable, "-m", "rune_tui", "run", layout, *options]
            try:
                self._process = subprocess.Popen(
                    [*command, "--conductor", str(handle)], pass_fds=[handle]
                )
            except OSError as fault:
                ours.close()
                text = f"the console cannot be started: {fault}"
                raise StudyError(text) from fault
        self._line = ours
        self._unread = b""
        self._kept: list[dict[str, Any]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def running(self) -> bool:
        """Whether it runs."""
        return self._process.poll() is None

    @property
    def exit_code(self) -> int | None:
        """Its exit code; None: it runs."""
        return self._process.poll()

    def order(self, do: str, **data: object) -> None:
        """Give an order; see `rune_tui.conducted`. A console that has ended gets none."""
        with contextlib.suppress(OSError):
            self._line.sendall(json.dumps({"do": do, **data}).encode() + b"\n")

    def reports(self, timeout: float = 0.0) -> Iterator[dict[str, Any]]:
        """What it reported; waits up to `timeout` [s] for the first."""
        kept, self._kept = self._kept, []
        yield from kept
        yield from self._received(timeout)

    def _received(self, timeout: float) -> Iterator[dict[str, Any]]:
        self._line.settimeout(timeout)
        try:
            received = self._line.recv(_LONGEST)
        except (TimeoutError, BlockingIOError, ConnectionError):
            return
        *lines, self._unread = (self._unread + received).split(b"\n")
        for line in lines:
            with contextlib.suppress(ValueError):
                report = json.loads(line)
                if isinstance(report, dict):
                    yield report

    def wait_for(self, event: str) -> bool:
        """Wait for a report of this kind; False: the console ended, or takes too long.

        Others that come before are kept for `reports`.
        """
        for _ in range(int(_ANSWER_S * 10)):
            found = list(self._received(0.1))
            self._kept += (each for each in found if each.get("event") != event)
            if any(each.get("event") == event for each in found):
                return True
            if not self.running:
                return False
        return False

    def close(self) -> None:
        """End it, by force if it must be."""
        self.order("end")
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self._process.terminate()
            try:
                self._process.wait(_END_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._line.close()


def console_options(
    hubs: Sequence[str],
    operator: str,
    record: Path,
    variables: Sequence[tuple[str, str]],
    limits: str,
    keys: Path | None = None,
) -> list[str]:
    """Options of `rune run` for a trial.

    Args:
        hubs: Endpoints, one for each robot.
        operator: The participant's code.
        record: Folder of the console's recording.
        variables: Values of the layout's variables.
        limits: What robots may do by themselves, see `rune_tui.model.operating_limits`.
        keys: The key file, for hubs on other machines.
    """
    words = [("--hub", hub) for hub in hubs]
    words += [("--operator", operator), ("--record", str(record)), ("--limits", limits)]
    words += [("--keys", str(keys))] if keys is not None else []
    words += [("--set", f"{name}={value}") for name, value in variables]
    return [each for pair in words for each in pair]
