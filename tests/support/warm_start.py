"""Starts `rune` and `rune-hub` for tests as forks of a process that has imported both.

Such a process has its own session, terminal, descriptors, environment and exit code, as a spawned
one has. It only saves the start of an interpreter, the imports, and to take the interpreter apart,
most of what a test of real processes costs. Tests of the start and the end themselves spawn.

A server has one thread and is nobody's child. There is one for each set of preloaded libraries and
what else in `_SERVED` counts when an interpreter starts. A request is one packet: its text in JSON,
and the descriptors 0, 1 and 2. Answers are packets too: `{"pid"}` to a request,
`{"ended", "status"}` at the end of a process.
"""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import tempfile
import termios
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Final, NoReturn

from hub.robomon.fork_server import preload, show_command
from tests.support.waiting import Limit

_MODULES: Final = ("driver", "navigation", "vision", "mapping", "autonomy")
_IMPORTS: Final = (
    "rune_tui.app",
    "rune_tui.commands.demo",
    "rune_tui.commands.joytest",
    "rune_tui.commands.pad",
    "rune_tui.startup.opening",
    "hub.cli",
    "hub.robomon.daemon",
    "hub.inspection.message_commands",
    "hub.inspection.module_commands",
    *(f"hub.modules.{name}.__main__" for name in _MODULES),
    "hub.robots.simulated_camera",
    "rune_tui.cli",
    "rune_tui.ui.sturdy_driver",
    "textual.layouts.horizontal",
    "textual.scrollbar",
)
_PACKET_BYTES: Final = 1 << 18
_AT_START: Final = (
    *("PYTHON", "LD_", "LC_", "LANG", "MALLOC_", "OPENBLAS_", "TEXTUAL"),
    "RUNE_WALL_CLOCK",  # a preloaded library reads it
)
"""Variables with these beginnings count when an interpreter starts, and not after a fork."""
_SERVED: Final = ("LD_PRELOAD", "RUNE_WALL_CLOCK", "PYTHONPATH")
"""Those of them with which many processes start, so that a server of their own pays."""
_ANSWER_S: Final = 60.0
_PROGRAMS: Final = (
    "hub",
    "rune_tui",
    "tests.misbehaving.marking_console",
    "tests.soak.central_process",
    "tests.soak.module_process",
)
_usual: frozenset[tuple[str, str]] | None = None
"""Those of this process when `use` was called."""


class WarmProcess:
    """A forked process: the part of `subprocess.Popen` that tests use.

    Attributes:
        pid: Its process id.
        stdin: The pipe to its standard input, if one was asked for.
        stdout: The pipe from its standard output, likewise.
    """

    def __init__(
        self, pid: int, server: _Server, stdin: IO[bytes] | None, stdout: IO[bytes] | None
    ) -> None:
        self.pid = pid
        self.stdin = stdin
        self.stdout = stdout
        self._server = server

    @property
    def returncode(self) -> int | None:
        """How it ended (negative: by that signal), as far as it was looked at."""
        return self._server.ended.get(self.pid)

    def poll(self) -> int | None:
        """How it ended; None while it runs."""
        self._server.listen(0.0)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """How it ended.

        Raises:
            subprocess.TimeoutExpired: It runs after `timeout` [s].
        """
        limit = Limit(_ANSWER_S if timeout is None else timeout)
        while self.poll() is None:
            if limit.over:
                raise subprocess.TimeoutExpired(str(self.pid), timeout or _ANSWER_S)
            self._server.listen(0.5)
        code = self.returncode
        assert code is not None
        return code

    def send_signal(self, number: int) -> None:
        """Send it a signal, unless it has ended."""
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def terminate(self) -> None:
        """Send it SIGTERM."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """Send it SIGKILL."""
        self.send_signal(signal.SIGKILL)


Process = WarmProcess | subprocess.Popen[bytes]


class _Server:
    """A server of this process's tests, as they see it."""

    def __init__(self, at_start: frozenset[tuple[str, str]]) -> None:
        self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._lock = threading.RLock()
        self._answers: list[int] = []
        self.started: set[int] = set()
        self.ended: dict[int, int] = {}
        # `ps` shows at most as many letters of a forked process's command.
        command = [sys.executable, "-m", __name__, str(theirs.fileno()), "-" * 200]
        own = dict({*os.environ.items()} - _at_start(os.environ) | at_start)
        subprocess.run(command, pass_fds=(theirs.fileno(),), env=own, check=True)
        theirs.close()
        atexit.register(self._link.close)

    def fork(self, request: Mapping[str, Any], files: Sequence[int]) -> int:
        """Fork a process with these descriptors as 0, 1 and 2; returns its process id."""
        with self._lock:
            socket.send_fds(self._link, [json.dumps(request).encode()], files)
            while not self._answers:
                assert self.listen(_ANSWER_S), "the server of warm starts does not answer"
            return self._answers.pop()

    def listen(self, timeout: float) -> bool:
        """Take what the server says until it says nothing for so long [s]; whether it did."""
        with self._lock:
            said = False
            while select.select([self._link], [], [], 0.0 if said else timeout)[0]:
                answer = json.loads(self._link.recv(_PACKET_BYTES))
                if "pid" in answer:
                    pid = answer["pid"]
                    self.ended.pop(pid, None)
                    self.started.add(pid)
                    self._answers.append(pid)
                else:
                    self.ended[answer["ended"]] = answer["status"]
                    self.started.discard(answer["ended"])
                said = True
            return said


