"""All operators elsewhere in the fleet: their sessions, commands and queries at one robot."""

from __future__ import annotations

import json
import logging
import math

from hub.bucket import Bucket
from hub.doors.fleet.hub_messages import HubMessages
from hub.doors.fleet.remote_operator import RemoteOperator
from hub.errors import FleetKeyError, FleetRefusalError, HubError, NotAllowedError
from hub.gcm.navigation import STOP, Stop
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.roles import Principal, Role
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames
from hub.zenoh.attachment import Attachment, unpack
from hub.zenoh.fleet_keys import FleetKey, KeyKind, parse_key, pattern
from hub.zenoh.fleet_line import ZenohFleetLine
from hub.zenoh.fleet_session import FleetQuery, FleetWay

_logger = logging.getLogger(__name__)

MOST_SESSIONS = 32
"""Most sessions of operators at one robot: each is a client of its hub."""
MOST_OF_ONE = 8
"""Most sessions of one operator."""
MOST_THAT_OBSERVE = 16
"""Most sessions of operators that only observe: the other places are for those that command."""
_MOST_WAITING = 1000
"""Most further sessions that are remembered, until one of the others ends."""
_REFUSAL_S = 1.0
"""Least time between two refusals that are said to one operator [s]."""
_ADMITTING_S = 3.0
"""Time in which a session may become known before its commands are refused aloud [s]."""
_LOOK_S = 0.05


