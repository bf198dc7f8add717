"""A client's control connection: HELLO, heartbeats, and the return after a lost central.

| control message | action of the connection |
| --- | --- |
| WELCOME | report the connection, and whether central is new |
| PONG | note the hub's time |
| UNKNOWN_PEER | report the loss, and send HELLO |
| CLOSE of this client | report the loss, for good |
| REFUSED before WELCOME | send HELLO again, then report the refusal |
| any other | hand it to the session |
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import secrets
from collections.abc import Callable
from typing import Any, Protocol

import zmq

import hub.errors
from hub import hub_sockets
from hub.errors import EndpointError, HubError, NotAllowedError
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.endpoints import shown
from hub.ipc.roles import LOCAL, may_connect
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.security.publish_rights import demand_right
from hub.ipc.security.token import RunPassword, Token, known_token
from hub.ipc.transport import sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.transport.clock_sync import ClockSync, this_neighbourhood
from hub.ipc.transport.control_channel import ControlChannel
from hub.ipc.wire import control

_logger = logging.getLogger(__name__)

NEVER = (0, 0)
"""What a client has joined that has not been connected yet."""
PING_S = 0.5
LOST_S = 1.5
"""Time without an answer after which the connection counts as lost [s]."""
_QUEUE = 10_000
"""Most control messages under way; a client that returns announces everything at once."""
_WATCHED = zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_HANDSHAKE_FAILED_AUTH | zmq.EVENT_DISCONNECTED
_SECOND_HELLO_S = 0.2
"""Retry HELLO once after this delay, then report the refusal [s]."""
_SOCKET_LIFE_S, _FIRST_LIFE_S = 2.0, 5.0
"""Time after which a new socket replaces one that cannot connect, later and at first [s].

A connection takes five round trips. So the first life is long, as the round trip is not known.
"""
_STARVED_S = 6.0
"""Longest wait for WELCOME once connected: a hub without processor time answers late [s]."""
_ROUND_TRIPS = 6
_SHORTEST_S, _LONGEST_S = 0.25, 1.5
"""Shortest and longest time for one attempt [s].

The attempt after a link returns connects. So an attempt is as short as the last known round trip
allows. Without a known round trip, and every `_LONG_EACH` attempts, it is long.
"""
_LONG_EACH = 6


class ConnectionOwner(Protocol):
    """The receiver of a connection's reports."""

    def welcomed(self, message: control.Welcome, *, is_new: bool, same_run: bool) -> None:
        """Central has this client.

        Args:
            message: Its answer to HELLO.
            is_new: Whether central has no messages of this client yet.
            same_run: Whether central was not restarted, so other clients keep their numbers.
        """

    def lost(self, why: str) -> None:
        """Central is gone, or has lost this client."""

    def on_control_message(self, message: Any, attached: bytes | None) -> None:
        """Handle a control message about anything but the connection."""


