"""The sockets of a client in their handshake with central."""

from __future__ import annotations

import time

import zmq

from hub.ipc.transport import sockets


class Handshakes:
    """Handshakes under way.

    To central, a socket that closes during its handshake looks like a program of another protocol.
    So a client that closes waits for its handshakes first.
    """

    def __init__(self) -> None:
        self._monitors: dict[sockets.Socket, sockets.Socket] = {}

    def begin(self, socket: sockets.Socket) -> None:
        """Watch a socket that is about to connect."""
        self._monitors[socket] = socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_SUCCEEDED)

    def end(self, socket: sockets.Socket) -> None:
        """Stop watching a socket, after its handshake or before its close."""
        monitor = self._monitors.pop(socket, None)
        if monitor is not None:
            socket.disable_monitor()
            monitor.close(0)

    def end_finished(self) -> None:
        """Stop watching finished handshakes: they would fill their monitors."""
        self.wait(0.0)

    def wait(self, timeout: float) -> None:
        """Wait for all of them, for up to `timeout` [s]."""
        deadline = time.monotonic() + timeout
        for socket, monitor in list(self._monitors.items()):
            if monitor.poll(int(max(0.0, deadline - time.monotonic()) * 1e3)):
                self.end(socket)
