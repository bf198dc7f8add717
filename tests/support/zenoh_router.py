"""A Zenoh router in a process of its own, which tests stop, kill and start again."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from tests.support.ports import free_port

ROOT = Path(__file__).parents[2]


class ZenohRouter:
    """A router at a port of loopback."""

    def __init__(self) -> None:
        self.port = free_port()
        self.endpoint = f"tcp/127.0.0.1:{self.port}"
        self.start()

    def start(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.zenoh_router", self.endpoint],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline(), "the router did not start"

    def freeze(self) -> None:
        self._process.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, self._process.pid, os.WSTOPPED)

    def thaw(self) -> None:
        self._process.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        self._process.kill()
        self._process.communicate()


@contextlib.contextmanager
def zenoh_router() -> Iterator[ZenohRouter]:
    router = ZenohRouter()
    try:
        yield router
    finally:
        router.kill()


def serve(endpoint: str) -> None:
    """Be the router, until standard input ends."""
    from hub.zenoh.session import open_session

    lease = {"transport/link/tx/lease": 60_000}  # as rmw_zenohd has it
    session = open_session(endpoint, mode="router", settings=lease)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    sys.stdin.read()
    session.close()


if __name__ == "__main__":
    serve(sys.argv[1])
