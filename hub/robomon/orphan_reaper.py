"""Ends the modules when the daemon dies without doing so, as by SIGKILL.

A process of its own, started by the file's name, so that it is small and imports nothing of ours.
On standard input it is told the process groups of the modules that run: "+123" and "-123" lines.
When that ends, modules have a moment to stop by themselves; what is left of them is killed. What
they have started carries the mark, a variable of its environment that is our argument, also where
it has left their process groups.
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
"""How often it is looked for marked processes: new ones may be started while others are killed."""


def _alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def marked(mark: bytes) -> list[int]:
    """The processes in whose environment this is written; Linux only."""
    found = []
    with contextlib.suppress(OSError):
        for name in os.listdir("/proc"):  # noqa: PTH208 - imports as little as possible
            with contextlib.suppress(OSError):
                if name.isdigit() and mark in _environment(name) and int(name) != os.getpid():
                    found.append(int(name))
    return found


def _environment(pid: str) -> list[bytes]:
    with open(f"/proc/{pid}/environ", "rb") as file:  # noqa: PTH123 - see above
        return file.read().split(b"\0")


def main() -> None:
    """Wait until the daemon is gone, and clean up after it."""
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
