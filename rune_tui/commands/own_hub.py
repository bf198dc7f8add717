"""A hub that the console starts, and a simulated autopilot for it."""

from __future__ import annotations

import itertools
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rune_tui.commands.own_program import OwnProgram, hub_command

_numbers = itertools.count(1)


class OwnHub(OwnProgram):
    """`rune-hub run` of a robot."""

    def __init__(
        self, robot: str, log: Path, settings: Sequence[str] = (), *, keeps: bool = False
    ) -> None:
        """Start the process.

        Args:
            robot: Name of a shipped robot, or path of a robot file.
            log: File for the hub's log.
            settings: Values that replace the robot file's, such as "simulation.arena=empty".
            keeps: Whether maps and missions stay after its end.

        Raises:
            OwnHubError: The process cannot be started.
        """
        self._endpoint = ""
        command = ["run", robot, "--as", f"{Path(robot).stem[:16]}-{os.getpid()}-{next(_numbers)}"]
        command += [word for setting in settings for word in ("--set", setting)]
        # A demo's data end with it, so that the next one begins with an empty map.
        self._data = tempfile.TemporaryDirectory(prefix="rune-demo-", ignore_cleanup_errors=True)
        folder = {} if keeps else {"STATE_DIRECTORY": self._data.name}
        super().__init__("the robot's hub", hub_command(*command), log, folder)

    def endpoint(self) -> str:
        """Wait until the hub listens; returns its endpoint.

        Raises:
            OwnHubError: The hub ended, or takes too long.
        """
        if not self._endpoint:
            self._endpoint = str(self.listening()["hub"])
        return self._endpoint

    def close(self) -> None:
        """End the hub and all its modules."""
        super().close()
        self._data.cleanup()


class OwnAutopilot(OwnProgram):
    """`rune-hub sim-autopilot`: a simulated vehicle in an arena."""

    def __init__(self, kind: str, arena: str, log: Path) -> None:
        """Start the process.

        Args:
            kind: "rover", "sub" or "blimp".
            arena: Name or path of the arena.
            log: File for its log.

        Raises:
            OwnHubError: The process cannot be started.
        """
        command = ["sim-autopilot", kind, "--arena", arena, "--tcp", "0", "--fast-boot"]
        super().__init__("the simulated autopilot", hub_command(*command), log)

    def robot(self) -> tuple[str, list[str]]:
        """Wait until it listens; returns its robot file, and the setting with its address.

        Raises:
            OwnHubError: It ended, or takes too long.
        """
        said = self.listening()
        return str(said["robot"]), [f"mavlink.address={said['addresses'][0]}"]