class FleetOperators:
    """The operators' side of a robot's keys."""

    def __init__(
        self,
        client: Client,
        line: ZenohFleetLine,
        messages: HubMessages,
        faults: FaultCounter,
        *,
        fleet: str,
        robot: str,
    ) -> None:
        """Wait for operators."""
        self._client, self._line, self._messages = client, line, messages
        self._faults, self._fleet, self._robot = faults, fleet, robot
        # An operator may choose the number of another's session: each has numbers of its own.
        self._sessions: dict[tuple[Principal, int], RemoteOperator] = {}
        self._waiting: dict[tuple[Principal, int], None] = {}
        self._said: dict[str, float] = {}
        self._absent: dict[tuple[Principal, int], float] = {}
        self._published: dict[str, int] | None = None
        self._stops = Bucket(20.0, 20.0)
        self._key = FleetKey(kind=KeyKind.OPERATORS, robot=robot).under(fleet)
        self._declared = [
            line.watch(pattern(fleet, KeyKind.OPERATOR, robot=robot), self._changed),
            line.subscribe(
                pattern(fleet, KeyKind.COMMAND, robot=robot),
                self._commanded,
                keep=lambda key: key.endswith(f"/{STOP.name}"),
            ),
            line.respond(pattern(fleet, KeyKind.ASK, robot=robot), self._asked),
            line.respond(self._key, lambda query: query.answer(self.as_json(), key=self._key)),
        ]
        self._timer = client.every(_LOOK_S, self._look)

    def as_json(self) -> bytes:
        """The number at the robot's hub of each session, by operator and session."""
        return json.dumps(self._numbers()).encode()

    def close(self) -> None:
        """Let all operators go."""
        self._timer.cancel()
        for declared in self._declared:
            declared.withdraw()
        for operator in self._sessions.values():
            operator.close()
        self._sessions.clear()
        self._waiting.clear()

    def _numbers(self) -> dict[str, int]:
        return {
            f"{principal}/{session}": operator.number
            for (principal, session), operator in self._sessions.items()
            if operator.number
        }

    def _look(self) -> None:
        """Report a change of the sessions, as soon as the hub knows them."""
        numbers = self._numbers()
        if numbers != self._published:
            self._published = numbers
            self._line.put(self._key, self.as_json(), None, Plane.STATE, name=self._key)

    def _changed(self, key: str, there: bool) -> None:  # noqa: FBT001 - as the line calls it
        try:
            parsed = parse_key(self._fleet, key)
        except FleetKeyError as error:
            self._faults.count("no key of the fleet", str(error))
            return
        principal, session = parsed.operator, parsed.session
        if principal is None:
            return
        place = principal, session
        known = self._sessions.get(place)
        if not there and known is not None:
            del self._sessions[place]
            known.close()
            _logger.info("%s is gone from the fleet", principal)
            self._admit_waiting()
        elif not there:
            self._waiting.pop(place, None)
        elif known is None:
            full = self._full(principal)
            if not full:
                self._admit(principal, session)
                return
            text = f"{principal} comes after {full}; end one of them first"
            self._refuse(principal, "too many sessions", text)
            if len(self._waiting) < _MOST_WAITING:
                self._waiting.setdefault(place)

    def _full(self, principal: Principal) -> str:
        """Which sessions take all places that this operator may have; empty: one is free."""
        there = [each for each, _ in self._sessions]
        if there.count(principal) >= MOST_OF_ONE:
            return f"{MOST_OF_ONE} sessions of its own"
        observing = sum(each.role is Role.OBSERVE for each in there)
        if principal.role is Role.OBSERVE and observing >= MOST_THAT_OBSERVE:
            return f"{MOST_THAT_OBSERVE} sessions that observe"
        return f"{MOST_SESSIONS} sessions" if len(there) >= MOST_SESSIONS else ""

    def _admit(self, principal: Principal, session: int) -> None:
        self._sessions[principal, session] = RemoteOperator(principal, session, self._client)
        _logger.info("%s is there, in the fleet", principal)

    def _admit_waiting(self) -> None:
        """Let the session in that waits longest for a place that is free now."""
        for principal, session in self._waiting:
            if not self._full(principal):
                del self._waiting[principal, session]
                self._admit(principal, session)
                return

    def _commanded(self, key: str, payload: bytes, attachment: bytes | None) -> None:
        try:
            principal, definition = self._read_key(key)
        except HubError as error:
            self._faults.count("no command", str(error))
            return
        if definition.name == STOP.name:
            self._stop(principal)
            return
        try:
            header = unpack(attachment)
            if self._may_come(principal, header):
                self._faults.count("no session yet", f"{principal} is not at {self._robot} yet")
                return
            self._session(principal, header).command(definition, header, payload)
        except HubError as error:
            self._refuse(principal, "command refused", f"{principal}: {error}")

    def _stop(self, principal: Principal) -> None:
        """Stop the robot, even for a message with a wrong header or without a session."""
        if not self._stops.take(1.0, self._client.loop.clock()):
            return  # the robot has been stopped just now
        _logger.warning("%s stops the robot", principal)
        self._client.publish(STOP, Stop(reason=f"{principal}, from the fleet"))

    def _asked(self, query: FleetQuery) -> None:
        try:
            principal, definition = self._read_key(query.key)
            header = unpack(query.attachment)
            operator = self._session(principal, header)
            way = FleetWay.of_query(definition.plane)
            operator.ask(
                definition,
                header,
                query.payload,
                answered=lambda frame: self._line.reply(
                    query, bytes(frame.payload), header_of(frame), way
                ),
                failed=lambda error: query.refuse(type(error).__name__, str(error)),
            )
        except HubError as error:
            self._faults.count("query refused", str(error))
            kind = NotAllowedError if isinstance(error, NotAllowedError) else None
            query.refuse(kind.__name__ if kind else "HandlerFailedError", str(error))

    def _read_key(self, key: str) -> tuple[Principal, MessageDefinition[object]]:
        """The operator and the message of a key.

        Raises:
            FleetKeyError: It is no key of the fleet.
            FleetRefusalError: The hub has no such message, or it is no command.
        """
        parsed = parse_key(self._fleet, key)
        if parsed.operator is None or parsed.robot != self._robot:
            text = f"{key} is no key of an operator at {self._robot}"
            raise FleetRefusalError(text)
        definition = self._messages.known.get(parsed.message)
        if parsed.message == STOP.name:
            definition = STOP
        if definition is None:
            text = f"no module of {self._robot} has defined {parsed.message}"
            raise FleetRefusalError(text)
        if parsed.kind is KeyKind.COMMAND and definition.plane is not Plane.COMMAND:
            text = f"{parsed.message} is no command; only modules of the robot send it"
            raise FleetRefusalError(text)
        return parsed.operator, definition

    def _session(self, principal: Principal, header: Attachment) -> RemoteOperator:
        """The session that a header names.

        Raises:
            FleetRefusalError: This operator has none of that number.
        """
        operator = self._sessions.get((principal, header.publisher))
        if operator is None:
            text = f"{principal} has no session {header.publisher} at {self._robot}"
            raise FleetRefusalError(text)
        if not operator.number:
            text = f"{principal} is not connected to the hub of {self._robot} yet"
            raise FleetRefusalError(text)
        return operator

    def _may_come(self, principal: Principal, header: Attachment) -> bool:
        """Whether the session of a header is not admitted, and may be soon.

        The first commands of a console overtake the token of its session.
        """
        place = principal, header.publisher
        operator = self._sessions.get(place)
        if operator is not None and operator.number:
            self._absent.pop(place, None)
            return False
        now = self._client.loop.clock()
        if place not in self._absent and len(self._absent) >= MOST_SESSIONS:
            self._absent.clear()
        return now - self._absent.setdefault(place, now) < _ADMITTING_S

    def _refuse(self, principal: Principal, reason: str, text: str) -> None:
        """Count it, and say why to the operator, now and then."""
        self._faults.count(reason, text)
        who, now = str(principal), self._client.loop.clock()
        if now - self._said.get(who, -math.inf) < _REFUSAL_S:
            return
        if len(self._said) >= MOST_SESSIONS:
            self._said.clear()
        self._said[who] = now
        key = FleetKey(kind=KeyKind.REFUSAL, robot=self._robot, operator=principal)
        self._line.put(key.under(self._fleet), text.encode(), None, Plane.STATE)


def header_of(frame: frames.Frame) -> bytes:
    """The header of an answer."""
    return Attachment(
        publisher=frame.publisher,
        fingerprint=frame.fingerprint,
        sequence=frame.sequence,
        stamp_ns=frame.stamp_ns,
        name=frame.name,
    ).pack()
