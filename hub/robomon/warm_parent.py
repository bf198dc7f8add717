"""The daemon's side of the warmed parent: it forks Python modules that start at once.

| state | event | action |
|---|---|---|
| none | the daemon starts | fork it from the daemon, which has one thread and no socket yet |
| none | a module starts | the caller spawns the module |
| none | `restart_if_ended`, after the pause | spawn it |
| loading | it reports that it is ready | ready |
| loading | a module starts | the caller spawns the module |
| ready | a module starts | fork the module |
| ready | no answer in time, or a wrong one | kill it: none |
| any | it ends | none; the next pause is twice as long |
| any | its imports have started threads | never again: every module is spawned |
"""

from __future__ import annotations

import contextlib
import logging
import os
import resource
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol

from hub.robomon import fork_server
from hub.robomon.child_environment import child_environment, mark
from hub.robomon.fork_server import PID, SEVERAL_THREADS, ForkRequest
from hub.robomon.module_table import ModuleSpec

_logger = logging.getLogger(__name__)

_ANSWER_S = 2.0
"""Longest wait of the daemon for a fork [s]."""
_POLL_S = 0.1
"""Period of the check whether a silent parent is stopped [s]."""
_PAUSE_S = 0.5
_LONGEST_PAUSE_S = 60.0
_KILLED_S = 2.0
_AT_START = ("PYTHON", "LD_", "LC_", "LANG", "MALLOC_", "GLIBC_", "OPENBLAS_", "OMP_", "MKL_")
"""Prefixes of variables that only work at the start of a program, not after a fork."""


class ChildProcess(Protocol):
    """A child of the daemon: the part of `subprocess.Popen` that the daemon uses."""

    @property
    def pid(self) -> int:
        """Its process id."""

    def poll(self) -> int | None:
        """Its exit code (negative: a signal); None: it runs."""

    def wait(self, timeout: float | None = None) -> int:
        """Its exit code; raises `subprocess.TimeoutExpired` after `timeout` [s]."""

    def terminate(self) -> None:
        """Send it SIGTERM."""

    def kill(self) -> None:
        """Send it SIGKILL."""


