"""Ends the modules when the daemon dies without an end, for example by SIGKILL.

It is a small process, started by the file's name, without imports of Rune. Standard input names the
process groups of running modules: lines "123", and "-123" for those that have ended. When the input
ends, modules have `STOP_TIME_S` to stop by themselves. Then the reaper kills the rest of the groups
and every process with the mark. The mark is this program's argument; a process has it as a variable
of its environment or as the name of a mapped page, in any group and session.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time

STOP_TIME_S = 1.0
"""Time for modules to stop by themselves after the daemon's end [s]."""
_POLL_S = 0.05
_ROUNDS = 20
"""Number of searches: marked processes may start others while the reaper kills them."""


def _alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def marked(mark: bytes) -> list[int]:
    """The processes with the mark; Linux only."""
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
    """Wait for the end of the daemon, and end the rest of its modules."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    mark = os.fsencode(sys.argv[1])
    groups: set[int] = set()
    for line in sys.stdin:
        group = int(line)
        (groups.add if group > 0 else groups.discard)(abs(group))
    end = time.monotonic() + STOP_TIME_S
    while any(map(_alive, groups)) and time.monotonic() < end:
        time.sleep(_POLL_S)
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
        time.sleep(_POLL_S)


if __name__ == "__main__":
    main()
