"""One module's process: start it, see whether it lives, end it for certain."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Sequence

from hub.errors import ModuleStartError
from hub.robomon.table import ModuleSpec


class ModuleProcess:
    """A running module.

    The daemon keeps the other end of the process's standard input; when the daemon dies, however
    it dies, that pipe ends and the module stops by itself.
    """

    def __init__(self, spec: ModuleSpec, arguments: Sequence[str]) -> None:
        """Start it.

        Raises:
            ModuleStartError: The system cannot execute the command.
        """
        self.spec = spec
        try:
            self._process = subprocess.Popen(
                [*spec.command, *arguments],
                stdin=subprocess.PIPE,
                # Its own group: Ctrl-C in the daemon's terminal is for the daemon alone, which
                # ends the modules in order.
                process_group=0,
            )
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            text = f"module {spec.name} cannot be started: {spec.command[0]!r}: {reason}"
            raise ModuleStartError(text) from error

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def exit_code(self) -> int | None:
        """How it ended (negative: by that signal); None while it runs."""
        return self._process.poll()

    def ask_to_stop(self) -> None:
        """Ask it to stop; returns at once."""
        if self._process.poll() is None:
            self._process.terminate()

    def wait(self, seconds: float) -> bool:
        """Whether it ends within `seconds`."""
        try:
            self._process.wait(max(0.0, seconds))
        except subprocess.TimeoutExpired:
            return False
        return True

    def end(self) -> None:
        """Kill what still lives of it and of what it has started; returns when it is gone."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        if self._process.stdin is not None:
            self._process.stdin.close()
