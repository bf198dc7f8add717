"""All messages that a client subscribes to, and their sockets."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from hub.errors import RedefinedMessageError
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.message_info import Gathered
from hub.ipc.node import publishers
from hub.ipc.node.connection import Connection
from hub.ipc.node.gathered_messages import GatheredMessages
from hub.ipc.node.receive_queue import ReceiveQueue
from hub.ipc.node.subscription import Handler, Subscription
from hub.ipc.transport import shared_ring, sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.transport.direct_inbox import DirectInbox
from hub.ipc.transport.gathering_inbox import GatheringInbox
from hub.ipc.transport.sender_tickets import SenderTickets
from hub.ipc.wire import control, frames


class Subscriptions:
    """All subscriptions of one client, and their shared sockets.

    Attributes:
        receive_queue: Messages that wait for their handlers.
    """

    def __init__(self, transport: ClientTransport, connection: Connection) -> None:
        self._transport = transport
        self._connection = connection
        self.receive_queue = ReceiveQueue(
            clock=transport.clock,
            hub_time=connection.hub_time,
            faults=transport.faults,
            no_ring=self._use_whole_payloads,
        )
        self.sockets: dict[Plane, sockets.Socket] = {}
        self.files: dict[Plane, int] = {}
        self.inboxes: dict[Plane, DirectInbox | GatheringInbox] = {}
        self._tickets = SenderTickets(transport.faults)
        self._gathered: GatheredMessages | None = None
        self.subscriptions: dict[str, Subscription] = {}
        self._under_way: dict[str, Subscription] = {}
        self._tokens = 0
        self._near = False
        self._where: dict[Plane, str] = {}

    @property
    def used(self) -> bool:
        """Whether it has subscriptions."""
        return bool(self.subscriptions)

    @property
    def unfit(self) -> dict[str, str]:
        """The first fault in a value of each message, in a sentence, by message name."""
        return {
            name: subscription.unfit
            for name, subscription in self.subscriptions.items()
            if subscription.unfit
        }

    @property
    def standing(self) -> bool:
        """Whether every subscription has reached all publishers of its message."""
        return not self._under_way

    def connect(self, addresses: Sequence[str], *, near: bool, same_run: bool) -> None:
        """Connect to the output of each plane at a new central."""
        self._tickets = SenderTickets(self._transport.faults)  # closed inboxes may be taken
        self._near = near
        self._where = dict(zip(sockets.PLANES, addresses, strict=True))
        # Commands first: they must not wait behind a burst of states.
        for plane in (Plane.COMMAND, Plane.STATE, Plane.PICTURE):
            self._connect(plane)
        if self._gathered is not None:
            self._gathered.forget()
        for subscription in self.subscriptions.values():
            if not same_run:  # else the numbers show the missed messages
                subscription.forget()
            subscription.in_ring = self._may_ring(subscription.definition)

    def drop_pictures(self) -> None:
        """Reconnect the plane of pictures: the waiting ones are old."""
        if Plane.PICTURE in self.sockets:
            self._disconnect(Plane.PICTURE)
            self._connect(Plane.PICTURE)
            for subscription in self.subscriptions.values():
                if subscription.definition.plane is Plane.PICTURE:
                    self._ask_for(subscription)

    def take_events(self) -> None:
        """Read all sockets: keep the messages of `Keep.ALL`, and drop all others."""
        for plane in tuple(self.sockets):
            if plane is not Plane.PICTURE:
                self.receive_queue.take_events(self.sockets[plane].recv)
                inbox = self.inboxes.get(plane)
                if isinstance(inbox, DirectInbox):
                    self.receive_queue.take_events(inbox.receive, commands=inbox.commands)
        self.take_gathered()

    def gather(self, take: Callable[[list[Gathered]], None]) -> None:
        """Let messages of this machine wait, and deliver them together; before a subscription."""
        self._gathered = GatheredMessages(
            self.receive_queue, self._connection.hub_time, self._transport.clock, take
        )

    def subscribe_gathered(self, definition: MessageDefinition[Any], label: object) -> None:
        """Deliver the payloads of a message with all that is gathered.

        Raises:
            RedefinedMessageError: This client has handlers that get values.
        """
        if self._gathered is None:
            text = f"{definition.name} is subscribed to before its client gathers"
            raise RedefinedMessageError(text)
        self.subscribe(definition, functools.partial(self._gathered.one, label), raw=True)
        self.subscriptions[definition.name].label = label

    def take_gathered(self) -> None:
        """Deliver now what waits."""
        inbox = self.inboxes.get(Plane.STATE)
        if isinstance(inbox, GatheringInbox):
            inbox.take_now()

    def _connect(self, plane: Plane) -> None:
        socket = sockets.make_plane(self._transport.context, zmq.SUB, plane, self._connection.proof)
        self._transport.handshakes.begin(socket)
        sockets.connect(socket, self._where[plane])
        self.sockets[plane] = socket
        self.files[plane] = self._transport.loop.register(
            socket, functools.partial(self.receive_queue.take, socket.recv)
        )
        if self._near and self._gathered is not None and plane is not Plane.PICTURE:
            # One for both: what a publisher sends stays in order, and the client wakes once.
            self.inboxes[plane] = self.inboxes.get(Plane.COMMAND) or GatheringInbox(
                self._transport, self._gathered
            )
        elif self._near:
            self.inboxes[plane] = DirectInbox(
                self._transport, plane, self.receive_queue.take, self._tickets
            )

    def subscribe_all(self) -> None:
        """Subscribe again, at a central that has the definitions."""
        for subscription in self.subscriptions.values():
            self._ask_for(subscription)

    def disconnect(self) -> None:
        """Disconnect from central; received messages are still handled."""
        for plane in tuple(self.sockets):
            self._disconnect(plane)
        self._under_way.clear()
        self.receive_queue.close_rings()

    def _disconnect(self, plane: Plane) -> None:
        self._transport.loop.unregister(self.files[plane])
        socket = self.sockets.pop(plane)
        self._transport.handshakes.end(socket)
        socket.close(0)
        inbox = self.inboxes.pop(plane, None)
        if inbox is not None:
            inbox.close()

    def subscribe(
        self,
        definition: MessageDefinition[Any],
        handler: Handler,
        *,
        queue: int | None = None,
        priority: int | None = None,
        raw: bool = False,
    ) -> None:
        """Call `handler` for every message of `definition`.

        Raises:
            RedefinedMessageError: This client has other handlers that get values, or payloads.
        """
        known = self.subscriptions.get(definition.name)
        if known is not None and known.raw != raw:
            text = (
                f"{definition.name} is subscribed to both as values and as payloads; use a client "
                "of its own for one of them"
            )
            raise RedefinedMessageError(text)
        subscription = known or Subscription(definition, raw=raw)
        subscription.handlers.append(handler)
        if queue is not None:
            subscription.limit = queue
        if priority is not None:
            subscription.priority = priority
        self.receive_queue.add(subscription)
        if known is None:
            self.subscriptions[definition.name] = subscription
            subscription.in_ring = self._may_ring(definition)
            if self._connection.publisher:
                self._ask_for(subscription)

    def unsubscribe(self, name: str, handler: Handler | None) -> None:
        """Remove `handler`, or all handlers; waiting messages are dropped."""
        subscription = self.subscriptions.get(name)
        if subscription is None:
            return
        subscription.handlers = [
            each for each in subscription.handlers if handler not in (None, each)
        ]
        if subscription.handlers:
            return
        del self.subscriptions[name]
        self.receive_queue.remove(subscription)
        if self._gathered is not None:
            self._gathered.forget()
        if self.sockets:
            self._filter(subscription, on=False)
            self._complete(subscription.token)
            self._connection.send(control.Unsubscribe(name=name))

    def subscribed(self, message: control.Subscribed) -> None:
        """Handle central's report that a subscription is complete."""
        self._complete(message.token)

    @property
    def lost_by_message(self) -> dict[str, int]:
        """Number of lost messages of each present subscription that lost some, by name."""
        return {name: each.lost for name, each in self.subscriptions.items() if each.lost}

    def reports(self) -> tuple[control.Received, ...]:
        """The receptions of each subscription since the last report."""
        made = (subscription.report() for subscription in self.subscriptions.values())
        return tuple(report for report in made if report is not None)

    def accept(self, frame: frames.Frame) -> None:
        """Handle a message from an answer, such as the last value; no command comes so."""
        subscription = self.subscriptions.get(frame.name)
        if subscription is None or (subscription.is_command and not subscription.raw):
            return
        inbox = self._inbox(subscription)
        if inbox is None or self._emptied(inbox, frame):
            self.receive_queue.accept(subscription, frame)

    def _emptied(self, inbox: DirectInbox | GatheringInbox, frame: frames.Frame) -> bool:
        """Whether an inbox is empty after a turn; else the frame is accepted in a later turn.

        Earlier messages have arrived by now; behind the frame they would count as repeated.
        """
        if isinstance(inbox, GatheringInbox):
            inbox.take_now()
            return True
        more = True
        try:
            more = inbox.take_now()
        finally:  # even after a handler that raised
            if more:
                self._transport.loop.after(0.0, functools.partial(self.accept, frame))
        return not more

    def _ask_for(self, subscription: Subscription) -> None:
        """Subscribe; central reports when the subscription is complete."""
        definition = subscription.definition
        self._under_way.pop(subscription.token, None)
        self._tokens += 1
        subscription.token = f"{self._connection.publisher}.{self._tokens}"
        self._under_way[subscription.token] = subscription
        self._filter(subscription, on=True)
        inbox = self._inbox(subscription)
        self._connection.send(
            control.Subscribe(
                name=definition.name,
                token=subscription.token,
                inbox=inbox.address if inbox else "",
                in_ring=subscription.in_ring,
                key=self._tickets.key if inbox else "",
            )
        )
        if not self._connection.may_connect(definition.plane):
            # A client that only listens cannot see its own mark come back.
            self._connection.send(control.Ready(token=subscription.token))

    def _inbox(self, subscription: Subscription) -> DirectInbox | GatheringInbox | None:
        return self.inboxes.get(
            Plane.STATE if subscription.in_ring else subscription.definition.plane
        )

    def _complete(self, token: str) -> None:
        """Withdraw the mark of a complete subscription."""
        subscription = self._under_way.pop(token, None)
        if subscription is not None:
            subscription.token = ""
            plane = subscription.definition.plane
            for topic in self._filters(subscription):
                self.sockets[plane].unsubscribe(publishers.mark(topic, token))
            self._transport.loop.touch(self.files[plane])

    def _may_ring(self, definition: MessageDefinition[Any]) -> bool:
        return self._near and shared_ring.available and definition.plane is Plane.PICTURE

    def _filter(self, subscription: Subscription, *, on: bool) -> None:
        plane = subscription.definition.plane
        socket = self.sockets[plane]
        self._transport.loop.touch(self.files[plane])
        change = socket.subscribe if on else socket.unsubscribe
        for topic in self._filters(subscription):
            change(topic)
            if on:
                socket.subscribe(publishers.mark(topic, subscription.token))

    def _filters(self, subscription: Subscription) -> list[bytes]:
        """The topics that arrive through central; without direct messages, all."""
        kinds = (frames.FAR,) if self._near else (frames.FAR, b"")
        return [frames.topic(subscription.definition.name, kind) for kind in kinds]

    def _use_whole_payloads(self, subscription: Subscription, why: str) -> None:
        """Ask for whole payloads from now on, not for descriptors."""
        if subscription.in_ring and self.sockets:
            self._transport.faults.count(
                "no shared memory", f"{subscription.definition.name}: {why}"
            )
            self._complete(subscription.token)
            self._filter(subscription, on=False)
            subscription.in_ring = False
            self._ask_for(subscription)
