"""The warmed parent's own process: it forks a module for each request of the daemon.

It has loaded the modules' imports. It has one thread, one socket to the daemon, and no module as a
child. It forks twice, the process between ends at once, and the daemon adopts the module. So the
daemon waits for modules itself, and the death of this process does not harm them.

A request is its length, its text, and two descriptors: the module's standard input, and the pipe
for its standard output and standard error. The answer is the module's process id; 0: the fork
failed. The module runs after the daemon has written one byte to its standard input.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import gc
import importlib
import io
import json
import os
import resource
import runpy
import socket
import struct
import sys
import time
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import NoReturn

from hub.values import Making, dataclass

LENGTH = struct.Struct("!I")
PID = struct.Struct("!i")
SEVERAL_THREADS = 3
"""Exit code of a parent whose imports have started threads: it cannot fork."""
_FILES = 2
_PR_SET_NAME = 15
_NAME_BYTES = 15
_PAGE = 4096
_MAP_PRIVATE = 2
_ARGUMENTS_FROM, _ARGUMENTS_TO = 45, 46
"""Places of the command's addresses in `stat` of proc(5), counted after the name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForkRequest:
    """A module to fork.

    Attributes:
        run: The Python module to run, like after `python -m`.
        arguments: Its command line.
        environment: Its whole environment.
        limits: Its resource limits: number, soft limit, hard limit.
    """

    run: str
    arguments: tuple[str, ...]
    environment: Mapping[str, str]
    limits: tuple[tuple[int, int, int], ...] = ()

    def to_bytes(self) -> bytes:
        """The request as it is sent."""
        text = json.dumps(asdict(self)).encode()
        return LENGTH.pack(len(text)) + text

    @classmethod
    def from_bytes(cls, text: bytes) -> ForkRequest:
        """The request that was sent, without its length."""
        return cls(**json.loads(text))


def preload(imports: Iterable[str]) -> None:
    """Import these Python modules, and keep them out of garbage collection.

    What modules would make at first use is made here, once for all of them.
    """
    gc.disable()
    Making.at_once = True
    for name in imports:
        with contextlib.suppress(ImportError):  # the module that needs it reports the error
            importlib.import_module(name)
        if name.endswith(".__main__"):
            sys.modules.pop(name, None)  # each process runs its own
    from hub.gcm.catalog import MESSAGES
    from hub.ipc.wire import control_codec

    for definition in (*MESSAGES, *control_codec.KINDS):
        definition.prepare()
    gc.freeze()  # a collection would write to shared pages
    gc.enable()


def has_one_thread() -> bool:
    """Whether this process can be forked: a fork keeps the calling thread only."""
    return len(list(Path("/proc/self/task").iterdir())) == 1


def serve(link: socket.socket, mark: str) -> NoReturn:
    """Fork modules until the daemon closes the link.

    Raises:
        SystemExit: In a forked module, at its end.
    """
    link = _prepare(link)
    _map_mark(mark)
    pid: int | None = 0
    while pid is not None:
        received = _receive(link)
        if received is None:
            os._exit(0)
        request, files = received
        pid = _fork()
        if pid is not None:
            for file in files:
                os.close(file)
            with contextlib.suppress(BrokenPipeError):  # the next read of the link finds its end
                link.sendall(PID.pack(pid))
    link.detach()
    _be_module(request, *files)


def _prepare(link: socket.socket) -> socket.socket:
    """Close the daemon's files but the link and standard error; lead a process group."""
    with contextlib.suppress(PermissionError):  # it leads one already
        os.setpgid(0, 0)  # Ctrl-C in the daemon's terminal is for the daemon alone
    kept = fcntl.fcntl(link, fcntl.F_DUPFD_CLOEXEC, 3)
    null = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2) if sys.stderr is None else (0, 1):
        os.dup2(null, number)
    _close_all_but(0, 1, 2, kept)
    link.detach()
    return socket.socket(fileno=kept)


def _close_all_but(*kept: int) -> None:
    for name in os.listdir("/proc/self/fd"):  # noqa: PTH208 - numbers, not paths
        if int(name) not in kept:
            with contextlib.suppress(OSError):  # the descriptor of the listed folder itself
                os.close(int(name))


def _map_mark(mark: str) -> None:
    """Map a page of an anonymous file with the mark as its name; forked processes keep it.

    The mark in the environment shows in /proc after an exec only.
    """
    file = os.memfd_create(mark)
    try:
        library = ctypes.CDLL(None)
        library.mmap.restype = ctypes.c_void_p
        library.mmap.argtypes = (
            ctypes.c_void_p,
            ctypes.c_size_t,
            ctypes.c_int,
            ctypes.c_int,
            ctypes.c_int,
            ctypes.c_long,
        )
        library.mmap(None, _PAGE, 0, _MAP_PRIVATE, file, 0)
    finally:
        os.close(file)