_servers: dict[frozenset[tuple[str, str]], _Server] = {}


def _server_for(environment: Mapping[str, str]) -> _Server:
    at_start = _at_start(environment)
    if at_start not in _servers:
        _servers[at_start] = _Server(at_start)
    return _servers[at_start]


def _at_start(
    environment: Mapping[str, str], but: Sequence[str] = ()
) -> frozenset[tuple[str, str]]:
    return frozenset(
        (name, value)
        for name, value in environment.items()
        if name.startswith(_AT_START) and name not in but
    )


def use() -> None:
    """Fork from now on what can be forked."""
    global _usual  # noqa: PLW0603 - once for a process of tests
    _usual = _at_start(os.environ, but=_SERVED)


def running() -> set[int]:
    """Process ids of what was started and has not ended."""
    for server in _servers.values():
        server.listen(0.0)
    return {pid for server in _servers.values() for pid in server.started}


def start(
    command: Sequence[str],
    *,
    environment: Mapping[str, str],
    stdin: int = subprocess.DEVNULL,
    stdout: int = subprocess.DEVNULL,
    stderr: int = subprocess.DEVNULL,
    folder: Path | None = None,
    terminal: bool = False,
) -> Process:
    """Start a command: forked if that is the same as spawned and `use` was called.

    Args:
        command: With its arguments.
        environment: All of its environment.
        stdin: Descriptor, `subprocess.PIPE` or `subprocess.DEVNULL`.
        stdout: Likewise.
        stderr: Descriptor or `subprocess.DEVNULL`.
        folder: Where it runs; None: here.
        terminal: Whether it leads a session, with its standard input as the terminal.
    """
    ours = tuple(command[:2]) == (sys.executable, "-m") and command[2] in _PROGRAMS
    if ours and _at_start(environment, but=_SERVED) == _usual:
        files = (stdin, stdout, stderr)
        place = folder or Path.cwd()
        return _forked(command, environment, files, folder=place, terminal=terminal)
    return subprocess.Popen(
        command,
        stdin=stdin,
        stdout=stdout,
        stderr=stderr,
        env=environment,
        cwd=folder,
        start_new_session=terminal,
        # The terminal has to be its own, so that closing it hangs up.
        preexec_fn=_take_terminal if terminal else None,  # noqa: PLW1509
    )


def run(
    command: Sequence[str],
    *,
    environment: Mapping[str, str] | None = None,
    folder: Path | None = None,
    timeout: float = 30.0,
) -> subprocess.CompletedProcess[str]:
    """Start a command with nothing on its standard input, and wait for its end.

    Args:
        command: With its arguments.
        environment: All of its environment; None: that of this process.
        folder: Where it runs; None: here.
        timeout: It ends within this time [s].
    """
    with tempfile.TemporaryFile("w+") as said, tempfile.TemporaryFile("w+") as complained:
        process = start(
            command,
            environment=os.environ if environment is None else environment,
            stdout=said.fileno(),
            stderr=complained.fileno(),
            folder=folder,
        )
        try:
            code = process.wait(timeout)
        except BaseException:
            process.kill()
            process.wait()
            raise
        said.seek(0)
        complained.seek(0)
        return subprocess.CompletedProcess(command, code, said.read(), complained.read())


