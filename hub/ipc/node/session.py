"""What happens on a client's side of a connection, and in which order its parts hear of it."""

from __future__ import annotations

import collections
from typing import Any

from hub.errors import CodecError, HubError, NotAllowedError, RedefinedMessageError
from hub.ipc import endpoints
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.connection import LOST_S, Connection
from hub.ipc.node.direct_queries import DirectRequester, DirectResponder
from hub.ipc.node.directory import Directory
from hub.ipc.node.pending_queries import PendingQueries
from hub.ipc.node.publishers import Publishers
from hub.ipc.node.responders import Responders
from hub.ipc.node.subscriptions import Subscriptions
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.transport import file_descriptors, sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.handshakes import Handshakes
from hub.ipc.transport.loop import Loop
from hub.ipc.wire import control, definition_listing, frames

_CHECK_S = 1.0
_LAST_S = 2.0
_REPORT_ENTRIES = 1000
_HANDSHAKE_S = 0.5
"""How long who leaves waits for handshakes that are under way [s]."""


class Session:
    """The parts of one client, served by its loop.

    Attributes:
        connection: To central.
        publishers: What we publish.
        subscriptions: What we subscribe to.
        questions: What we ask.
        answers: What we answer.
        directory: What central tells of everybody.
        refused: Why central refused a definition, by message name.
    """

    def __init__(
        self,
        name: str,
        endpoint: str,
        *,
        context: sockets.Context,
        loop: Loop,
        faults: FaultCounter,
        keys: ClientKeys | None,
        near: bool,
    ) -> None:
        self.refused: dict[str, HubError] = {}
        self.directory: Directory | None = None
        self._name = name
        self._endpoint = endpoint
        self._clock = loop.clock
        self._faults = faults
        self._definitions: dict[str, MessageDefinition[Any]] = {}
        self._confirmed: set[str] = set()
        self._attached: collections.Counter[str] = collections.Counter()
        self._next_check = 0.0
        self.connection = Connection(
            name,
            endpoint,
            owner=self,
            context=context,
            loop=loop,
            faults=faults,
            keys=keys,
            near=near,
        )
        self._handshakes = Handshakes()
        self.publishers = Publishers(context, loop, self.connection, faults, self._handshakes)
        self.subscriptions = Subscriptions(context, loop, self.connection, faults, self._handshakes)
        self.pending_queries = PendingQueries(self.connection, self._clock)
        self.responders = Responders(
            name, self.connection, self.pack, self.publishers.last, self._clock
        )
        self._context = context
        self._loop = loop
        self._door: DirectResponder | None = None
        self._way_in: tuple[list[str], bool, bool] | None = None
        self._lasts: set[str] = set()

    @property
    def defined(self) -> bool:
        """Whether central has confirmed all our definitions."""
        return self._confirmed.issuperset(self._definitions)

    def define(self, definition: MessageDefinition[Any]) -> None:
        """Make a message known at central.

        Raises:
            RedefinedMessageError: We have defined it with another format ourselves.
        """
        known = self._definitions.get(definition.name)
        if known is not None and known.fingerprint != definition.fingerprint:
            both = f"{known.format} and as {definition.format}"
            text = f"{self._name} uses {definition.name} as {both}; keep to one"
            raise RedefinedMessageError(text)
        if known is None:
            self._definitions[definition.name] = definition
            if self.connection.publisher:
                self.connection.send(definition_listing.to_listing(definition))

    @property
    def pending(self) -> bool:
        """Whether messages were taken and not handed on yet, or wait to be sent."""
        return self.subscriptions.receive_queue.pending or self.publishers.pending

    def due(self, otherwise: float) -> float:
        """When we want to be served even if nothing comes [s]."""
        wake = min(otherwise, self.connection.due(otherwise), self._next_check)
        return self.pending_queries.due(wake)

    def turn(self) -> None:
        """Do what is due."""
        if self.publishers.pending:
            self.publishers.flush()
        self.subscriptions.receive_queue.turn()
        self.connection.turn()
        self.pending_queries.expire(now := self._clock(), self._endpoint)
        if now >= self._next_check:
            self._check(now)

    def neglected(self, time: float) -> None:
        """We did not listen for long: what lies in the sockets is old, but events are events."""
        if time > LOST_S and self.connection.publisher:
            self.subscriptions.take_events()
            self.connection.start_over(f"{self._name} did not listen for {time:.1f} s")
        else:
            self.subscriptions.drop_pictures()

    def welcomed(self, message: control.Welcome, *, anew: bool, same_run: bool) -> None:
        """Central knows us."""
        if anew:
            # Central knew us no more: what lies in the old connections is from before that.
            self._confirmed.clear()
            self.refused.clear()
            addresses = self.connection.addresses(message)
            if message.near:
                # Neighbours connect to us, and ZeroMQ ends a process that has no descriptor left.
                file_descriptors.allow_many()
            self._leave_planes()
            self._way_in = (addresses, message.near, same_run)
            if self.publishers.used or self.subscriptions.used:
                self.enter_planes()
            self._open_door(near=message.near)
        for definition in self._definitions.values():
            self.connection.send(definition_listing.to_listing(definition))
        if anew:
            self.publishers.advertise_all()
            self.subscriptions.subscribe_all()
            for name in self._lasts:
                self.pending_queries.ask_last(name, _LAST_S, self.subscriptions.accept)
            self.responders.announce_all()
            if self.directory is not None:
                self.directory.ask_again()

    def ask_last(self, name: str) -> None:
        """Have the last value of a message handed on, now and whenever central is new."""
        self._lasts.add(name)
        if self.connection.publisher:
            self.pending_queries.ask_last(name, _LAST_S, self.subscriptions.accept)

    def enter_planes(self) -> None:
        """Connect to where broadcasts go in and come out, unless we have.

        Not before something is published or subscribed to: who only asks needs no broadcasts, and
        would often leave in the middle of these handshakes.
        """
        if self._way_in is not None:
            addresses, near, same_run = self._way_in
            self._way_in = None
            self.publishers.connect(addresses[0::2], near=near)
            self.subscriptions.connect(addresses[1::2], near=near, same_run=same_run)

    def _leave_planes(self) -> None:
        self._way_in = None
        self.publishers.disconnect()
        self.subscriptions.disconnect()

    def lost(self, why: str) -> None:
        """Central is gone; nothing may wait for it, because it would be old when it comes."""
        self._confirmed.clear()
        self._leave_planes()
        self._close_ways()
        self.pending_queries.end_all(why)

    def close(self) -> None:
        """Free everything."""
        self._way_in = None
        if self.connection.publisher:
            self._handshakes.wait(_HANDSHAKE_S)
        self._close_ways()
        self._open_door(near=False)
        self.publishers.close()
        self.subscriptions.disconnect()
        self.connection.close()

    def told(self, message: Any, attached: bytes | None) -> None:
        """A control message came that is not about the connection."""
        if isinstance(message, control.Query):
            self.responders.answer(message, attached)
        elif isinstance(message, (control.Response, control.Failure)):
            if not self.pending_queries.conclude(message, attached, self._reception):
                self._faults.count("late answer", "nobody waits for it any more")
        else:
            self._told_rarely(message)

    def _told_rarely(self, message: Any) -> None:
        if isinstance(message, control.Last):
            self.responders.tell_last(message)
        elif isinstance(message, control.DirectRoute):
            self._route(message)
        elif isinstance(message, control.Defined):
            self._confirmed.add(message.name)
        elif isinstance(message, control.Advertised):
            self.publishers.advertised(message)
        elif isinstance(message, control.Subscribed):
            self.subscriptions.subscribed(message)
        elif isinstance(message, control.Subscriber):
            self.publishers.subscriber(message)
        elif self.directory is not None and self.directory.told(message):
            return
        elif isinstance(message, control.Refused):
            kind = NotAllowedError if message.error == "NotAllowedError" else RedefinedMessageError
            self.refused[message.subject] = kind(message.text)
            self._faults.count("refused by central", message.text)

    def _open_door(self, *, near: bool) -> None:
        """Be asked directly as a neighbour, and only then."""
        if near and self._door is None:
            self._door = DirectResponder(
                self.connection.client,
                self.responders.answer_directly,
                context=self._context,
                loop=self._loop,
                faults=self._faults,
            )
        elif not near and self._door is not None:
            self._door.close()
            self._door = None
        self.responders.open_door(self._door)

    def _route(self, message: control.DirectRoute) -> None:
        """Central says where queries of a name may go, or that they may no longer."""
        way = next((w for w in self.pending_queries.ways() if w.address == message.address), None)
        if way is None and endpoints.is_direct_address(message.address):
            way = DirectRequester(
                message.address,
                answered=self.told,
                lost=self._way_lost,
                context=self._context,
                loop=self._loop,
                faults=self._faults,
            )
        before = self.pending_queries.follow(message.name, way)
        if before is not None and not before.names:
            before.close()

    def _way_lost(self, way: DirectRequester) -> None:
        for name in tuple(way.names):
            self.pending_queries.follow(name, None)
        way.close()

    def _close_ways(self) -> None:
        for way in self.pending_queries.ways():
            self._way_lost(way)

    def _check(self, now: float) -> None:
        """What is to be done every second or so."""
        self._next_check = now + _CHECK_S
        self._handshakes.look()
        self.publishers.check()
        received = self.subscriptions.reports()[:_REPORT_ENTRIES]
        published = self.publishers.reports()[:_REPORT_ENTRIES]
        if (received or published) and self.connection.publisher:
            self.connection.send(
                control.Report(
                    received_count=len(received),
                    received=received,
                    published_count=len(published),
                    published=published,
                )
            )

    def pack(self, definition: MessageDefinition[Any], value: Any, measured: float) -> bytes:
        """The frame of a message in a query or an answer; these are counted apart.

        Raises:
            CodecError: The value does not fit the format, or is too long for a frame.
        """
        payload = definition.encode(value)
        self._attached[definition.name] += 1
        frame = frames.pack(
            frames.prefix(definition.name),
            publisher=self.connection.publisher,
            fingerprint=definition.fingerprint,
            sequence=self._attached[definition.name],
            stamp_ns=int((measured + self.connection.hub_time.offset) * 1e9),
            payload=payload,
        )
        if len(frame) > frames.MAX_FRAME:
            text = (
                f"{definition.name} of {len(frame)} bytes is too long; {frames.MAX_FRAME} are most"
            )
            raise CodecError(text)
        return frame

    def _reception(self, frame: frames.Frame) -> MessageInfo:
        now = self._clock()
        measured = min(now, frame.stamp_ns * 1e-9 - self.connection.hub_time.offset)
        return MessageInfo(frame.publisher, frame.sequence, 0, now - measured, measured)
