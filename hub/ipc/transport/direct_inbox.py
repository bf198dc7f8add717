"""The socket for direct messages from other clients of the machine."""

from __future__ import annotations

import functools
import secrets
from collections.abc import Callable

import zmq

from hub.ipc import endpoints
from hub.ipc.definition import Plane
from hub.ipc.transport import sockets
from hub.ipc.transport.client_transport import ClientTransport


class DirectInbox:
    """The inbox of one plane.

    Attributes:
        address: Address for publishers.
        socket: The messages.
    """

    def __init__(
        self,
        transport: ClientTransport,
        plane: Plane,
        take: Callable[[sockets.Socket], bool],
    ) -> None:
        """Open.

        Args:
            transport: The client's.
            plane: Its plane.
            take: Reads messages; whether there may be more.
        """
        self.address = f"{endpoints.DIRECT_PREFIX}{plane.value}-{secrets.token_hex(8)}"
        self._loop = transport.loop
        self.socket = sockets.make_inbox(transport.context, zmq.PULL, plane)
        self.socket.bind(self.address)
        self._take = functools.partial(take, self.socket)
        self._file = self._loop.register(self.socket, self._take)

    def take_now(self) -> bool:
        """Read messages out of turn; whether there may be more.

        The loop reads on: a socket announces new messages only after it was empty.
        """
        self._loop.touch(self._file)
        return self._take()

    def close(self) -> None:
        """Close; messages in it are dropped."""
        self._loop.unregister(self._file)
        self.socket.close(0)
