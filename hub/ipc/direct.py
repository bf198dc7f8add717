"""The short way of queries between two modules of one machine, past central.

Central still says who answers what. Whoever answers alone has a socket of its own; central tells
those who ask, and their next queries go there. When the way ends, everything goes through central.
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable
from typing import Any

import zmq

from hub.errors import CodecError, FrameError
from hub.ipc import control, control_frames, neighbours, sockets
from hub.ipc.complaints import Complaints
from hub.ipc.loop import Loop

_QUEUE = 1000
_BATCH = 64

Asked = Callable[[control.Query, bytes, bytes], None]
"""Gets a query, its message, and whom to answer."""


class DirectDoor:
    """Where queries come in at who answers them.

    Attributes:
        address: Where others connect.
    """

    def __init__(
        self,
        number: int,
        asked: Asked,
        *,
        context: sockets.Context,
        loop: Loop,
        complaints: Complaints,
    ) -> None:
        """Open.

        Args:
            number: This client's random number.
            asked: Gets what comes in.
            context: The client's.
            loop: Serves it.
            complaints: Counts what is malformed.
        """
        self.address = f"{neighbours.PLACE}{number:x}"
        self._asked = asked
        self._loop = loop
        self._complaints = complaints
        self._socket = sockets.make(context, zmq.ROUTER, _QUEUE)
        self._socket.router_handover = True
        sockets.keep_to_ourselves(self._socket)
        self._socket.bind(self.address)
        self._send = sockets.sender(self._socket)
        self._file = loop.register(self._socket, self._receive)

    def answer(self, asker: bytes, message: Any, attached: bytes | None) -> None:
        """Send an answer; if the asker is gone, nobody misses it."""
        packed = control_frames.pack(message)
        self._loop.touch(self._file)
        with contextlib.suppress(zmq.Again):
            self._send(asker, sockets.MORE)
            if attached is None:
                self._send(packed, sockets.NOBLOCK)
            else:
                self._send(packed, sockets.MORE)
                self._send(attached, sockets.NOBLOCK)

    def close(self) -> None:
        """Close; who asks notices at once."""
        self._loop.unregister(self._file)
        self._socket.close(0)

    def _receive(self) -> bool:
        for _ in range(_BATCH):
            try:
                parts = self._socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return False
            try:
                message = control_frames.unpack(parts[1])
                if len(parts) != 3 or not isinstance(message, control.Query):
                    text = f"{len(parts)} parts came directly that are no query"
                    raise FrameError(text)
            except (FrameError, CodecError, IndexError) as error:
                self._complaints.count("malformed control frame", str(error))
                continue
            self._asked(message, parts[2], parts[0])
        return True


class DirectWay:
    """The way to one module that answers.

    Attributes:
        address: Its door.
        names: The messages that it answers.
    """

    def __init__(
        self,
        address: str,
        *,
        answered: Callable[[Any, bytes | None], None],
        lost: Callable[[DirectWay], None],
        context: sockets.Context,
        loop: Loop,
        complaints: Complaints,
    ) -> None:
        """Connect.

        Args:
            address: The door.
            answered: Gets what comes back.
            lost: Called when the way has ended.
            context: The client's.
            loop: Serves it.
            complaints: Counts what is malformed.
        """
        self.address = address
        self.names: set[str] = set()
        self._answered = answered
        self._loop = loop
        self._complaints = complaints
        self._socket = sockets.make(context, zmq.DEALER, _QUEUE)
        self._socket.reconnect_ivl = -1
        self._send = sockets.sender(self._socket)
        self._monitor = self._socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        sockets.connect(self._socket, address)
        self._file = loop.register(self._socket, self._receive)
        self._monitor_file = loop.register(self._monitor, functools.partial(self._watch, lost))

    def ask(self, query: control.Query, frame: bytes) -> bool:
        """Send a query; False if there is no connection yet, or none any more."""
        packed = control_frames.pack(query)
        self._loop.touch(self._file)
        try:
            self._send(packed, sockets.MORE)
            self._send(frame, sockets.NOBLOCK)
        except zmq.Again:
            return False
        return True

    def close(self) -> None:
        """Close."""
        self._loop.unregister(self._file)
        self._loop.unregister(self._monitor_file)
        self._socket.disable_monitor()
        self._monitor.close(0)
        self._socket.close(0)

    def _watch(self, lost: Callable[[DirectWay], None]) -> bool:
        try:
            self._monitor.recv_multipart(zmq.NOBLOCK)
        except zmq.Again:
            return False
        lost(self)
        return False

    def _receive(self) -> bool:
        socket = self._socket
        for _ in range(_BATCH):
            try:
                parts = socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return False
            try:
                message = control_frames.unpack(parts[0])
            except (FrameError, CodecError) as error:
                self._complaints.count("malformed control frame", str(error))
                continue
            if isinstance(message, (control.Response, control.Failure)):
                self._answered(message, parts[1] if len(parts) > 1 else None)
            if socket.closed:
                return False
            if not sockets.readable(socket):
                self._loop.settle(self._file)
                return False
        return True
