"""The hubs of `rune demo`: simulated robots in processes of their own, on free loopback ports."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from hub.plain_text import plain
from rune_tui.errors import DemoError

DEMO_LAYOUT = "demo"
AUTO = "auto"
"""The layout that is made from what the robot's hub describes."""
ROBOTS = ("magellan", "tracked", "blimp", "rov")
"""The robots that come with the hub."""
ARENAS = ("empty", "hall", "orange", "pool", "red", "yellow")
"""The arenas that come with the hub."""
_OF_ARENA = {"pool": "rov"}
"""The robot of an arena where it is not the first of `ROBOTS`."""
_OF_ROLE = {name: name for name in ROBOTS} | {"submarine": "rov"}
_ALL_ELEMENTS = "hall"
"""The arena of a demo with several kinds of robots: land, water and air."""
_SAID = "rune-hub: "
"""Begins the line in which the hub says why it ends."""
_LONGEST_LOG = 100_000
_START_S = 10.0
_STOP_S = 8.0


def demo_robots(roles: Sequence[str], arena: str, robot: str | None) -> tuple[list[str], str]:
    """The shipped robot of each role in a layout, and the arena of all of them.

    Args:
        roles: The layout's names of its robots.
        arena: Name or path of the arena; empty: that of the robots.
        robot: The robot of each role that names none; None: the one that suits the arena.
    """
    usual = robot or _OF_ARENA.get(arena, ROBOTS[0])
    robots = [_OF_ROLE.get(role, usual) for role in roles]
    if not arena and len(set(robots)) > 1:
        arena = _ALL_ELEMENTS
    return robots, arena


def demo_layout(arena: str, robot: str | None) -> str:
    """The layout of a demo where none is named.

    Args:
        arena: Name or path of the arena; empty: that of the robot.
        robot: Name of the robot; None: the one that suits the arena.
    """
    (chosen,), _ = demo_robots(["robot"], arena, robot)
    # The shipped layout has no keys for holds, joints or motion up and down.
    return DEMO_LAYOUT if chosen == ROBOTS[0] else AUTO


class DemoHub:
    """`rune-hub run` of a shipped robot; it ends with this process at any kind of end."""

    def __init__(self, robot: str, log: Path, settings: Sequence[str] = ()) -> None:
        """Start the process; its start continues in parallel with the console's.

        Args:
            robot: Name of a shipped robot.
            log: File for the hub's log.
            settings: Values that replace the robot file's, such as "simulation.arena=empty".

        Raises:
            DemoError: The process cannot be started.
        """
        self._log = log
        self._endpoint = ""
        command = [sys.executable, "-m", "hub", "run", robot, "--port", "0", "--json"]
        command += [word for setting in settings for word in ("--set", setting)]
        # A demo's data end with it, so that the next one begins with an empty map.
        self._kept = tempfile.TemporaryDirectory(prefix="rune-demo-", ignore_cleanup_errors=True)
        try:
            with log.open("ab") as file:
                self._written = file.tell()
                self._process = subprocess.Popen(
                    [*command, "--stop-with-stdin"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=file,
                    process_group=0,
                    env={**os.environ, "STATE_DIRECTORY": self._kept.name},
                )
        except OSError as error:
            text = f"the demo's hub cannot be started: {error}"
            raise DemoError(text) from error

    def endpoint(self) -> str:
        """Wait until the hub listens; returns its endpoint.

        Raises:
            DemoError: The hub ended, or takes too long.
        """
        if not self._endpoint:
            self._endpoint = self._said()
        return self._endpoint

    def _said(self) -> str:
        pipe = self._process.stdout
        if pipe is None:
            text = "the demo's hub has no output"
            raise DemoError(text)
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
        text = f"the demo's hub did not start{why}"
        raise DemoError(text)

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
        self._kept.cleanup()


class DemoHubs:
    """The hubs of a demo; they end in parallel, with this context."""

    def __init__(self, log: Path) -> None:
        """Prepare.

        Args:
            log: File for the logs of all hubs.
        """
        self._log = log
        self._hubs: list[DemoHub] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for hub in self._hubs:
            hub.begin_end()
        with ExitStack() as stack:
            for hub in self._hubs:
                stack.callback(hub.close)

    def start(self, robots: Sequence[str], arena: str, settings: Sequence[str] = ()) -> None:
        """Start the hubs of more robots.

        Args:
            robots: Names of shipped robots.
            arena: Name or path of the arena; empty: that of each robot.
            settings: More values that replace those of robot files.

        Raises:
            DemoError: A process cannot be started.
        """
        settings = [*([f"simulation.arena={arena}"] if arena else []), *settings]
        for robot in robots:
            self._hubs.append(DemoHub(robot, self._log, settings))

    def __len__(self) -> int:
        return len(self._hubs)

    def endpoints(self) -> list[str]:
        """Wait until all hubs listen; returns their endpoints.

        Raises:
            DemoError: A hub ended, or takes too long.
        """
        return [hub.endpoint() for hub in self._hubs]
