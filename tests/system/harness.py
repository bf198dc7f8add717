"""Real processes for system tests and benchmarks: a hub, and a console on a pseudo-terminal."""

from __future__ import annotations

import itertools
import json
import os
import selectors
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import psutil
import pytest

from hub.gcm import navigation
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from tests.support import warm_start
from tests.support.waiting import Limit, exit_code, until
from tests.system.terminal_process import TerminalProcess

ROBOT_FILE = """
name = "magellan"
kind = "{kind}"
[hub]
{gateway}
[simulation]
arena = "{arena}"
seed = 7
[mapping]
folder = "maps"
[mission]
folder = "missions"
{modules}
"""
MODULES = ("driver", "navigation", "vision")


def robot_file(
    arena: str = "empty",
    gateway: str = "",
    modules: Sequence[str] = MODULES,
    tables: str = "",
    kind: str = "simulated-magellan",
) -> str:
    """A robot file; `gateway` is lines of its table of the hub, `tables` are more tables."""
    lines = "\n".join(f'[modules.{name}]\nrun = "hub.modules.{name}"' for name in modules)
    said = {"arena": arena, "gateway": gateway, "kind": kind}
    return ROBOT_FILE.format(**said, modules=lines) + tables


def in_soak(*values: Any) -> list[Any]:
    """Parameters of a test that are tried in `make soak` only."""
    return [pytest.param(value, marks=pytest.mark.soak) for value in values]


_numbers = itertools.count(1)
_FRESH_S = 0.08
"""Ground truth comes every 20 ms; what is older than this may be queued [s]."""


class HubProcess:
    """`rune-hub run`, from start to end.

    Attributes:
        running: All that are not closed; the report of a failed test shows their logs.
    """

    running: ClassVar[list[HubProcess]] = []

    def __init__(
        self,
        folder: Path,
        *,
        options: Sequence[str] = (),
        environment: dict[str, str] | None = None,
        name: str = "",
        **robot_keys: Any,
    ) -> None:
        """Start it with a `robot_file` of these keys, and variables besides this process's own.

        A name gives the hub the same endpoint again when it is started again.
        """
        robot = folder / "robot.toml"
        robot.write_text(robot_file(**robot_keys))
        self.log = folder / "hub.log"
        command = [sys.executable, "-m", "hub", "run", str(robot), "--json", "--stop-with-stdin"]
        command += ["--as", name or f"test-{os.getpid()}-{next(_numbers)}"]
        with self.log.open("wb") as log:
            self.process = warm_start.start(
                [*command, *options],
                environment={**os.environ, **(environment or {})},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log.fileno(),
            )
        self.running.append(self)
        try:
            self.listening = self._said("listening")
            self.endpoint = self.listening["hub"]
            self.pids: dict[str, int] = self._said("ready")["pids"]
        except BaseException:
            self.close()
            raise

    def _said(self, event: str) -> dict[str, Any]:
        pipe = self.process.stdout
        assert pipe is not None
        with selectors.DefaultSelector() as selector:
            selector.register(pipe, selectors.EVENT_READ)
            limit = Limit(20.0)
            while not limit.over:
                if not selector.select(0.5):
                    continue
                line = pipe.readline()
                assert line, f"the hub ended: {self.log.read_text()}"
                said: dict[str, Any] = json.loads(line)
                if said["event"] == event:
                    return said
        text = f"the hub never said {event}: {self.log.read_text()}"
        raise AssertionError(text)

    def close(self) -> None:
        """Stop it as the demo does."""
        if self in self.running:
            self.running.remove(self)
        if self.process.stdin is not None:
            self.process.stdin.close()
        exit_code(self.process, 15.0)
        if self.process.stdout is not None:
            self.process.stdout.close()


class Observer:
    """A client that remembers messages with the time they came."""

    def __init__(self, endpoint: str, *definitions: MessageDefinition[Any]) -> None:
        self.client = Client(f"observer-{os.getpid()}-{id(self)}", endpoint)
        self.seen: dict[str, deque[tuple[float, Any]]] = {}
        self.client.wait_connected(5.0)
        for definition in definitions or (navigation.GROUND_TRUTH,):
            history: deque[tuple[float, Any]] = deque(maxlen=100_000)
            self.seen[definition.name] = history

            def remember(
                value: Any, reception: MessageInfo, history: deque[tuple[float, Any]] = history
            ) -> None:
                history.append((reception.measured, value))

            self.client.subscribe(definition, remember)
        self.wait(lambda: all(self.seen.values()), 10.0)

    @property
    def truth(self) -> navigation.GroundTruth:
        """Where the robot really is now."""
        self.wait(lambda: time.monotonic() - self.history[-1][0] < _FRESH_S, 10.0, "no truth comes")
        newest: navigation.GroundTruth = self.history[-1][1]
        return newest

    @property
    def history(self) -> deque[tuple[float, Any]]:
        """Ground truth with times on this process's monotonic clock."""
        return self.seen[navigation.GROUND_TRUTH.name]

    def wait(
        self,
        condition: Any,
        timeout: float,
        why: str | Callable[[], str] = "it did not happen",
    ) -> None:
        until(condition, timeout, why, meanwhile=lambda: self.client.listen(0.01))

    def close(self) -> None:
        self.client.close()


class ConsoleProcess(TerminalProcess):
    """`rune ...` on a pseudo-terminal."""

    def __init__(
        self, arguments: Sequence[str], *, within: Sequence[str] = (), **terminal: Any
    ) -> None:
        """Start it.

        Args:
            arguments: What follows `rune`.
            within: A command that runs it, such as a terminal multiplexer.
            **terminal: As of `TerminalProcess`.
        """
        super().__init__([*within, sys.executable, "-m", "rune_tui", *arguments], **terminal)


RELEASED_S = 0.8
"""After this time a key that was typed once counts as released [s]."""


def press(console: ConsoleProcess, key: str) -> None:
    """Press a key, and wait until the console counts it as released: it gets no release."""
    console.type(key)
    released = time.monotonic() + RELEASED_S
    console.wait(lambda: time.monotonic() > released, 10.0)


STILL = 1e-3
"""A robot that is slower stands [m/s]."""


def drive(console: ConsoleProcess, observer: Observer) -> None:
    """Hold the key for forward until the robot drives."""
    console.hold_until("w", lambda: observer.truth.linear > 0.2)


def expect_stop(observer: Observer) -> None:
    """The robot is told to stop soon, and does."""
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 2.0, "the wheels are driven on")
    observer.wait(lambda: abs(observer.truth.linear) < STILL, 2.0, "it rolls on")


def gone(processes: Sequence[psutil.Process]) -> bool:
    """Whether all of them have ended."""
    return not any(map(_runs, processes))


def _runs(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:  # it ended between the two looks
        return False


def family(pid: int) -> list[psutil.Process]:
    """A process and all its descendants."""
    process = psutil.Process(pid)
    return [process, *process.children(recursive=True)]
