"""The parts of a client, and the order of their actions when the connection changes."""

from __future__ import annotations

import collections
import logging
from collections.abc import Callable, Sequence
from typing import Any

from hub.errors import CodecError, HubError, NotAllowedError, RedefinedMessageError
from hub.ipc import endpoints
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.codegen import Buffer
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.connection import LOST_S, Connection
from hub.ipc.node.direct_queries import DirectRequester, DirectResponder
from hub.ipc.node.directory import Directory
from hub.ipc.node.pending_queries import PendingQueries
from hub.ipc.node.publishers import Publishers
from hub.ipc.node.responders import Responders
from hub.ipc.node.subscriptions import Subscriptions
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.security.token import Token
from hub.ipc.transport import file_descriptors
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.wire import control, definition_listing, frames

_CHECK_S = 1.0
_LAST_S = 2.0
_REPORT_ENTRIES = 1000
_HANDSHAKE_S = 0.5
"""Longest wait of `close` for handshakes under way [s]."""


class Session:
    """The parts of one client.

    Attributes:
        connection: To central.
        publishers: All messages that it publishes.
        subscriptions: All messages that it subscribes to.
        pending_queries: Its queries under way.
        responders: The queries that it answers.
        directory: Central's list of peers.
        addresses: Of each plane, in and out; empty before the first connection.
        refused: Why central refused a definition, by message name.
    """

    def __init__(
        self,
        name: str,
        endpoint: str,
        *,
        transport: ClientTransport,
        keys: ClientKeys | Token | None,
        near: bool,
    ) -> None:
        self.refused: dict[str, HubError] = {}
        self.directory: Directory | None = None
        self._name = name
        self._endpoint = endpoint
        self._transport = transport
        self._clock = transport.clock
        self._definitions: dict[str, MessageDefinition[Any]] = {}
        self._confirmed: set[str] = set()
        self._attached: collections.Counter[str] = collections.Counter()
        self._next_check = 0.0
        self.connection = Connection(
            name,
            endpoint,
            owner=self,
            transport=transport,
            keys=keys,
            near=near,
        )
        self.publishers = Publishers(transport, self.connection)
        self.subscriptions = Subscriptions(transport, self.connection)
        self.pending_queries = PendingQueries(self.connection, self._clock)
        self.responders = Responders(
            name, self.connection, self.pack, self.publishers.last, self._clock
        )
        self.direct_responder: DirectResponder | None = None
        self.addresses: tuple[str, ...] = ()
        self._plane_addresses: tuple[list[str], bool, bool] | None = None
        self._last_names: set[str] = set()
        self._frame_actions: dict[type, Callable[[Any, bytes | None], object]] = {
            control.Query: self.responders.answer,
            control.Response: self._on_answer,
            control.Failure: self._on_answer,
        }
        self._actions: dict[type, Callable[[Any], object]] = {
            control.Last: self.responders.answer_last,
            control.DirectRoute: self._on_direct_route,
            control.Defined: self._on_defined,
            control.Advertised: self.publishers.advertised,
            control.Subscribed: self.subscriptions.subscribed,
            control.Subscriber: self.publishers.subscriber,
            control.Refused: self._on_refused,
        }

    @property
    def defined(self) -> bool:
        """Whether central has confirmed all definitions of this client."""
        return self._confirmed.issuperset(self._definitions)

    def define(self, definition: MessageDefinition[Any]) -> None:
        """Define a message at central.

        Raises:
            RedefinedMessageError: This client has defined it with another format.
        """
        known = self._definitions.get(definition.name)
        if known is not None and known.fingerprint != definition.fingerprint:
            both = f"{known.wire_format} and as {definition.wire_format}"
            text = f"{self._name} uses {definition.name} as {both}; keep to one"
            raise RedefinedMessageError(text)
        if known is None:
            self._definitions[definition.name] = definition
            if self.connection.publisher:
                self.connection.send(definition_listing.to_listing(definition))

    @property
    def pending(self) -> bool:
        """Whether received messages wait for handlers, or messages wait to be sent."""
        return self.subscriptions.receive_queue.pending or self.publishers.pending

    def due(self, otherwise: float) -> float:
        """Time of the next work without input [s]."""
        wake = min(otherwise, self.connection.due(otherwise), self._next_check)
        return self.pending_queries.due(wake)

    def turn(self) -> None:
        """Do the work that is due."""
        if self.publishers.pending:
            self.publishers.flush()
        self.subscriptions.receive_queue.turn()
        self.connection.turn()
        self.pending_queries.expire(now := self._clock(), self._endpoint)
        if now >= self._next_check:
            self._check(now)

    def stalled(self, time: float, slept: float) -> None:
        """Drop old messages in the sockets, but keep events, after a stall; see `Participant`."""
        self.subscriptions.receive_queue.stood_still(slept)
        self.connection.hub_time.stood_still(slept)
        if time > LOST_S and self.connection.publisher:
            self.subscriptions.take_events()
            self.connection.start_over(f"{self._name} did not listen for {time:.1f} s")
        else:
            self.subscriptions.drop_pictures()

    def welcomed(self, message: control.Welcome, *, is_new: bool, same_run: bool) -> None:
        """Announce everything at a new central."""
        if is_new:
            # Messages in the old connections are from before central forgot this client.
            self._confirmed.clear()
            self.refused.clear()
            addresses = self.connection.addresses(message)
            if message.near:
                # Other clients connect here. ZeroMQ ends a process without free descriptors.
                file_descriptors.allow_many()
            self._leave_planes()
            self._plane_addresses = (addresses, message.near, same_run)
            self.addresses = tuple(addresses)
            if self.publishers.used or self.subscriptions.used:
                self.enter_planes()
            self._open_direct_responder(near=message.near)
        for definition in self._definitions.values():
            self.connection.send(definition_listing.to_listing(definition))
        if is_new:
            self.publishers.advertise_all()
            self.subscriptions.subscribe_all()
            for name in self._last_names:
                self.pending_queries.ask_last(name, _LAST_S, self.subscriptions.accept)
            self.responders.announce_all()
            if self.directory is not None:
                self.directory.ask_again()

    def ask_last(self, name: str) -> None:
        """Ask for the last value of a message, now and at each new central."""
        self._last_names.add(name)
        if self.connection.publisher:
            self.pending_queries.ask_last(name, _LAST_S, self.subscriptions.accept)

    def enter_planes(self) -> None:
        """Connect to the inputs and outputs of the planes, once.

        This happens at the first publication or subscription. A client that only asks needs no
        broadcasts, and would often leave in the middle of these handshakes.
        """
        if self._plane_addresses is not None:
            addresses, near, same_run = self._plane_addresses
            self._plane_addresses = None
            self.publishers.connect(addresses[0::2])
            self.subscriptions.connect(addresses[1::2], near=near, same_run=same_run)

    def _leave_planes(self) -> None:
        self._plane_addresses = None
        self.publishers.disconnect()
        self.subscriptions.disconnect()

    def lost(self, why: str) -> None:
        """Drop all waiting messages after the loss of central: they would be old at its return."""
        self._confirmed.clear()
        self._leave_planes()
        self._close_direct_requesters()
        self.pending_queries.end_all(why)

    def close(self) -> None:
        """Free all resources."""
        self._plane_addresses = None
        if self.connection.publisher:
            self._transport.handshakes.wait(_HANDSHAKE_S)
        self._close_direct_requesters()
        self._open_direct_responder(near=False)
        self.publishers.close()
        self.subscriptions.disconnect()
        self.connection.close()

    def on_control_message(self, message: Any, attached: bytes | None) -> None:
        """Handle a control message about anything but the connection."""
        kind = type(message)
        if kind in self._frame_actions:
            self._frame_actions[kind](message, attached)
        elif kind in self._actions:
            self._actions[kind](message)
        elif self.directory is not None:
            self.directory.on_control_message(message)

    def _on_answer(
        self, message: control.Response | control.Failure, attached: bytes | None
    ) -> None:
        if not self.pending_queries.conclude(message, attached, self._message_info):
            # The query ended with an error of its own: this is news for logs of modules only.
            text = "its query had ended before"
            self._transport.faults.count("late answer", text, level=logging.INFO)

    def _on_defined(self, message: control.Defined) -> None:
        self._confirmed.add(message.name)

    def _on_refused(self, message: control.Refused) -> None:
        if self.directory is not None and self.directory.on_control_message(message):
            return
        kind = NotAllowedError if message.error == "NotAllowedError" else RedefinedMessageError
        self.refused[message.subject] = kind(message.text)
        self._transport.faults.count("refused by central", message.text)

    def _open_direct_responder(self, *, near: bool) -> None:
        """Take queries directly if central is on this machine."""
        if near and self.direct_responder is None:
            self.direct_responder = DirectResponder(
                self.connection.client, self.responders.answer_directly, self._transport
            )
        elif not near and self.direct_responder is not None:
            self.direct_responder.close()
            self.direct_responder = None
        self.responders.use_direct_responder(self.direct_responder)

    def _on_direct_route(self, message: control.DirectRoute) -> None:
        """Set the direct route of a query by central's order; without an address, remove it."""
        known = self.pending_queries.requesters()
        requester = next((each for each in known if each.address == message.address), None)
        if requester is None and endpoints.is_direct_address(message.address):
            requester = DirectRequester(
                message.address,
                message.ticket,
                self._transport,
                answered=self.on_control_message,
                lost=self._direct_requester_lost,
            )
        before = self.pending_queries.use_requester(message.name, requester)
        if before is not None and not before.names:
            before.close()

    def _direct_requester_lost(self, requester: DirectRequester) -> None:
        for name in tuple(requester.names):
            self.pending_queries.use_requester(name, None)
        requester.close()

    def _close_direct_requesters(self) -> None:
        for requester in self.pending_queries.requesters():
            self._direct_requester_lost(requester)

    def _check(self, now: float) -> None:
        """Do the work of about every second."""
        self._next_check = now + _CHECK_S
        self._transport.handshakes.end_finished()
        self.publishers.check()
        received = self.subscriptions.reports()[:_REPORT_ENTRIES]
        published = self.publishers.reports()[:_REPORT_ENTRIES]
        if (received or published) and self.connection.publisher:
            self.connection.send(
                control.Report(
                    received=received,
                    published=published,
                )
            )

    def pack(self, definition: MessageDefinition[Any], value: Any, measured: float) -> bytes:
        """The frame of a message in a query or an answer; these are counted apart.

        Raises:
            CodecError: The value does not fit the format, or is too long for a frame.
        """
        return self.pack_payload(definition, definition.encode(value), measured)

    def pack_payload(
        self, definition: MessageDefinition[Any], payload: Sequence[Buffer], measured: float
    ) -> bytes:
        """As `pack`, of an encoded payload.

        Raises:
            CodecError: It is too long for a frame.
        """
        self._attached[definition.name] += 1
        frame = frames.pack(
            frames.prefix(definition.name),
            publisher=self.connection.publisher,
            fingerprint=definition.fingerprint,
            sequence=self._attached[definition.name],
            stamp_ns=int((measured + self.connection.hub_time.least) * 1e9),
            payload=payload,
        )
        if len(frame) > frames.MAX_FRAME:
            text = (
                f"{definition.name} of {len(frame)} bytes is too long; {frames.MAX_FRAME} are most"
            )
            raise CodecError(text)
        return frame

    def _message_info(self, frame: frames.Frame) -> MessageInfo:
        now = self._clock()
        measured = min(now, frame.stamp_ns * 1e-9 - self.connection.hub_time.most)
        return MessageInfo(frame.publisher, frame.sequence, 0, now - measured, measured)
