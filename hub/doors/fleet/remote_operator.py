"""An operator elsewhere in the fleet: a client of its own at the robot's hub.

So control, heartbeat, neutral and stop stay with the robot: to its modules, this is a console like
any other. When the operator's token goes, the client closes, and with it all that the operator had.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hub.bucket import Bucket
from hub.errors import CodecError, FleetRefusalError, QueryError
from hub.gcm.control import CONTROL_REQUEST, ControlAction
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.roles import Action, Principal, demand
from hub.ipc.security.publish_rights import demand_right
from hub.ipc.wire import frames
from hub.zenoh.attachment import Attachment, lifespan

ASK_S = 5.0
"""Longest time for an answer of the robot's modules [s]."""
LONGEST_COMMAND = 1 << 20
"""Longest payload of a command or a query [bytes]."""
FROM_THE_FUTURE_S = 0.05
"""Furthest that a stamp may lie ahead of the robot's clock [s]."""
_COMMANDS_PER_S, _QUERIES_PER_S = 400.0, 100.0


class RemoteOperator:
    """A session of an operator.

    Attributes:
        principal: The operator, with its role.
        client: Its connection to the robot's hub.
    """

    def __init__(self, principal: Principal, session: int, near: Client) -> None:
        """Connect.

        Args:
            principal: The operator.
            session: Number of its session.
            near: The gateway's own client.
        """
        self.principal = principal
        name = f"{principal.name[:40]}@fleet {session}"
        self.client = Client(name, near.endpoint, loop=near.loop)
        self._clock = near.loop.clock
        self._sequences: dict[str, int] = {}
        self._commands = Bucket(_COMMANDS_PER_S, _COMMANDS_PER_S)
        self._queries = Bucket(_QUERIES_PER_S, _QUERIES_PER_S)

    @property
    def number(self) -> int:
        """Its number at the robot's hub; 0: it is not connected yet."""
        return self.client.number

    def command(
        self, definition: MessageDefinition[Any], header: Attachment, payload: bytes
    ) -> None:
        """Publish a command, unless it must not be.

        Raises:
            NotAllowedError: The operator's role does not allow it.
            FleetRefusalError: It is too old, repeated, too long, too much, or of another format.
        """
        name = definition.name
        demand_right(self.principal, self.client.name, name, Plane.COMMAND.value)
        self._check(definition, header, payload)
        if header.sequence <= self._sequences.get(name, 0):
            text = f"{name} number {header.sequence} came again, or after a later one"
            raise FleetRefusalError(text)
        now = self._clock()
        if not self._commands.take(1.0, now):
            text = f"{self.principal.name} sends more than {_COMMANDS_PER_S:.0f} commands a second"
            raise FleetRefusalError(text)
        self._sequences[name] = header.sequence
        self.client.publish_payload(definition, payload, measured=min(now, header.stamp_ns * 1e-9))

    def ask(
        self,
        definition: MessageDefinition[Any],
        header: Attachment,
        payload: bytes,
        *,
        answered: Callable[[frames.Frame], None],
        failed: Callable[[QueryError], None],
    ) -> None:
        """Ask the robot's modules; exactly one of `answered` and `failed` is called later.

        Raises:
            NotAllowedError: The operator's role does not allow it.
            FleetRefusalError: It is too old, too long, too much, or of another format.
        """
        if definition.plane is Plane.COMMAND:
            demand_right(self.principal, self.client.name, definition.name, Plane.COMMAND.value)
        self._check(definition, header, payload)
        if definition.name == CONTROL_REQUEST.name:
            self._check_request(payload)
        if not self._queries.take(1.0, self._clock()):
            text = f"{self.principal.name} asks more than {_QUERIES_PER_S:.0f} times a second"
            raise FleetRefusalError(text)
        self.client.query_payload(
            definition, payload, timeout=ASK_S, answered=answered, failed=failed
        )

    def close(self) -> None:
        """Leave the hub: control becomes free, and what was commanded ends."""
        self.client.close()

    def _check(
        self, definition: MessageDefinition[Any], header: Attachment, payload: bytes
    ) -> None:
        name, now_ns = definition.name, int(self._clock() * 1e9)
        if header.fingerprint != definition.fingerprint:
            text = f"{name} has another format here; use the same version of Rune on both sides"
        elif len(payload) > LONGEST_COMMAND:
            text = f"{name} of {len(payload)} bytes is too long; {LONGEST_COMMAND} are most"
        elif (age := header.age(now_ns)) > lifespan(definition):
            text = f"{name} is {age:.1f} s old and is not obeyed"
        elif header.stamp_ns - now_ns > FROM_THE_FUTURE_S * 1e9:
            text = f"{name} is from the future; its sender has to measure the robot's clock again"
        else:
            return
        raise FleetRefusalError(text)

    def _check_request(self, payload: bytes) -> None:
        """To the hub, this client is on the robot; so the gateway checks what needs a role."""
        try:
            request = CONTROL_REQUEST.decode(payload)
        except CodecError as error:
            text = f"{CONTROL_REQUEST.name} cannot be read: {error}"
            raise FleetRefusalError(text) from error
        if request.action in (ControlAction.TAKE_OVER, ControlAction.FREE):
            demand(self.principal, Action.TAKE_OVER)
