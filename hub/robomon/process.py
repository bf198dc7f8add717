"""One module's process: start it, see whether it lives, end it for certain."""

from __future__ import annotations

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
        except OSError as error:
            text = f"module {spec.name} cannot be started: {spec.command[0]}: {error.strerror}"
            raise ModuleStartError(text) from error

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def exit_code(self) -> int | None:
        """How it ended (negative: by that signal); None while it runs."""
        code = self._process.poll()
        if code is not None:
            self._close_pipe()
        return code

    def end(self) -> None:
        """Ask it to stop, and kill it if it does not in time; returns when it is gone."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(self.spec.stop_timeout_s)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._close_pipe()

    def _close_pipe(self) -> None:
        if self._process.stdin is not None:
            self._process.stdin.close()
