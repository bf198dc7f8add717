"""A client that says HELLO, and then sends whatever its test likes."""

from __future__ import annotations

import os
from typing import Any

import zmq

from hub.ipc.definition import Plane
from hub.ipc.transport import sender_tickets
from hub.ipc.transport.sockets import PLANES
from hub.ipc.wire import control, control_codec

Context = zmq.Context[zmq.Socket[bytes]]


class RawClient:
    """Connected to the control socket of a hub.

    Attributes:
        control: DEALER.
        number: Its number at central.
        ticket: What it shows where it sends commands to central.
    """

    def __init__(
        self, context: Context, endpoint: str, name: str, *, neighbourhood: int = 0
    ) -> None:
        """Say HELLO, and wait for WELCOME."""
        self._context = context
        self._made: list[zmq.Socket[bytes]] = []
        self.control = context.socket(zmq.DEALER)
        self.control.linger = 0
        self.control.connect(endpoint)
        self.say(control.Hello(name=name, pid=os.getpid(), neighbourhood=neighbourhood))
        welcome = self.heard(control.Welcome)
        self.number, self.ticket = welcome.publisher, welcome.ticket
        self._paths = welcome.paths

    def say(self, message: Any) -> None:
        self.control.send(control_codec.pack(message))

    def heard(self, kind: type) -> Any:
        """The next message of a kind; what comes before it is dropped."""
        while True:
            assert self.control.poll(10_000), f"the hub sends no {kind.__name__}"
            said = control_codec.unpack(self.control.recv_multipart()[0])
            if isinstance(said, kind):
                return said

    def input_of(self, plane: Plane) -> str:
        """Where central takes broadcasts of a plane."""
        return f"ipc://{self._paths[2 * PLANES.index(plane)].removeprefix('ipc://')}"

    def connect(self, kind: int, address: str, ticket: str = "") -> zmq.Socket[bytes]:
        """A socket that shows a ticket there."""
        made = self._context.socket(kind)
        self._made.append(made)
        made.linger = 0
        sender_tickets.show(made, ticket)
        made.connect(address)
        return made

    def close(self) -> None:
        """Go without a word."""
        for each in (self.control, *self._made):
            each.close(0)
