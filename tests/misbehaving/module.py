"""A module that misbehaves as its first argument says; the others are a module's own.

python -m tests.misbehaving.module WAY --robot FILE --hub ENDPOINT ... It provides X_WAY.
Ways: well, crash_soon, hang, flood, fork, leak, deaf, no_description.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

from hub.gcm.capability import Abilities
from hub.ipc.client import Client
from hub.runtime import run_module

_LEAK_BYTES = 4_000_000


def _crash_soon(client: Client) -> None:
    client.every(0.3, lambda: os.kill(os.getpid(), signal.SIGSEGV))


def _hang(client: Client) -> None:
    client.every(0.3, lambda: time.sleep(1000.0))


def _flood(client: Client) -> None:
    client.every(0.01, lambda: sys.stdout.write("a line of a flood\n" * 2000))


def _fork(client: Client) -> None:
    del client
    for new_session in (False, True):
        child = subprocess.Popen(["sleep", "300"], start_new_session=new_session)
        sys.stderr.write(f"child {child.pid}\n")


def _leak(client: Client) -> None:
    kept: list[bytes] = []
    client.every(0.02, lambda: kept.append(b"x" * _LEAK_BYTES))


def _deaf(client: Client) -> None:
    client.every(0.1, lambda: signal.signal(signal.SIGTERM, signal.SIG_IGN))
    client.loop.after(0.5, lambda: time.sleep(1000.0))


_WAYS: dict[str, Callable[[Client], None]] = {
    "well": lambda _: None,
    "crash_soon": _crash_soon,
    "hang": _hang,
    "flood": _flood,
    "fork": _fork,
    "leak": _leak,
    "deaf": _deaf,
}


def main() -> int:
    """Run the process."""
    way = sys.argv[1]
    if way == "no_description" or os.environ.get("MISBEHAVE") == "no":
        way = "well"
    capability: Any = f"X_{sys.argv[1]}"

    def build(client: Client, robot: object) -> Callable[[], None]:
        del robot
        _WAYS[way](client)
        return lambda: None

    if "--describe" in sys.argv and sys.argv[1] == "no_description":
        sys.stdout.write("{ no answer\n")
        return 0
    return run_module(
        sys.argv[2],
        "Misbehaves.",
        lambda _: Abilities(provides=(capability,)),
        build,
        sys.argv[3:],
    )


if __name__ == "__main__":
    sys.exit(main())
