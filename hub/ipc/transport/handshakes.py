"""Which of a client's sockets are in the middle of their handshake with central."""

from __future__ import annotations

import time

import zmq

from hub.ipc.transport import sockets


class Handshakes:
    """Handshakes under way.

    A socket that is closed during its handshake looks to central like a program that does not speak
    the protocol. So a client that closes waits for its handshakes first, which takes a moment.
    """

    def __init__(self) -> None:
        self._monitors: dict[sockets.Socket, sockets.Socket] = {}

    def begin(self, socket: sockets.Socket) -> None:
        """This socket is going to connect."""
        self._monitors[socket] = socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_SUCCEEDED)

    def end(self, socket: sockets.Socket) -> None:
        """The handshake is over, or the socket is going to be closed."""
        monitor = self._monitors.pop(socket, None)
        if monitor is not None:
            socket.disable_monitor()
            monitor.close(0)

    def look(self) -> None:
        """Stop watching those that are over: they would fill their monitors."""
        self.wait(0.0)

    def wait(self, timeout: float) -> None:
        """Wait for all of them, for up to `timeout` [s]."""
        deadline = time.monotonic() + timeout
        for socket, monitor in list(self._monitors.items()):
            if monitor.poll(int(max(0.0, deadline - time.monotonic()) * 1e3)):
                self.end(socket)
