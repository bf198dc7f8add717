"""Processes: starts a module, watches its end and its usage, and ends it."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import signal
import subprocess
import sys
from collections.abc import Collection, Sequence
from pathlib import Path

from hub.errors import ModuleStartError
from hub.robomon import orphan_reaper
from hub.robomon.child_environment import child_environment, mark
from hub.robomon.module_table import ModuleSpec
from hub.robomon.warm_parent import ChildProcess, WarmParent
from hub.values import dataclass

_logger = logging.getLogger(__name__)

_PR_SET_CHILD_SUBREAPER = 36
END_TIMEOUT_S = 2.0
"""Longest wait for the end of a killed process, and for the reaper's work [s]."""


class OrphanReaper:
    """Starts the reaper, which ends the modules if the daemon dies, and informs it.

    No method raises, and only `close` waits. Modules run even without a reaper;
    `restart_if_ended` starts another.
    """

    def __init__(self) -> None:
        self._groups: set[int] = set()
        self._process: subprocess.Popen[bytes] | None = None
        self._start()

    @property
    def pid(self) -> int:
        """Its process id; 0: it does not run."""
        return self._process.pid if self._process else 0

    def watch(self, group: int) -> None:
        """Add a process group to end when the daemon dies."""
        self._groups.add(group)
        self._send(f"{group}\n")

    def forget(self, group: int) -> None:
        """Remove a process group that has ended."""
        self._groups.discard(group)
        self._send(f"-{group}\n")

    def restart_if_ended(self) -> None:
        """Start another one if it has ended."""
        if self._process is None or self._process.poll() is not None:
            self._replace()

    def close(self) -> None:
        """Let it end the rest; then it ends itself."""
        process = self._process
        if process is None:
            return
        if process.stdin is not None:
            process.stdin.close()
        try:
            process.wait(orphan_reaper.STOP_TIME_S + END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            _logger.warning("the orphan reaper hangs; it is killed")
            process.kill()
            process.wait()

    def _start(self) -> None:
        command = [sys.executable, "-I", "-S", orphan_reaper.__file__, mark()]
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
            _logger.warning("the orphan reaper cannot be started: %s", error.strerror)
            return
        if process.stdin is not None:
            os.set_blocking(process.stdin.fileno(), False)
        self._process = process
        for group in self._groups:
            self._write(f"{group}\n")

    def _send(self, line: str) -> None:
        if self._process is None or not self._write(line):
            self._replace()

    def _replace(self) -> None:
        _logger.warning("the orphan reaper has ended; another is started")
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            if process.stdin is not None:
                process.stdin.close()
        self._start()

    def _write(self, text: str) -> bool:
        """Write to it; False: it has ended, or hangs."""
        if self._process is None or self._process.stdin is None:
            return False
        try:
            return self._process.stdin.write(text.encode()) == len(text)
        except OSError:
            return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Usage:
    """Usage of a process.

    Attributes:
        processor_s: Processor time since its start [s].
        memory_mb: Resident memory [MB].
    """

    processor_s: float
    memory_mb: float


class ModuleProcess:
    """A running module, in a process group of its own.

    The daemon keeps the other end of the process's standard input. When the daemon dies, that pipe
    ends and the module stops by itself. `output` reads its standard output and standard error.
    """

    def __init__(
        self, spec: ModuleSpec, arguments: Sequence[str], parent: WarmParent | None = None
    ) -> None:
        """Start it: fork it from the parent if possible, else spawn it.

        Raises:
            ModuleStartError: The system cannot execute the command.
        """
        self.spec = spec
        with contextlib.ExitStack() as opened, contextlib.ExitStack() as module_ends:
            try:
                stdin, self._stdin = os.pipe()
                module_ends.callback(os.close, stdin)
                opened.callback(os.close, self._stdin)
                self.output, output = os.pipe()
                module_ends.callback(os.close, output)
                opened.callback(os.close, self.output)
            except OSError as error:
                text = f"could not be started: {error.strerror}"
                raise ModuleStartError(text) from error
            self._process = self._start(arguments, (stdin, output), parent)
            opened.pop_all()

    def _start(
        self, arguments: Sequence[str], files: tuple[int, int], parent: WarmParent | None
    ) -> ChildProcess:
        forked = parent and parent.start(self.spec, arguments, files)
        process = forked or self._spawn(arguments, files)
        if self.spec.nice:
            self._renice(process.pid)
        if forked:
            with contextlib.suppress(BrokenPipeError):  # it has ended already
                os.write(self._stdin, b"\n")  # it waits for this byte
        return process

    def _spawn(self, arguments: Sequence[str], files: tuple[int, int]) -> ChildProcess:
        stdin, output = files
        try:
            return subprocess.Popen(
                [*self.spec.command, *arguments],
                stdin=stdin,
                stdout=output,
                stderr=output,
                env=child_environment(dict(self.spec.environment)),
                # Its own group: Ctrl-C in the daemon's terminal reaches only the daemon, which
                # ends the modules in order.
                process_group=0,
            )
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            text = f"could not be started: {self.spec.command[0]!r}: {reason}"
            raise ModuleStartError(text) from error

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def exit_code(self) -> int | None:
        """Its exit code (negative: a signal); None: it runs."""
        return self._process.poll()

    def usage(self) -> Usage | None:
        """Its usage; None: the system does not report it."""
        try:
            words = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            return None
        return Usage(
            processor_s=(int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK"),
            memory_mb=int(words[21]) * os.sysconf("SC_PAGE_SIZE") / 1e6,
        )

    def ask_to_stop(self) -> None:
        """Send it SIGTERM; returns at once."""
        if self._process.poll() is None:
            self._process.terminate()

    def kill(self) -> None:
        """Kill it and its descendants; returns at once."""
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
        """Kill it and its descendants; returns after its end.

        A process that waits for a broken device ignores SIGKILL; then this returns soon.
        """
        self.kill()
        if not self.wait(END_TIMEOUT_S):
            _logger.warning("process %d was killed and does not end", self.pid)
        if self._stdin >= 0:
            os.close(self._stdin)
            self._stdin = -1

    def _renice(self, pid: int) -> None:
        try:
            os.setpriority(os.PRIO_PGRP, pid, self.spec.nice)
        except OSError as error:
            text = "module %s: its niceness cannot be changed by %d: %s"
            _logger.warning(text, self.spec.name, self.spec.nice, error.strerror)


def adopt_orphans() -> bool:
    """Become the parent of processes whose parent ends; False: the system cannot."""
    try:
        return bool(ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) == 0)
    except (OSError, AttributeError):
        return False


def kill_leftovers(known: Collection[int]) -> int:
    """Kill unknown children: ended modules have left them.

    Returns:
        Their number.
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
            if os.waitpid(pid, os.WNOHANG) == (0, 0):  # else it has ended already
                os.kill(pid, signal.SIGKILL)
                killed += 1
    return killed
