"""The socket for direct messages from other clients of the machine."""

from __future__ import annotations

import functools
import secrets
from collections.abc import Callable
from typing import Any

import zmq

from hub.ipc import endpoints
from hub.ipc.definition import Plane
from hub.ipc.transport import sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.transport.sender_tickets import SenderTickets


class DirectInbox:
    """The inbox of one plane.

    Attributes:
        address: Address for publishers.
        commands: Whether commands come here; their senders show tickets.
        receive: Reads one message, as `recv` of a socket does; None: it is refused.
    """

    def __init__(
        self,
        transport: ClientTransport,
        plane: Plane,
        take: Callable[..., bool],
        tickets: SenderTickets,
    ) -> None:
        """Open.

        Args:
            transport: The client's.
            plane: Its plane.
            take: Reads messages, commands or not; whether there may be more.
            tickets: Check the senders of commands.
        """
        self.address = f"{endpoints.DIRECT_PREFIX}{plane.value}-{secrets.token_hex(8)}"
        self._loop = transport.loop
        self._socket = sockets.make_inbox(transport.context, zmq.PULL, plane)
        self._socket.bind(self.address)
        self._tickets = tickets
        self.commands = plane is Plane.COMMAND
        receive = self._admitted if self.commands else self._socket.recv
        self.receive: Callable[[int], bytes | None] = receive
        self._take = functools.partial(take, self.receive, commands=self.commands)
        self._file = self._loop.register(self._socket, self._take)

    def take_now(self) -> bool:
        """Read messages out of turn; whether there may be more.

        The loop reads on: a socket announces new messages only after it was empty.
        """
        self._loop.touch(self._file)
        return self._take()

    def close(self) -> None:
        """Close; messages in it are dropped."""
        self._loop.unregister(self._file)
        self._socket.close(0)

    def _admitted(self, flags: int) -> bytes | None:
        frame: Any = self._socket.recv(flags, copy=False)
        return self._tickets.admit(frame.bytes, frame)