def _take_terminal() -> None:
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def _forked(
    command: Sequence[str],
    environment: Mapping[str, str],
    files: tuple[int, int, int],
    *,
    folder: Path,
    terminal: bool,
) -> WarmProcess:
    theirs, closing = list(files), []
    pipes: list[IO[bytes] | None] = [None, None]
    for number, mode in ((0, "wb"), (1, "rb")):
        if theirs[number] == subprocess.PIPE:
            reading, writing = os.pipe()
            theirs[number], kept = (reading, writing) if number == 0 else (writing, reading)
            pipes[number] = os.fdopen(kept, mode)
            closing.append(theirs[number])
    for number, file in enumerate(theirs):
        if file == subprocess.DEVNULL:
            theirs[number] = os.open(os.devnull, os.O_RDWR)
            closing.append(theirs[number])
    request = {
        "command": list(command),
        "environment": dict(environment),
        "folder": str(folder),
        "terminal": terminal,
    }
    try:
        server = _server_for(environment)
        pid = server.fork(request, theirs)
    finally:
        for file in closing:
            os.close(file)
    return WarmProcess(pid, server, *pipes)


def _serve(link: socket.socket) -> None:
    """Fork a process for each request; returns in the new processes only."""
    reading, writing = os.pipe()
    os.set_blocking(reading, False)
    os.set_blocking(writing, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    while True:
        ready, _, _ = select.select([link, reading], [], [])
        if reading in ready:
            os.read(reading, _PACKET_BYTES)
            _report_ended(link)
        if link in ready:
            text, files, _, _ = socket.recv_fds(link, _PACKET_BYTES, 3)
            if not text:
                os._exit(0)
            pid = os.fork()
            if pid == 0:
                signal.set_wakeup_fd(-1)
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                for file in (reading, writing):
                    os.close(file)
                link.close()
                _be_program(json.loads(text), files)
            for file in files:
                os.close(file)
            _say(link, {"pid": pid})


def _report_ended(link: socket.socket) -> None:
    with contextlib.suppress(ChildProcessError):
        while True:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if not pid:
                return
            _say(link, {"ended": pid, "status": os.waitstatus_to_exitcode(status)})


def _say(link: socket.socket, answer: Mapping[str, int]) -> None:
    with contextlib.suppress(OSError):  # the next look at the link finds its end
        link.send(json.dumps(answer).encode())


def _be_program(request: Mapping[str, Any], files: Sequence[int]) -> NoReturn:
    if request["terminal"]:
        os.setsid()
    for number, file in enumerate(files):
        os.dup2(file, number)
    for file in set(files) - {0, 1, 2}:
        os.close(file)
    if request["terminal"]:
        _take_terminal()
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    time.tzset()
    # As a new interpreter opens them.
    sys.stdin = open(0, closefd=False)  # noqa: SIM115 - a descriptor
    sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, errors="backslashreplace", closefd=False)  # noqa: SIM115
    sys.orig_argv = request["command"]
    _, _, module, *arguments = request["command"]
    sys.argv = ["-m", *arguments]
    show_command(request["command"])
    code: object = 0
    try:
        runpy.run_module(module, run_name="__main__", alter_sys=True)
    except SystemExit as end:
        code = end.code
    except BaseException:  # noqa: BLE001 - as a new interpreter does
        sys.excepthook(*sys.exc_info())
        code = 1
    _end(code)


def _end(code: object) -> NoReturn:
    """Do what an interpreter does at its end, but do not take it apart: that costs most."""
    if code is not None and not isinstance(code, int):
        sys.stderr.write(f"{code}\n")
        code = 1
    # As forks of multiprocessing do.
    threading._shutdown()  # type: ignore[attr-defined]  # noqa: SLF001
    atexit._run_exitfuncs()  # noqa: SLF001
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):  # closed, or none
            stream.flush()
    os._exit(code or 0)


def _main() -> None:
    link = socket.socket(fileno=int(sys.argv[1]))
    if os.fork():
        os._exit(0)
    link.set_inheritable(False)
    preload(_IMPORTS)
    _serve(link)


if __name__ == "__main__":
    _main()
