"""The environment of all tests, the same on every machine and in every shell.

Tests inherit the variables in `_KEPT` and none besides: no terminal, multiplexer, language, proxy,
desktop, supervisor or folder of the person who runs them. What they start gets each signal with its
default action, no blocked signals, and the usual umask.
"""

from __future__ import annotations

import contextlib
import os
import pwd
import signal
import time
from typing import Final

_KEPT: Final = ("PATH", "TMPDIR", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH")
"""Variables without which programs of this machine do not start."""
_KEPT_BEGINNINGS: Final = ("RUNE_", "HYPOTHESIS_PROFILE", "PYTEST_", "PY_COLORS")
"""Beginnings of variables that are for the tests: how many, how long, how they are shown."""
_OURS: Final = {
    "HOME": "/nonexistent",  # fixtures make folders
    "LANG": "C.UTF-8",
    "TERM": "xterm-256color",
    "TZ": "UTC",
    # As the commands do: NumPy's own threads cost each process time at its start.
    "OPENBLAS_NUM_THREADS": "1",
}
_UMASK: Final = 0o022
_OF_PYTHON: Final = {signal.SIGPIPE, signal.SIGXFSZ}
"""Signals that Python ignores itself; `subprocess` resets them."""


def enter() -> None:
    """Have this process, and all that it starts, run in the environment of tests.

    Call it in the main thread, before anything else reads the environment or starts a process.
    """
    kept = {
        name: value
        for name, value in os.environ.items()
        if name in _KEPT or name.startswith(_KEPT_BEGINNINGS)
    }
    if os.environ.get("NO_COLOR"):
        kept.setdefault("PY_COLORS", "0")  # pytest's report, for the person who reads it
    os.environ.clear()
    for name in ("COLUMNS", "LINES"):
        os.unsetenv(name)  # the library readline, which pytest loads, sets them behind os.environ
    os.environ.update(kept | _OURS | {"LOGNAME": _user()})
    time.tzset()
    os.umask(_UMASK)
    _take_signals()


def _user() -> str:
    """The user's name by the system; the shell's variables may hold another's."""
    try:
        return pwd.getpwuid(os.getuid()).pw_name
    except KeyError:
        return f"user{os.getuid()}"


def _take_signals() -> None:
    """Go on ignoring what is ignored, by a handler: what tests start does not inherit that."""
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    for number in signal.valid_signals() - _OF_PYTHON:
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda *_: None)
            if number == signal.SIGHUP and _in_background():
                # By nohup. The shell's SIGHUP must not reach what tests start.
                with contextlib.suppress(PermissionError):  # it leads a group of processes
                    os.setsid()


def _in_background() -> bool:
    try:
        with open("/dev/tty") as terminal:  # noqa: PTH123 - no file
            return os.tcgetpgrp(terminal.fileno()) != os.getpgrp()
    except OSError:  # there is no terminal
        return True
