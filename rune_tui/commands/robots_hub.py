"""A hub that runs on a robot where Rune is installed, started through ssh for one console."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any, Final

from rune_tui.commands.own_program import OwnProgram
from rune_tui.errors import OwnHubError, TunnelError
from rune_tui.link.tunnel import OPEN_WITHIN_S, ssh_command

NOT_INSTALLED: Final = 127
"""Exit code where there is no `rune-hub`, as of shells."""
_OF_SSH: Final = 255
_SCRIPT: Final = "; ".join(
    (
        'PATH="$PATH:$HOME/.local/bin"',
        "command -v rune-hub >/dev/null || exit 127",
        "folder=$(mktemp -d) || exit 1",
        """trap 'rm -rf -- "$folder"' EXIT""",
        'rune-hub adopt {words} -o "$folder/robot.toml" --json </dev/null || exit',
        'rune-hub run "$folder/robot.toml" --as "console-$$" --json --stop-with-stdin',
    )
)
"""Adopts the robot and runs its hub, until standard input ends: when ssh ends."""


class RobotsHub(OwnProgram):
    """The hub on a robot.

    Attributes:
        code_of_adopting: Its exit code, where it ended before there was a robot file.
    """

    def __init__(self, destination: str, words: list[str], log: Path) -> None:
        """Go to the robot; ssh may ask for a password.

        Args:
            destination: Destination of ssh, [USER@]HOST[:PORT].
            words: What `rune-hub adopt` gets: kind, address, options.
            log: File for what ssh and the hub say.

        Raises:
            TunnelError: This is no destination, or there is no ssh.
            OwnHubError: Ssh cannot be started.
        """
        self._destination = destination
        self.code_of_adopting = 0
        script = _SCRIPT.format(words=shlex.join(words))
        command = [*ssh_command(destination), f"sh -c {shlex.quote(script)}"]
        super().__init__(f"the hub on {destination}", command, log, asks=True)

    def adopted(self) -> dict[str, Any] | None:
        """Wait until the robot is adopted; returns what was found, or None: see the exit code.

        Raises:
            TunnelError: Ssh failed.
            OwnHubError: It takes too long.
        """
        found = self.said(lambda said: "remarks" in said, OPEN_WITHIN_S)
        if found is not None:
            return found
        code = self.code()
        if code is None:
            text = f"the hub on {self._destination} says nothing of a robot"
            raise OwnHubError(text)
        if code == _OF_SSH:
            words = [line.strip() for line in self.written if line.strip()]
            text = f"ssh to {self._destination} failed: {words[-1][:500] if words else 'no reason'}"
            raise TunnelError(text)
        self.code_of_adopting = code
        return None