class Connection:
    """The control connection of one client.

    Attributes:
        client: The client's random number.
        publisher: Its number at central; 0 while it is not connected.
        hub_time: The hub's clock.
        near: Whether central is on the same machine, run by the same user.
        ticket: What this client shows where it sends commands to central.
        keys: The keys for a central on another machine.
        refusal: Why central refused the key, or the connection twice; None: it did not.
        joined: Epoch of central and number there of the last connection; NEVER: there was none.
        closed: The client that had central close this connection; empty: none.
    """

    def __init__(
        self,
        name: str,
        endpoint: str,
        *,
        owner: ConnectionOwner,
        transport: ClientTransport,
        keys: ClientKeys | Token | None,
        near: bool,
    ) -> None:
        self.publisher = 0
        self.near = False
        self.ticket = ""
        self._neighbourhood = this_neighbourhood() if near and keys is None else 0
        self.keys = keys
        self._finds_token = keys is None
        self.hub_time = ClockSync(transport.clock)
        self.refusal: HubError | None = None
        self._refused = math.inf
        self.closed = ""
        self._name = name
        self._endpoint = endpoint
        self._address = endpoint
        self._owner = owner
        self._transport = transport
        self._clock = transport.clock
        self._faults = transport.faults
        self.client = secrets.randbits(63) | 1
        self.joined = NEVER
        self._last_answer = -math.inf
        self._next_ping = 0.0
        self._attempt = 0
        self._shook_hands = -math.inf
        self._actions: dict[type, Callable[[Any], bool]] = {
            control.Welcome: self._on_welcome,
            control.Pong: self._on_pong,
            control.UnknownPeer: self._on_unknown,
            control.Close: self._on_close,
            control.Refused: self._on_refused,
        }
        self._open()

    @property
    def proof(self) -> ClientKeys | RunPassword | None:
        """What this client shows at the planes of the hub."""
        return self.keys.of_run(self.joined[0]) if isinstance(self.keys, Token) else self.keys

    def may_connect(self, plane: Plane) -> bool:
        """Whether this client may connect to the input of a plane."""
        return self.keys is None or may_connect(self.keys.role, f"{plane.value} in")

    def demand_right(self, definition: MessageDefinition[Any]) -> None:
        """Refuse a message that this client's key or name does not let it publish.

        Raises:
            NotAllowedError: The text names the role that may.
        """
        principal = self.keys.principal if self.keys is not None else LOCAL
        demand_right(principal, self._name, definition.name, definition.plane.value)

    @property
    def alive(self) -> bool:
        """Whether central has this client and answered within `LOST_S`."""
        return self.publisher > 0 and self._clock() - self._last_answer < LOST_S

    def due(self, otherwise: float) -> float:
        """Time of the next PING or HELLO [s]."""
        return min(otherwise, self._next_ping)

    def send(self, message: Any, attached: bytes | None = None) -> bool:
        """Send a control message; False: there is no connection now."""
        sent = self.channel.send(message, attached)
        if not sent and self.publisher:
            self._faults.count("not sent", "there is no connection to central now")
        return sent

    def turn(self) -> None:
        """Send the PING or HELLO that is due."""
        if self._clock() >= self._next_ping:
            self._keep_alive()

    def addresses(self, message: control.Welcome) -> list[str]:
        """The addresses of each plane, in and out, for this client."""
        if self._address.startswith("ipc://"):
            # Beside the known file: behind a tunnel it differs from central's path.
            return [f"{self._address}.{number}" for number in range(1, 1 + len(message.paths))]
        host = self._address.rpartition(":")[0]
        return [f"{host}:{port}" for port in message.ports]

    def start_over(self, why: str) -> None:
        """Connect again; queued messages would arrive too late."""
        self._lose(why)
        self.channel.close()
        self._attempt = 1
        self._open()

    def close(self) -> None:
        """Send BYE and close."""
        if self.publisher:
            self.send(control.Bye())
        linger_ms, self.publisher = 200 if self.publisher else 0, 0
        self.channel.close(linger_ms)

    def _open(self) -> None:
        longest = _LONGEST_S
        if self._attempt % _LONG_EACH and self.joined != NEVER:
            longest = min(_LONGEST_S, max(_SHORTEST_S, 4 * self.hub_time.round_trip))
        self._attempt += 1
        self._address, self.keys = self._way()
        made = sockets.make(self._transport.context, zmq.DEALER, _QUEUE, self.keys)
        made.connect_timeout = int(longest * 1e3)
        made.reconnect_ivl_max = 100
        self.channel = ControlChannel(
            made,
            on_message=self._on_control_message,
            events=_WATCHED,
            on_event=self._on_event,
            transport=self._transport,
            address=self._address,
        )
        self._reopen = self._clock() + self._life
        self._shook_hands = -math.inf
        self._next_ping = 0.0

    def _is_over(self, now: float) -> bool:
        """Whether a new socket shall replace one without WELCOME."""
        if self._way() != (self._address, self.keys):
            return True
        # A new socket would make a starved hub begin again, and answer one that is gone.
        return now >= self._reopen and not now - self._shook_hands < _STARVED_S

    def _way(self) -> tuple[str, ClientKeys | Token | None]:
        """The address of the hub, and what it takes there: both may come after this client."""
        try:
            address = hub_sockets.address_of(self._endpoint)
        except EndpointError as error:
            self.refusal = error
            return hub_sockets.NOWHERE, self.keys
        self.refusal = None if isinstance(self.refusal, EndpointError) else self.refusal
        if address.startswith("tcp://") and self._finds_token:
            token = known_token(int(address.rpartition(":")[2]))
            # Without a token any program at that port could pose as the hub.
            return (address, token) if token is not None else (hub_sockets.NOWHERE, None)
        return address, self.keys

    @property
    def _life(self) -> float:
        """Time for the socket to connect [s]."""
        if self.joined == NEVER:
            return _FIRST_LIFE_S
        return max(_SOCKET_LIFE_S, _ROUND_TRIPS * self.hub_time.round_trip)

    def _keep_alive(self) -> None:
        now = self._clock()
        self._next_ping = now + PING_S
        if self.closed:
            return
        if self.publisher and now - self._last_answer > LOST_S:
            self.start_over("it does not answer")
        elif self.publisher:
            self.send(control.Ping(epoch=self.joined[0], sent=now))
        elif self._is_over(now):
            self.channel.close()
            self._open()
        else:
            self.hello()

    def hello(self) -> bool:
        """Ask central to take this client; whether the message was sent."""
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

    def _on_event(self, event: int) -> None:
        """Handle a connect, disconnect or refusal of the socket; HELLO follows at once."""
        if event == zmq.EVENT_DISCONNECTED:
            self._shook_hands = -math.inf
            self._lose("the connection ended")
        elif event == zmq.EVENT_HANDSHAKE_FAILED_AUTH and self.keys is not None:
            text = (
                f"the hub at {self._endpoint} refuses the key {self.keys.principal.name!r}; "
                "see on the robot with `rune-hub keys list` whether it has it, and in its log"
            )
            self.refusal = NotAllowedError(text)
        elif self.publisher == 0 and not self.closed:
            self._shook_hands = self._clock()
            self.hello()

    def _lose(self, why: str) -> None:
        if self.publisher:
            self.publisher = 0
            self._owner.lost(f"the hub at {shown(self._endpoint)} is gone: {why}")

    def _on_control_message(self, message: Any, attached: bytes | None) -> None:
        self._last_answer = self._clock()
        action = self._actions.get(type(message))
        if action is None or not action(message):
            self._owner.on_control_message(message, attached)

    def _on_pong(self, message: control.Pong) -> bool:
        self.hub_time.note(message.sent, message.hub_time, self._last_answer)
        return True

    def _on_unknown(self, _: control.UnknownPeer) -> bool:
        self._lose("it was started again")
        self.hello()
        return True

    def _on_close(self, message: control.Close) -> bool:
        if message.name != self._name:
            return False
        self.closed = message.by
        _logger.warning("%s had the hub disconnect %s", message.by, self._name)
        self._lose(f"{message.by} had it disconnect {self._name}")
        return True

    def _on_welcome(self, message: control.Welcome) -> bool:
        places = zip(message.ports, message.paths, strict=True)
        if not all(
            0 <= port < 65536 and len(path) <= 107 and "*" not in path for port, path in places
        ):
            self._faults.count("malformed control frame", "a WELCOME with impossible ports")
            return True
        self.refusal, self._refused = None, math.inf
        self.publisher = message.publisher
        self.near = message.near
        self.ticket = message.ticket
        self._attempt = 1
        joined = (message.epoch, message.publisher)
        is_new, same_run = joined != self.joined, joined[0] == self.joined[0]
        self.joined = joined
        if is_new:
            self.hub_time.begin(message.machine)
        self.hub_time.note(message.sent, message.hub_time, self._last_answer)
        self._owner.welcomed(message, is_new=is_new, same_run=same_run)
        return True

    def _on_refused(self, message: control.Refused) -> bool:
        if self.publisher:
            return False
        kind = getattr(hub.errors, message.error, None)
        if not (isinstance(kind, type) and issubclass(kind, HubError)):
            kind = hub.errors.CentralUnreachableError
        now = self._clock()
        self._refused = min(self._refused, now)
        if now - self._refused < _SECOND_HELLO_S:
            # The BYE of the client that had the name before may still be under way.
            self._next_ping = min(self._next_ping, self._refused + _SECOND_HELLO_S)
            return True
        with contextlib.suppress(TypeError):  # an error that needs more than a sentence
            self.refusal = kind(message.text)
        self._faults.count("refused by central", message.text)
        return True
