"""Processes: start a module, see whether it lives and what it takes, end it for certain."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import secrets
import signal
import subprocess
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from hub.errors import ModuleStartError
from hub.robomon import orphan_reaper
from hub.robomon.module_table import ModuleSpec

_logger = logging.getLogger(__name__)

_OF_THE_DAEMON = ("NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID")
_PR_SET_CHILD_SUBREAPER = 36
_MARK = "RUNE_HUB_RUN"
"""Variable by which what modules have started is found, wherever it has gone."""
_OURS = secrets.token_hex(8)
_PATIENCE_S = 2.0
"""How long a process that was killed may take to end, and the guardian to do its work [s]."""


class OrphanReaper:
    """The process that ends the modules if this one dies without doing so.

    Nothing here raises or waits for it: modules run without a guardian as well, until there is
    one again.
    """

    def __init__(self) -> None:
        self._groups: set[int] = set()
        self._process: subprocess.Popen[bytes] | None = None
        self._start()

    @property
    def pid(self) -> int:
        """Its process id; 0 if it does not run."""
        return self._process.pid if self._process else 0

    def watch(self, group: int) -> None:
        """End this process group when we die."""
        self._groups.add(group)
        self._tell(f"{group}\n")

    def forget(self, group: int) -> None:
        """This process group has ended."""
        self._groups.discard(group)
        self._tell(f"-{group}\n")

    def look(self) -> None:
        """Start another one if it was ended."""
        if self._process is None or self._process.poll() is not None:
            self._replace()

    def close(self) -> None:
        """Have it end what is left, and end itself."""
        process = self._process
        if process is None:
            return
        if process.stdin is not None:
            process.stdin.close()
        try:
            process.wait(orphan_reaper.GRACE_S + _PATIENCE_S)
        except subprocess.TimeoutExpired:
            _logger.warning("the guardian of the modules hangs; it is killed")
            process.kill()
            process.wait()

    def _start(self) -> None:
        command = [sys.executable, "-I", "-S", orphan_reaper.__file__, f"{_MARK}={_OURS}"]
        try:
            process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                bufsize=0,
                start_new_session=True,
            )
        except OSError as error:
            _logger.warning("the guardian of the modules cannot be started: %s", error.strerror)
            return
        if process.stdin is not None:
            os.set_blocking(process.stdin.fileno(), False)
        self._process = process
        for group in self._groups:
            self._write(f"{group}\n")

    def _tell(self, line: str) -> None:
        if self._process is None or not self._write(line):
            self._replace()

    def _replace(self) -> None:
        _logger.warning("the guardian of the modules was ended; another is started")
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            if process.stdin is not None:
                process.stdin.close()
        self._start()

    def _write(self, text: str) -> bool:
        """Whether it can take this; one that is gone or hangs cannot."""
        if self._process is None or self._process.stdin is None:
            return False
        try:
            return self._process.stdin.write(text.encode()) == len(text)
        except OSError:
            return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Usage:
    """What a process has taken.

    Attributes:
        processor_s: Processor time since it started [s].
        memory_mb: Resident memory [MB].
    """

    processor_s: float
    memory_mb: float


class ModuleProcess:
    """A running module, in a process group of its own.

    The daemon keeps the other end of the process's standard input; when the daemon dies, however
    it dies, that pipe ends and the module stops by itself. What it writes to standard output and
    standard error comes out of `output`.
    """

    def __init__(self, spec: ModuleSpec, arguments: Sequence[str]) -> None:
        """Start it.

        Raises:
            ModuleStartError: The system cannot execute the command.
        """
        self.spec = spec
        try:
            output, theirs = os.pipe()
        except OSError as error:
            text = f"could not be started: {error.strerror}"
            raise ModuleStartError(text) from error
        try:
            self._process = subprocess.Popen(
                [*spec.command, *arguments],
                stdin=subprocess.PIPE,
                stdout=theirs,
                stderr=theirs,
                # Lines are wanted when they are written, not when a buffer is full.
                env=_environment(spec),
                # Its own group: Ctrl-C in the daemon's terminal is for the daemon alone, which
                # ends the modules in order.
                process_group=0,
            )
        except (OSError, ValueError) as error:
            os.close(output)
            reason = getattr(error, "strerror", None) or error
            text = f"could not be started: {spec.command[0]!r}: {reason}"
            raise ModuleStartError(text) from error
        finally:
            os.close(theirs)
        self.output = output
        if spec.nice:
            self._renice()

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def exit_code(self) -> int | None:
        """How it ended (negative: by that signal); None while it runs."""
        return self._process.poll()

    def usage(self) -> Usage | None:
        """What it takes; None where the system does not say."""
        try:
            words = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            return None
        return Usage(
            processor_s=(int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK"),
            memory_mb=int(words[21]) * os.sysconf("SC_PAGE_SIZE") / 1e6,
        )

    def ask_to_stop(self) -> None:
        """Ask it to stop; returns at once."""
        if self._process.poll() is None:
            self._process.terminate()

    def kill(self) -> None:
        """Kill it and what it has started; returns at once."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()  # it may have left its group

    def wait(self, seconds: float) -> bool:
        """Whether it ends within `seconds`."""
        try:
            self._process.wait(max(0.0, seconds))
        except subprocess.TimeoutExpired:
            return False
        return True

    def end(self) -> None:
        """Kill what still lives of it and of what it has started; returns when it is gone.

        A process that waits for a broken device cannot be killed; it is waited for a moment only.
        """
        self.kill()
        if not self.wait(_PATIENCE_S):
            _logger.warning("process %d was killed and does not end", self.pid)
        if self._process.stdin is not None:
            self._process.stdin.close()

    def _renice(self) -> None:
        try:
            os.setpriority(os.PRIO_PGRP, self.pid, self.spec.nice)
        except OSError as error:
            text = "module %s: its niceness cannot be changed by %d: %s"
            _logger.warning(text, self.spec.name, self.spec.nice, error.strerror)


def _environment(spec: ModuleSpec) -> dict[str, str]:
    """The daemon's own, without what systemd means for the daemon alone."""
    own = {k: v for k, v in os.environ.items() if k not in _OF_THE_DAEMON}
    return {"PYTHONUNBUFFERED": "1", **own, **dict(spec.environment), _MARK: _OURS}


def adopt_orphans() -> None:
    """Become the parent of processes whose own parent ends; Linux only."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def end_strays(known: Collection[int]) -> int:
    """Kill children that we did not start: what ended modules have left behind.

    Returns:
        How many there were.
    """
    try:
        found = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    except OSError:
        return 0
    killed = 0
    for pid in map(int, found):
        if pid in known:
            continue
        with contextlib.suppress(OSError):
            if os.waitpid(pid, os.WNOHANG) == (0, 0):  # else it has ended, by itself or by us
                os.kill(pid, signal.SIGKILL)
                killed += 1
    return killed
