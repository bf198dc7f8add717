"""A client's control connection: saying hello, staying alive, coming back when central was lost."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import secrets
from typing import Any, Protocol

import zmq

import hub.errors
from hub.errors import HubError, NotAllowedError
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.roles import LOCAL, may_connect
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.security.publish_rights import demand_right
from hub.ipc.transport import sockets
from hub.ipc.transport.clock_sync import ClockSync, this_neighbourhood
from hub.ipc.transport.control_channel import ControlChannel
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.ipc.wire import control

_logger = logging.getLogger(__name__)

PING_S = 0.5
LOST_S = 1.5
"""Central has not answered for this long: the connection counts as lost [s]."""
_QUEUE = 10_000
"""Control messages under way; a client that comes back says all it does at once."""
_WATCHED = zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_HANDSHAKE_FAILED_AUTH | zmq.EVENT_DISCONNECTED
_SECOND_HELLO_S = 0.2
"""Who was refused asks once more, so soon, before it takes the answer [s]."""
_STAY_S = 2.0
"""How long one way of connecting is tried [s]."""
_SHORTEST_S, _LONGEST_S = 0.25, 1.5
"""How long one attempt may take [s].

On a link that was dead the first packet after it healed counts, so attempts are as short as the
round trip that was seen before allows; where it was never seen, and now and then, they are long.
"""
_LONG_EACH = 6


class ConnectionOwner(Protocol):
    """Whoever wants to know what happens to a connection."""

    def welcomed(self, message: control.Welcome, *, anew: bool, same_run: bool) -> None:
        """Central knows us.

        Args:
            message: What it says.
            anew: It did not know us before; what was agreed is void.
            same_run: It was not started again; other clients' numbers are what they were.
        """

    def lost(self, why: str) -> None:
        """Central is gone, or does not know us any more."""

    def told(self, message: Any, attached: bytes | None) -> None:
        """Another control message came."""


class Connection:
    """The control connection of one client.

    Attributes:
        client: Our random number.
        publisher: Our number at central; 0 while it does not know us.
        hub_time: The hub's clock.
        near: Whether central last took us for a neighbour, on its machine and of its user.
        keys: What we show central if it is on another machine.
        refusal: Why central refused our key, or twice to connect us; None if it did not.
        closed: Who had central disconnect us, if somebody did.
    """

    def __init__(
        self,
        name: str,
        endpoint: str,
        *,
        owner: ConnectionOwner,
        context: sockets.Context,
        loop: Loop,
        faults: FaultCounter,
        keys: ClientKeys | None,
        near: bool,
    ) -> None:
        self.publisher = 0
        self.near = False
        self._neighbourhood = this_neighbourhood() if near and keys is None else 0
        self.keys = keys
        self.hub_time = ClockSync(loop.clock)
        self.refusal: HubError | None = None
        self._refused = math.inf
        self.closed = ""
        self._name = name
        self._endpoint = endpoint
        self._owner = owner
        self._context = context
        self._loop = loop
        self._clock = loop.clock
        self._faults = faults
        self.client = secrets.randbits(63) | 1
        self._joined = (0, 0)
        self._heard = -math.inf
        self._next_ping = 0.0
        self._attempt = 0
        self._open()

    def may_connect(self, plane: Plane) -> bool:
        """Whether we may connect to where the messages of a plane go in."""
        return self.keys is None or may_connect(self.keys.role, f"{plane.value} in")

    def demand_right(self, definition: MessageDefinition[Any]) -> None:
        """Refuse a message that our key, or our name, does not let us publish.

        Raises:
            NotAllowedError: The text says who may.
        """
        principal = self.keys.principal if self.keys is not None else LOCAL
        demand_right(principal, self._name, definition.name, definition.plane.value)

    @property
    def alive(self) -> bool:
        """Whether central knows us and has answered lately."""
        return self.publisher > 0 and self._clock() - self._heard < LOST_S

    def due(self, otherwise: float) -> float:
        """When we want to speak again [s]."""
        return min(otherwise, self._next_ping)

    def send(self, message: Any, attached: bytes | None = None) -> bool:
        """Send a control message; False if there is no connection now."""
        told = self._channel.send(message, attached)
        if not told and self.publisher:
            self._faults.count("not sent", "there is no connection to central now")
        return told

    def turn(self) -> None:
        """Say what is due."""
        if self._clock() >= self._next_ping:
            self._keep_alive()

    def addresses(self, message: control.Welcome) -> list[str]:
        """Where each plane goes in and comes out, as we reach it."""
        if self._endpoint.startswith("ipc://"):
            # Beside the file that we know, which a tunnel may have put elsewhere than central's.
            return [f"{self._endpoint}.{number}" for number in range(1, 1 + len(message.paths))]
        host = self._endpoint.rpartition(":")[0]
        return [f"{host}:{port}" for port in message.ports]

    def start_over(self, why: str) -> None:
        """Connect anew; whatever is queued either way would arrive too late."""
        self._lose(why)
        self._channel.close()
        self._attempt = 1
        self._open()

    def close(self) -> None:
        """Say goodbye."""
        if self.publisher:
            self.send(control.Bye())
        linger_ms, self.publisher = 200 if self.publisher else 0, 0
        self._channel.close(linger_ms)

    def _open(self) -> None:
        patience = _LONGEST_S
        if self._attempt % _LONG_EACH and self._joined != (0, 0):
            patience = min(_LONGEST_S, max(_SHORTEST_S, 4 * self.hub_time.round_trip))
        self._attempt += 1
        made = sockets.make(self._context, zmq.DEALER, _QUEUE, self.keys)
        made.connect_timeout = int(patience * 1e3)
        made.reconnect_ivl_max = 100
        self._channel = ControlChannel(
            made,
            told=self._told,
            events=_WATCHED,
            happened=self._happened,
            loop=self._loop,
            faults=self._faults,
            address=self._endpoint,
        )
        self._reopen = self._clock() + _STAY_S
        self._next_ping = 0.0

    def _keep_alive(self) -> None:
        now = self._clock()
        self._next_ping = now + PING_S
        if self.closed:
            return
        if self.publisher and now - self._heard > LOST_S:
            self.start_over("it does not answer")
        elif self.publisher:
            self.send(control.Ping(epoch=self._joined[0], sent=now))
        elif now >= self._reopen:
            self._channel.close()
            self._open()
        else:
            self._hello()

    def _hello(self) -> bool:
        machine, now = self.hub_time.machine, self._clock()
        return self.send(
            control.Hello(
                name=self._name,
                pid=os.getpid(),
                machine=machine,
                sent=now,
                client=self.client,
                neighbourhood=self._neighbourhood,
            )
        )

    def _happened(self, event: int) -> None:
        """Something with the connection itself: a central that comes back is greeted at once."""
        if event == zmq.EVENT_DISCONNECTED:
            self._lose("the connection ended")
        elif event == zmq.EVENT_HANDSHAKE_FAILED_AUTH and self.keys is not None:
            text = (
                f"the hub at {self._endpoint} refuses the key {self.keys.principal.name!r}; "
                "see on the robot with `rune-hub keys list` whether it has it, and in its log"
            )
            self.refusal = NotAllowedError(text)
        elif self.publisher == 0 and not self.closed:
            self._hello()

    def _lose(self, why: str) -> None:
        if self.publisher:
            self.publisher = 0
            self._owner.lost(f"the hub at {self._endpoint} is gone: {why}")

    def _told(self, message: Any, attached: bytes | None) -> None:
        self._heard = self._clock()
        if isinstance(message, control.Welcome):
            self._welcome(message)
        elif isinstance(message, control.Pong):
            self.hub_time.note(message.sent, message.hub_time, self._heard)
        elif isinstance(message, control.UnknownPeer):
            self._lose("it was started again")
            self._hello()
        elif isinstance(message, control.Close) and message.name == self._name:
            self.closed = message.by
            _logger.warning("%s had the hub disconnect %s", message.by, self._name)
            self._lose(f"{message.by} had it disconnect {self._name}")
        elif isinstance(message, control.Refused) and not self.publisher:
            self._refuse(message)
        else:
            self._owner.told(message, attached)

    def _welcome(self, message: control.Welcome) -> None:
        places = zip(message.ports, message.paths, strict=True)
        if not all(
            0 <= port < 65536 and len(path) <= 107 and "*" not in path for port, path in places
        ):
            self._faults.count("malformed control frame", "a WELCOME with impossible ports")
            return
        self.refusal, self._refused = None, math.inf
        self.publisher = message.publisher
        self.near = message.near
        self._attempt = 1
        joined = (message.epoch, message.publisher)
        anew, same_run = joined != self._joined, joined[0] == self._joined[0]
        self._joined = joined
        if anew:
            self.hub_time.begin(message.machine)
        self.hub_time.note(message.sent, message.hub_time, self._heard)
        self._owner.welcomed(message, anew=anew, same_run=same_run)

    def _refuse(self, message: control.Refused) -> None:
        kind = getattr(hub.errors, message.error, None)
        if not (isinstance(kind, type) and issubclass(kind, HubError)):
            kind = hub.errors.CentralUnreachableError
        now = self._clock()
        self._refused = min(self._refused, now)
        if now - self._refused < _SECOND_HELLO_S:
            # The goodbye of who had the name before may still be under way.
            self._next_ping = min(self._next_ping, self._refused + _SECOND_HELLO_S)
            return
        with contextlib.suppress(TypeError):  # an error of ours that takes more than a sentence
            self.refusal = kind(message.text)
        self._faults.count("refused by central", message.text)