def _receive(link: socket.socket) -> tuple[ForkRequest, list[int]] | None:
    """The next request with its descriptors; None: the daemon has closed the link."""
    text = b""
    try:
        start, files, _, _ = socket.recv_fds(link, LENGTH.size, _FILES)
        if not start:
            return None
        missing = LENGTH.unpack(start)[0]
        while len(text) < missing:
            chunk = link.recv(missing - len(text))
            if not chunk:
                return None
            text += chunk
    except ConnectionResetError:
        return None
    return ForkRequest.from_bytes(text), files


def _fork() -> int | None:
    """Fork a process that the daemon adopts.

    Returns:
        Its process id; 0: the system refuses; None: this is the new process.
    """
    try:
        reading, writing = os.pipe()
    except OSError:
        return 0
    try:
        between = os.fork()
    except OSError:
        os.close(reading)
        os.close(writing)
        return 0
    if between == 0:
        _fork_again(writing)
        return None
    os.close(writing)
    with contextlib.suppress(ChildProcessError):  # the system keeps no exit codes
        os.waitpid(between, 0)  # from here on the daemon is the new process's parent
    answer = os.read(reading, PID.size)
    os.close(reading)
    return int(PID.unpack(answer)[0]) if answer else 0


def _fork_again(writing: int) -> None:
    """Fork in the process between, send the process id, and end; returns in the new process."""
    try:
        pid = os.fork()
    except OSError:
        os._exit(1)
    if pid == 0:
        return
    with contextlib.suppress(OSError):  # the module has done it, or has ended
        os.setpgid(pid, pid)
    os.write(writing, PID.pack(pid))
    os._exit(0)


def _be_module(request: ForkRequest, stdin: int, output: int) -> NoReturn:
    """Run the module like `python -m`, without the parent's state."""
    os.setpgid(0, 0)
    os.dup2(stdin, 0)
    os.dup2(output, 1)
    os.dup2(output, 2)
    _close_all_but(0, 1, 2)
    for number, soft, hard in request.limits:
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(number, (soft, hard))
    os.environ.clear()
    os.environ.update(request.environment)
    time.tzset()
    _renew_streams()
    _renew_random_numbers()
    _set_command(request)
    if not os.read(0, 1):
        os._exit(0)  # the daemon has not adopted this process
    try:
        runpy.run_module(request.run, run_name="__main__", alter_sys=True)
    except (Exception, KeyboardInterrupt):  # noqa: BLE001 - as a new interpreter does
        sys.excepthook(*sys.exc_info())
        sys.exit(1)
    sys.exit(0)


def _renew_streams() -> None:
    """Standard streams of the new descriptors, unbuffered."""
    sys.stdin = open(0, closefd=False)  # noqa: SIM115 - a descriptor
    sys.stdout = _unbuffered(1)
    sys.stderr = _unbuffered(2)


def _unbuffered(descriptor: int) -> io.TextIOWrapper:
    raw = io.FileIO(descriptor, "w", closefd=False)
    return io.TextIOWrapper(raw, errors="backslashreplace", write_through=True)


def _renew_random_numbers() -> None:
    """Seed NumPy's global generator; Python seeds its own generators at a fork."""
    numpy_random = sys.modules.get("numpy.random")
    if numpy_random is not None:
        numpy_random.seed()


def _set_command(request: ForkRequest) -> None:
    """The command line of the module, for Python, for RESTART, and for `ps`."""
    command = (sys.executable, "-m", request.run, *request.arguments)
    sys.orig_argv = list(command)
    sys.argv = ["-m", *request.arguments]
    if not sys.flags.safe_path:
        sys.path[0] = os.getcwd()  # noqa: PTH109 - text
    importlib.invalidate_caches()
    name = f"rune-{request.run.rpartition('.')[2]}".encode()[:_NAME_BYTES]
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_NAME, name, 0, 0, 0)
    show_command((Path(command[0]).name, *command[1:]))


def show_command(words: Iterable[str]) -> None:
    """Write a command over this process's own in memory, from where `ps` reads it."""
    try:
        stat = Path("/proc/self/stat").read_text().rpartition(")")[2].split()
        start, end = int(stat[_ARGUMENTS_FROM]), int(stat[_ARGUMENTS_TO])
    except (OSError, ValueError, IndexError):
        return
    room = end - start - 1  # without a final 0, `ps` would read on in the environment
    if start and room > 0:
        text = b"\0".join(os.fsencode(word) for word in words)[:room]
        ctypes.memset(start, 0, end - start)
        ctypes.memmove(start, text, len(text))


def main() -> NoReturn:
    """Run a parent that the daemon has spawned, with link, mark and imports."""
    number, mark, *imports = sys.argv[1:]
    link = socket.socket(fileno=int(number))
    preload(imports)
    if not has_one_thread():
        sys.exit(SEVERAL_THREADS)
    link.sendall(PID.pack(os.getpid()))  # ready
    serve(link, mark)


if __name__ == "__main__":
    main()
