"""A Zenoh router in a process of its own, which tests stop, kill and start again."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from hub.zenoh.settings import CertificateFiles
from tests.support.ports import free_port

ROOT = Path(__file__).parents[2]


class ZenohRouter:
    """A router at a port of loopback.

    Attributes:
        endpoint: Where everybody may join.
        secure: Where only those may join who have a certificate of the authority; empty: nowhere.
    """

    def __init__(self, certificates: CertificateFiles | None = None) -> None:
        self.port = free_port()
        self.endpoint = f"tcp/127.0.0.1:{self.port}"
        self.secure = ""
        self._settings: dict[str, object] = {}
        if certificates is not None:
            self.secure = f"tls/localhost:{self.port + 1}"
            self._settings = {
                "listen/endpoints": [self.endpoint, self.secure],
                "transport/link/tls": {
                    "root_ca_certificate": str(certificates.authority),
                    "enable_mtls": True,
                    "listen_certificate": str(certificates.certificate),
                    "listen_private_key": str(certificates.key),
                },
            }
        self.start()

    def start(self) -> None:
        words = [self.endpoint, json.dumps(self._settings)]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.zenoh_router", *words],
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
def zenoh_router(certificates: CertificateFiles | None = None) -> Iterator[ZenohRouter]:
    router = ZenohRouter(certificates)
    try:
        yield router
    finally:
        router.kill()


def serve(endpoint: str, settings: dict[str, object]) -> None:
    """Be the router, until standard input ends."""
    from hub.zenoh.session import open_session

    lease = {"transport/link/tx/lease": 60_000}  # as rmw_zenohd has it
    session = open_session(endpoint, mode="router", settings=lease | settings)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    sys.stdin.read()
    session.close()


if __name__ == "__main__":
    serve(sys.argv[1], json.loads(sys.argv[2]))
