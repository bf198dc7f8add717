"""A client's end of a connection for control messages, to central or to another client."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import zmq

from hub.errors import CodecError, FrameError
from hub.ipc.transport import sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.wire import control_codec

_BATCH = 256
_TURN_S = 0.02
"""Longest turn of messages before timers have theirs [s]."""


class ControlChannel:
    """A connected socket (DEALER), served by a loop."""

    def __init__(
        self,
        socket: sockets.Socket,
        *,
        on_message: Callable[[Any, bytes | None], None],
        events: int,
        on_event: Callable[[int], None],
        transport: ClientTransport,
        address: str,
    ) -> None:
        """Connect.

        Args:
            socket: The socket.
            on_message: Gets each control message and the message frame behind it.
            events: The reported events of the connection: `zmq.EVENT_...` together.
            on_event: Gets each of these.
            transport: The client's.
            address: Address of the other end.
        """
        self.socket = socket
        self._on_message = on_message
        self._on_event = on_event
        self._loop = transport.loop
        self._faults = transport.faults
        self._send_part = sockets.sender(socket)
        self._monitor = socket.get_monitor_socket(events)
        sockets.connect(socket, address)
        self._file = self._loop.register(socket, self._receive)
        self._monitor_file = self._loop.register(self._monitor, self._watch)

    def send(self, message: Any, attached: bytes | None = None) -> bool:
        """Send a control message; False: there is no connection."""
        if self.socket.closed:
            return False
        packed = control_codec.pack(message)
        self._loop.touch(self._file)
        try:
            sockets.send_parts(
                self._send_part, [packed] if attached is None else [packed, attached]
            )
        except zmq.Again:
            return False
        return True

    def close(self, linger_ms: int = 0) -> None:
        """Close; sent frames get `linger_ms` to leave."""
        self._loop.unregister(self._file)
        self._loop.unregister(self._monitor_file)
        self.socket.disable_monitor()
        self._monitor.close(0)
        self.socket.close(linger_ms)

    def _watch(self) -> bool:
        while not self._monitor.closed:
            try:
                raw = self._monitor.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                break
            self._on_event(sockets.parse_event(raw)[0])
        return False

    def _receive(self) -> bool:
        socket = self.socket
        end = self._loop.clock() + _TURN_S
        for _ in range(_BATCH):
            try:
                parts = socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return False
            try:
                message = control_codec.unpack(parts[0])
            except (FrameError, CodecError) as error:
                self._faults.count("malformed control frame", str(error))
                continue
            self._on_message(message, parts[1] if len(parts) > 1 else None)
            if socket.closed:
                return False
            if not sockets.readable(socket):
                self._loop.settle(self._file)
                return False
            if self._loop.clock() > end:
                break
        return True
