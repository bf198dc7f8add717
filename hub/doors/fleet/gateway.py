"""A robot in its fleet: the keys of the robot, while its hub answers."""

from __future__ import annotations

import logging
import time

from hub.bucket import Bucket
from hub.doors.fleet.broadcast import FleetBroadcast
from hub.doors.fleet.hub_messages import HubMessages
from hub.doors.fleet.operators import FleetOperators, header_of
from hub.doors.pads import FOR_CONSOLES
from hub.errors import FleetKeyError
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.transport.fault_counter import FaultCounter
from hub.robots.fleet_table import FleetTable
from hub.zenoh.attachment import CLOCK
from hub.zenoh.fleet_keys import VERSION, FleetKey, KeyKind, parse_key, pattern
from hub.zenoh.fleet_line import FleetDeclared, ZenohFleetLine
from hub.zenoh.fleet_session import FleetQuery, FleetWay

_logger = logging.getLogger(__name__)

_LOOK_S = 0.2
_TAKEN_S = 2.0
"""Time between two looks whether another robot has the name [s]."""
_LAST_S = 2.0
"""Longest time for the last value of a message [s]."""
_LAST_PER_S = 200.0


class FleetGateway:
    """Joins a hub with its fleet."""

    def __init__(self, client: Client, robot: str, table: FleetTable) -> None:
        """Begin; the client's loop does the rest.

        Args:
            client: The gateway's connection to the robot's hub.
            robot: Name of the robot.
            table: How it joins the fleet.
        """
        self._client = client
        self._fleet, self._robot, self._thin_hz = table.fleet, table.name or robot, table.thin_hz
        self._line = ZenohFleetLine(table.place, table.client_settings(self._robot), client)
        self._faults = FaultCounter(_logger, time.monotonic)
        self._lasts = Bucket(_LAST_PER_S, _LAST_PER_S)
        self._messages = HubMessages(client, self._learnt)
        self._broadcasts: list[FleetBroadcast] = []
        self._waiting: list[MessageDefinition[object]] = []
        self._operators: FleetOperators | None = None
        self._alive: FleetDeclared | None = None
        self._next_look, self._said_taken, self._dropped = 0.0, False, 0
        self._timer = client.every(_LOOK_S, self._look)

    def finish(self) -> None:
        """Leave the fleet."""
        self._timer.cancel()
        if self._operators is not None:
            self._operators.close()
        for broadcast in self._broadcasts:
            broadcast.close()
        self._line.close()

    def _key(self, kind: KeyKind) -> str:
        return FleetKey(kind=kind, robot=self._robot).under(self._fleet)

    def _look(self) -> None:
        """Be there while the hub answers."""
        if self._operators is None:
            self._begin()
            return
        if self._line.dropped > self._dropped:
            self._dropped = self._line.dropped
            text = f"{self._dropped} in all, because too many waited or they were too old"
            self._faults.count("dropped between hub and fleet", text)
        if self._client.connected and self._alive is None:
            self._alive = self._line.declare_token(self._key(KeyKind.ALIVE))
        elif not self._client.connected and self._alive is not None:
            self._alive.withdraw()
            self._alive = None

    def _begin(self) -> None:
        """Declare the keys, once a router answers and no other robot has the name."""
        now = self._client.loop.clock()
        if not self._line.connected or now < self._next_look:
            return
        self._next_look = now + _TAKEN_S
        if self._line.tokens(self._key(KeyKind.ALIVE), timeout=1.0):
            if not self._said_taken:
                _logger.error(
                    "another robot of the fleet %s has the name %s already; give one of them "
                    "another: [fleet] name",
                    self._fleet,
                    self._robot,
                )
            self._said_taken = True
            return
        line, robot = self._line, self._robot
        definitions = self._key(KeyKind.DEFINITIONS)
        line.respond_at_once(
            self._key(KeyKind.CLOCK), lambda: CLOCK.pack(int(time.monotonic() * 1e9))
        )
        line.respond(
            definitions, lambda query: query.answer(self._messages.as_json(), key=definitions)
        )
        line.respond(pattern(self._fleet, KeyKind.LAST, robot=robot), self._last)
        self._operators = FleetOperators(
            self._client, line, self._messages, self._faults, fleet=self._fleet, robot=robot
        )
        for definition in self._waiting:
            self._offer(definition)
        self._waiting.clear()
        _logger.info("%s is in the fleet %s", self._robot, self._fleet)

    def _learnt(self, definition: MessageDefinition[object]) -> None:
        if self._operators is None:
            self._waiting.append(definition)
            return
        self._offer(definition)
        key = self._key(KeyKind.DEFINITIONS)
        self._line.put(key, self._messages.as_json(), None, Plane.PICTURE, name=key)

    def _offer(self, definition: MessageDefinition[object]) -> None:
        if definition.plane is Plane.COMMAND and definition.name not in FOR_CONSOLES:
            return
        self._broadcasts.append(
            FleetBroadcast(
                self._client,
                self._line,
                definition,
                fleet=self._fleet,
                robot=self._robot,
                thin_hz=self._thin_hz,
            )
        )

    def _last(self, query: FleetQuery) -> None:
        """Answer with the last value of a message."""
        try:
            # Who asks all robots at once writes "*" in place of a name.
            asked = query.key.replace(f"/{VERSION}/*/", f"/{VERSION}/{self._robot}/", 1)
            name = parse_key(self._fleet, asked).message
        except FleetKeyError as error:
            self._faults.count("no key of the fleet", str(error))
            query.refuse("HandlerFailedError", str(error))
            return
        definition = self._messages.known.get(name)
        if definition is None:
            query.refuse("NoValueError", f"no module of {self._robot} has defined {name}")
        elif not self._lasts.take(1.0, self._client.loop.clock()):
            query.refuse("HandlerFailedError", f"{self._robot} is asked too often")
        else:
            own_key = FleetKey(kind=KeyKind.LAST, robot=self._robot, message=name)
            way = FleetWay.STATE if definition.plane is Plane.STATE else FleetWay.BULK
            self._client.query_payload(
                definition,
                None,
                timeout=_LAST_S,
                answered=lambda frame: self._line.reply(
                    query,
                    bytes(frame.payload),
                    header_of(frame),
                    way,
                    key=own_key.under(self._fleet),
                ),
                failed=lambda error: query.refuse(type(error).__name__, str(error)),
            )