class ForkedProcess:
    """A child of this process that `subprocess` did not start."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self._code: int | None = None

    def poll(self) -> int | None:
        """Its exit code (negative: a signal); None: it runs."""
        return self._wait(os.WNOHANG)

    def wait(self, timeout: float | None = None) -> int:
        """Its exit code.

        Raises:
            subprocess.TimeoutExpired: It runs after `timeout` [s].
        """
        if timeout is not None and self.poll() is None:
            file = os.pidfd_open(self.pid)
            try:
                select.select([file], [], [], timeout)
            finally:
                os.close(file)
            if self.poll() is None:
                raise subprocess.TimeoutExpired(str(self.pid), timeout)
        code = self._wait(0)
        return 0 if code is None else code

    def terminate(self) -> None:
        """Send it SIGTERM."""
        self._send(signal.SIGTERM)

    def kill(self) -> None:
        """Send it SIGKILL."""
        self._send(signal.SIGKILL)

    def _send(self, number: signal.Signals) -> None:
        if self.poll() is None:  # else another process may have the number
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def _wait(self, options: int) -> int | None:
        if self._code is None:
            try:
                pid, status = os.waitpid(self.pid, options)
            except ChildProcessError:  # SIGCHLD is ignored: the system keeps no exit code
                self._code = 0
            else:
                self._code = os.waitstatus_to_exitcode(status) if pid else None
        return self._code


class WarmParent:
    """Forks modules; no method waits for long, and none raises."""

    def __init__(self, imports: Sequence[str], clock: Callable[[], float] = time.monotonic) -> None:
        """Start without a parent.

        Args:
            imports: The Python modules that the parent imports.
            clock: Monotonic time [s].
        """
        self._imports = tuple(imports)
        self._clock = clock
        self._process: ChildProcess | None = None
        self._link: socket.socket | None = None
        self._ready = False
        self._unfit = False
        self._pause = _PAUSE_S
        self._start_at = 0.0

    @property
    def pid(self) -> int:
        """The parent's process id; 0: there is none."""
        return self._process.pid if self._process else 0

    @property
    def ready(self) -> bool:
        """Whether modules can be forked now."""
        if self._link is not None and not self._ready:
            readable, _, _ = select.select([self._link], [], [], 0.0)
            self._ready = bool(readable) and self._answer(self._link) == self.pid
        return self._ready

    def fork_from_here(self) -> None:
        """Import the shared modules into this process, and fork the parent from it.

        Raises:
            SystemExit: In a forked module, at its end.
        """
        fork_server.preload(self._imports)
        if not fork_server.has_one_thread():
            self._give_up()
            return
        daemon_end, parent_end = socket.socketpair()
        try:
            pid = os.fork()
        except OSError as error:
            _logger.warning("the warmed parent cannot be forked: %s", error.strerror)
            daemon_end.close()
            parent_end.close()
            return
        if pid == 0:
            daemon_end.close()
            fork_server.serve(parent_end, mark())
        parent_end.close()
        self._process, self._link, self._ready = ForkedProcess(pid), daemon_end, True

    def start(
        self,
        spec: ModuleSpec,
        arguments: Sequence[str],
        files: tuple[int, int],
    ) -> ForkedProcess | None:
        """Fork a module; it runs after a byte on its standard input.

        Args:
            spec: The module.
            arguments: Added to its command.
            files: Its standard input, and the pipe for its output.

        Returns:
            The module's process; None: the caller has to spawn it.
        """
        if not _can_be_forked(spec) or not self.ready or self._link is None:
            return None
        request = ForkRequest(
            run=spec.python_module,
            arguments=tuple(arguments),
            environment=child_environment(dict(spec.environment)),
            limits=_limits(),
        ).to_bytes()
        pid = 0
        try:
            self._link.settimeout(_ANSWER_S)
            sent = socket.send_fds(self._link, [request], files)
            self._link.sendall(request[sent:])
            if self._wait_for_answer(self._link):
                pid = self._answer(self._link)
        except OSError as error:
            _logger.warning("the warmed parent does not answer: %s", error)
        if pid <= 0 or not _is_child(pid):
            self._drop("cannot fork a module")
            return None
        return ForkedProcess(pid)

    def restart_if_ended(self) -> None:
        """Start another parent if this one has ended."""
        if self._process is not None:
            code = self._process.poll()
            if code is None:
                if not self._ready and self.ready:
                    _logger.info("modules are forked again: another one is ready")
                return
            if code == SEVERAL_THREADS:
                self._give_up()
            self._drop("has ended")
        if not self._unfit and self._clock() >= self._start_at:
            self._spawn()

    def close(self) -> None:
        """End the parent; its forked modules go on."""
        process, self._process = self._process, None
        if self._link is not None:
            self._link.close()
            self._link = None
        self._ready = False
        if process is None:
            return
        process.kill()
        try:
            process.wait(_KILLED_S)
        except subprocess.TimeoutExpired:
            _logger.warning("process %d was killed and does not end", process.pid)

    def _wait_for_answer(self, link: socket.socket) -> bool:
        """Whether an answer arrives in time; a stopped parent never answers."""
        end = self._clock() + _ANSWER_S
        while self._clock() < end and not _is_stopped(self.pid):
            if select.select([link], [], [], _POLL_S)[0]:
                return True
        return False

    def _answer(self, link: socket.socket) -> int:
        """The number from the parent; 0: it sent none, or is gone."""
        try:
            answer = link.recv(PID.size)
        except OSError:
            return 0
        return int(PID.unpack(answer)[0]) if len(answer) == PID.size else 0

    def _drop(self, why: str) -> None:
        _logger.warning("the warmed parent %s; modules are spawned until there is another", why)
        self.close()
        self._start_at = self._clock() + self._pause
        self._pause = min(2.0 * self._pause, _LONGEST_PAUSE_S)

    def _give_up(self) -> None:
        _logger.warning("there is no warmed parent, as imports start threads; modules are spawned")
        self._unfit = True

    def _spawn(self) -> None:
        daemon_end, parent_end = socket.socketpair()
        command = [sys.executable, "-m", fork_server.__name__, str(parent_end.fileno()), mark()]
        try:
            process = subprocess.Popen(
                [*command, *self._imports],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                env=child_environment({}),
                pass_fds=(parent_end.fileno(),),
                process_group=0,
            )
        except OSError as error:
            _logger.warning("the warmed parent cannot be started: %s", error.strerror)
            daemon_end.close()
            self._drop("is not there")
            return
        finally:
            parent_end.close()
        self._process, self._link = process, daemon_end


def _can_be_forked(spec: ModuleSpec) -> bool:
    at_start = any(name.startswith(_AT_START) for name, _ in spec.environment)
    return bool(spec.python_module) and not at_start


def _limits() -> tuple[tuple[int, int, int], ...]:
    """This process's resource limits, as a spawned module would inherit them."""
    numbers = {getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")}
    return tuple((number, *resource.getrlimit(number)) for number in sorted(numbers))


def _is_stopped(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return True
    return state in "TtZX"


def _is_child(pid: int) -> bool:
    """Whether this process has adopted the module; another module ends by itself."""
    try:
        os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True
