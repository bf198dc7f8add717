"""Direct queries between two modules of one machine, past central.

If only one module answers a query, central sends its address to the clients that ask, and their
next queries go there. When that connection ends, queries go through central again.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import zmq

from hub.errors import CodecError, FrameError
from hub.ipc import endpoints
from hub.ipc.transport import sender_tickets, sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.transport.control_channel import ControlChannel
from hub.ipc.transport.sender_tickets import SenderTickets
from hub.ipc.wire import control, control_codec

_QUEUE = 1000
_BATCH = 64

Asked = Callable[[control.Query, bytes, bytes], None]
"""Gets a query, its message, and the identity of the asker."""


class DirectResponder:
    """The socket where a module receives queries directly.

    Attributes:
        address: Address for its clients.
        tickets: Check who asks.
    """

    def __init__(
        self,
        number: int,
        asked: Asked,
        transport: ClientTransport,
    ) -> None:
        """Open.

        Args:
            number: This client's random number.
            asked: Gets the queries.
            transport: The client's.
        """
        self.address = f"{endpoints.DIRECT_PREFIX}{number:x}"
        self._asked = asked
        self._loop = transport.loop
        self._faults = transport.faults
        self.renew_key()
        self._socket = sockets.make(transport.context, zmq.ROUTER, _QUEUE)
        self._socket.router_handover = True
        sockets.allow_own_user_only(self._socket)
        self._socket.bind(self.address)
        self._send = sockets.sender(self._socket)
        self._file = self._loop.register(self._socket, self._receive)

    def renew_key(self) -> None:
        """Make a new key, at a new connection to central: earlier tickets end."""
        self.tickets = SenderTickets(self._faults)

    def answer(self, asker: bytes, message: Any, attached: bytes | None) -> None:
        """Send an answer; it is dropped if the asker is gone or the socket is closed."""
        if self._socket.closed:
            return
        packed = control_codec.pack(message)
        self._loop.touch(self._file)
        parts = [asker, packed] if attached is None else [asker, packed, attached]
        with contextlib.suppress(zmq.Again):
            sockets.send_parts(self._send, parts)

    def close(self) -> None:
        """Close; the askers see it at once."""
        self._loop.unregister(self._file)
        self._socket.close(0)

    def _receive(self) -> bool:
        for _ in range(_BATCH):
            try:
                parts: Any = self._socket.recv_multipart(zmq.NOBLOCK, copy=False)
            except zmq.Again:
                return False
            try:
                message = control_codec.unpack(parts[1].buffer)
                if len(parts) != 3 or not isinstance(message, control.Query):
                    text = f"{len(parts)} parts came directly that are no query"
                    raise FrameError(text)
            except (FrameError, CodecError, IndexError) as error:
                self._faults.count("malformed control frame", str(error))
                continue
            if self.tickets.admits_query(parts[2]):
                self._asked(message, parts[2].bytes, parts[0].bytes)
        return True


class DirectRequester:
    """A direct connection to one module that answers.

    Attributes:
        address: Its address for direct queries.
        names: The messages that it answers.
    """

    def __init__(
        self,
        address: str,
        ticket: str,
        transport: ClientTransport,
        *,
        answered: Callable[[Any, bytes | None], None],
        lost: Callable[[DirectRequester], None],
    ) -> None:
        """Connect.

        Args:
            address: The module's address for direct queries.
            ticket: What this client shows there.
            transport: The client's.
            answered: Gets the answers.
            lost: Called at the end of the connection.
        """
        self.address = address
        self.names: set[str] = set()
        self._answered = answered
        made = sockets.make(transport.context, zmq.DEALER, _QUEUE)
        made.reconnect_ivl = -1
        sender_tickets.show(made, ticket)
        self._channel = ControlChannel(
            made,
            on_message=self._on_message,
            events=zmq.EVENT_DISCONNECTED,
            on_event=lambda _: lost(self),
            transport=transport,
            address=address,
        )

    def ask(self, query: control.Query, frame: bytes) -> bool:
        """Send a query; False: there is no connection."""
        return self._channel.send(query, frame)

    def close(self) -> None:
        """Close."""
        self._channel.close()

    def _on_message(self, message: Any, attached: bytes | None) -> None:
        if isinstance(message, (control.Response, control.Failure)):
            self._answered(message, attached)
