"""Ends the modules when the daemon dies without doing so, as by SIGKILL.

A process of its own, started by the file's name, so that it is small and imports nothing of Rune.
Standard input names the process groups of the modules that run: lines "123", and "-123" for those
that have ended. When the input ends, modules have a moment to stop by themselves. Then the reaper
kills what is left of the groups, and every process that carries the mark: this program's argument,
as a variable of the environment or as the name of a mapped page. What modules have started carries
it in any group and session.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time

GRACE_S = 1.0
"""Time that modules have to stop by themselves when the daemon is gone [s]."""
_LOOK_S = 0.05
_ROUNDS = 20
"""How often the reaper searches: marked processes may start others while it kills them."""


def _alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def marked(mark: bytes) -> list[int]:
    """The processes that carry the mark; Linux only."""
    found = []
    with contextlib.suppress(OSError):
        for name in os.listdir("/proc"):  # noqa: PTH208 - imports as little as possible
            with contextlib.suppress(OSError):
                if name.isdigit() and int(name) != os.getpid() and _carries(name, mark):
                    found.append(int(name))
    return found


def _carries(pid: str, mark: bytes) -> bool:
    """Spawned processes have the mark in their environment, forked ones have a page of its name."""
    if mark in _read(pid, "environ").split(b"\0"):
        return True
    return b"/memfd:" + mark + b" " in _read(pid, "maps")


def _read(pid: str, name: str) -> bytes:
    with open(f"/proc/{pid}/{name}", "rb") as file:  # noqa: PTH123 - imports as little as possible
        return file.read()


def main() -> None:
    """Wait until the daemon is gone, and end what it has left."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    mark = os.fsencode(sys.argv[1])
    groups: set[int] = set()
    for line in sys.stdin:
        group = int(line)
        (groups.add if group > 0 else groups.discard)(abs(group))
    end = time.monotonic() + GRACE_S
    while any(map(_alive, groups)) and time.monotonic() < end:
        time.sleep(_LOOK_S)
    for group in groups:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(group, signal.SIGKILL)
    for _ in range(_ROUNDS):
        left = marked(mark)
        if not left:
            break
        for pid in left:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(_LOOK_S)


if __name__ == "__main__":
    main()
