"""The listening socket of the door, which bounds connections that have no admitted request yet.

These are half requests, half handshakes of TLS, and connections that say nothing. Each one costs
a descriptor, and ZeroMQ ends a process that has none left.

| event | action |
| --- | --- |
| a connection begins | it is young |
| its request is admitted, or it ends | it is young no longer |
| one more is young than may be | the oldest is ended, and counted |
"""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable
from typing import Any, Final

MOST_YOUNG: Final = 64
"""Most connections without an admitted request; a program takes milliseconds for its own."""


class Entrance(socket.socket):
    """A listening socket for asyncio, which calls `accept`."""

    def __init__(self, host: str, port: int, ended: Callable[[], None]) -> None:
        """Listen.

        Args:
            host: Address or name of this machine.
            port: TCP port; 0: a free one.
            ended: Called when a young connection was ended for another one.

        Raises:
            OSError: It cannot listen there.
        """
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = found[0]
        opened = socket.create_server((address[0], port), family=family)
        super().__init__(opened.family, opened.type, opened.proto, opened.detach())
        self._ended = ended
        self._young: dict[Any, socket.socket] = {}

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection, and its address."""
        connection, address = super().accept()
        young = {each: kept for each, kept in self._young.items() if kept.fileno() >= 0}
        young[address] = connection
        if len(young) > MOST_YOUNG:
            with contextlib.suppress(OSError):  # the other side has ended it
                young.pop(next(iter(young))).shutdown(socket.SHUT_RDWR)
            self._ended()
        self._young = young
        return connection, address

    def admit(self, address: object) -> None:
        """The request of this address is admitted."""
        self._young.pop(address, None)
