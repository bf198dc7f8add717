"""A relay between clients and central that can stop forwarding without closing anything.

python -m tests.misbehaving.black_hole HOST PORT...: it listens at HOST with the same ports as
central has at 127.0.0.1. While it is dark, nothing passes, connections are accepted by the kernel
alone, and whatever is sent waits in buffers, as it does on a radio link that is gone. It reads
commands from standard input, a line each: "dark" or "light", and answers each with a JSON line.
"""

from __future__ import annotations

import contextlib
import json
import socket
import sys
import threading
import time

_CHUNK = 1 << 16


class Relay:
    """Listeners, and for each connection a thread a direction."""

    def __init__(self, host: str, ports: list[int]) -> None:
        self._light = threading.Event()
        self._light.set()
        for port in ports:
            listener = socket.create_server((host, port), backlog=512)
            self._start(self._accept, listener, port)

    def switch(self, *, dark: bool) -> None:
        """Stop or go on forwarding."""
        if dark:
            self._light.clear()
        else:
            self._light.set()

    def _start(self, work: object, *arguments: object) -> None:
        threading.Thread(target=work, args=arguments, daemon=True).start()

    def _accept(self, listener: socket.socket, port: int) -> None:
        while True:
            near, _ = listener.accept()
            self._light.wait()
            try:
                far = socket.create_connection(("127.0.0.1", port), 2.0)
            except OSError:
                near.close()
                continue
            for end in (near, far):
                end.settimeout(None)
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._start(self._forward, near, far)
            self._start(self._forward, far, near)

    def _forward(self, source: socket.socket, target: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while chunk := source.recv(_CHUNK):
                self._light.wait()
                target.sendall(chunk)
        self._light.wait()
        # Both ends, so that the thread of the other direction ends as well.
        for end in (source, target):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()


def _say(word: str) -> None:
    sys.stdout.write(json.dumps({word: time.monotonic_ns()}) + "\n")
    sys.stdout.flush()


def main() -> None:
    relay = Relay(sys.argv[1], [int(port) for port in sys.argv[2:]])
    _say("listening")
    for line in sys.stdin:
        relay.switch(dark=line.strip() == "dark")
        _say(line.strip())


if __name__ == "__main__":
    main()
