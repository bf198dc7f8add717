"""Processes: starts a module, sees whether it runs and what it uses, and ends it."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import signal
import subprocess
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from hub.errors import ModuleStartError
from hub.robomon import orphan_reaper
from hub.robomon.child_environment import child_environment, mark
from hub.robomon.module_table import ModuleSpec
from hub.robomon.warm_parent import ChildProcess, WarmParent

_logger = logging.getLogger(__name__)

_PR_SET_CHILD_SUBREAPER = 36
_PATIENCE_S = 2.0
"""Longest wait for a killed process to end, and for the reaper to do its work [s]."""


class OrphanReaper:
    """Starts the process that ends the modules if the daemon dies, and informs it.

    No method raises, and none but `close` waits. While there is no reaper, modules run without it;
    `look` starts another.
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
        """Have it end this process group when the daemon dies."""
        self._groups.add(group)
        self._send(f"{group}\n")

    def forget(self, group: int) -> None:
        """This process group has ended."""
        self._groups.discard(group)
        self._send(f"-{group}\n")

    def look(self) -> None:
        """Start another one if it was ended."""
        if self._process is None or self._process.poll() is not None:
            self._replace()

    def close(self) -> None:
        """Have it end what is left; it then ends itself."""
        process = self._process
        if process is None:
            return
        if process.stdin is not None:
            process.stdin.close()
        try:
            process.wait(orphan_reaper.GRACE_S + _PATIENCE_S)
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
        """Whether it has taken this text; one that has ended or hangs has not."""
        if self._process is None or self._process.stdin is None:
            return False
        try:
            return self._process.stdin.write(text.encode()) == len(text)
        except OSError:
            return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Usage:
    """What a process has used.

    Attributes:
        processor_s: Processor time since it started [s].
        memory_mb: Resident memory [MB].
    """

    processor_s: float
    memory_mb: float


class ModuleProcess:
    """A running module, in a process group of its own.

    The daemon keeps the other end of the process's standard input. When the daemon dies, however
    it dies, that pipe ends and the module stops by itself. What it writes to standard output and
    standard error comes out of `output`.
    """

    def __init__(
        self, spec: ModuleSpec, arguments: Sequence[str], parent: WarmParent | None = None
    ) -> None:
        """Start it: forked from the parent where that can do it, else spawned.

        Raises:
            ModuleStartError: The system cannot execute the command.
        """
        self.spec = spec
        with contextlib.ExitStack() as opened, contextlib.ExitStack() as theirs:
            try:
                stdin, self._stdin = os.pipe()
                theirs.callback(os.close, stdin)
                opened.callback(os.close, self._stdin)
                self.output, output = os.pipe()
                theirs.callback(os.close, output)
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
                os.write(self._stdin, b"\n")  # it waits for this
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
                # Its own group: Ctrl-C in the daemon's terminal is for the daemon alone, which
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
        """How it ended (negative: by that signal); None while it runs."""
        return self._process.poll()

    def usage(self) -> Usage | None:
        """What it uses; None where the system does not say."""
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
        """Kill what runs of it and of what it has started; returns when it has ended.

        A process that waits for a broken device does not end at SIGKILL; then this returns soon.
        """
        self.kill()
        if not self.wait(_PATIENCE_S):
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
    """Become the parent of processes whose own parent ends; False where there is no such thing."""
    try:
        return bool(ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) == 0)
    except (OSError, AttributeError):
        return False


def end_strays(known: Collection[int]) -> int:
    """Kill children that are not known: what ended modules have left behind.

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
