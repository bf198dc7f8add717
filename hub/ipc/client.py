"""A module's connection to central: define, publish, subscribe, query, respond, timers, presence.

One thread owns a client and calls everything but `post`, which any thread may call. When central
comes back, the client connects, defines, subscribes and answers again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from hub.errors import (
    CodecError,
    HandlerFailedError,
    QueryError,
)
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.codegen import Buffer
from hub.ipc.message_info import Gathered, MessageInfo, decode
from hub.ipc.node.base_client import BaseClient
from hub.ipc.node.pending_queries import PendingQuery
from hub.ipc.node.publisher import Publisher
from hub.ipc.node.responders import AnswerLast, FrameReply, Reply
from hub.ipc.wire import frames

T = TypeVar("T")
R = TypeVar("R")


class Client(BaseClient):
    """A connection to one central under a unique name: publish, subscribe, ask and answer."""

    def publish(
        self, definition: MessageDefinition[T], value: T, *, measured: float | None = None
    ) -> None:
        """Send to all subscribers; never waits. Without central the message is lost.

        Args:
            definition: Which message.
            value: Its value.
            measured: When its content was measured, on the monotonic clock [s]; default now.

        Raises:
            CodecError: The value does not fit the format.
        """
        publisher = self._ready_publishers.get(definition)
        if publisher is None:
            publisher = self._publisher(definition)
        publisher.publish(value, measured)

    def publish_payload(
        self, definition: MessageDefinition[Any], payload: Buffer, *, measured: float | None = None
    ) -> None:
        """Send an encoded payload; its receivers check it."""
        self._publisher(definition).publish_payload([payload], measured)

    def forward(self, definition: MessageDefinition[Any], frame: frames.Frame) -> None:
        """Send a message of another hub, with the numbers and the time that it has there.

        Args:
            definition: Which message.
            frame: It; its stamp is on the clock of this client's hub.
        """
        self._prepare(definition)
        self._publishers.forward(definition, frame)

    def has_subscribers(self, definition: MessageDefinition[Any]) -> bool:
        """Whether the message has subscribers; known after `wait_published`."""
        return self._publisher(definition).wanted

    def subscribe(
        self,
        definition: MessageDefinition[T],
        handler: Callable[[T, MessageInfo], None],
        *,
        queue: int | None = None,
        priority: int | None = None,
        last: bool = False,
        late: Callable[[T, MessageInfo], None] | None = None,
    ) -> None:
        """Call `handler` for every message, after earlier handlers.

        Args:
            definition: Which message.
            handler: Gets the value and how it came.
            queue: Most messages of each publisher that wait for busy handlers; older ones are
                dropped. Default: the definition's choice, the newest or all.
            priority: Messages of higher priority come first; default 0.
            last: Also ask for the last published value, at each connection.
            late: Gets every message that is older than its lifespan.
        """
        self._prepare(definition)
        self._subscriptions.subscribe(definition, handler, queue=queue, priority=priority)
        if late is not None:
            self._subscriptions.subscriptions[definition.name].late = late
        if last:
            self.session.ask_last(definition.name)

    def subscribe_payload(
        self, definition: MessageDefinition[Any], handler: Callable[[Buffer, MessageInfo], None]
    ) -> None:
        """Call `handler` with the payload of every message: unchecked, of any age.

        Raises:
            RedefinedMessageError: Other handlers of this client get its values.
        """
        self._prepare(definition)
        self._subscriptions.subscribe(definition, handler, raw=True)

    def gather(self, take: Callable[[list[Gathered]], None]) -> None:
        """Receive cheaply: messages wait for some milliseconds, and come to `take` together.

        Each has the moment when it came, as far as that is known: it came since the messages before
        it, and not before it was measured. Call it before the first subscription.
        """
        self._subscriptions.gather(take)

    def subscribe_gathered(
        self, definition: MessageDefinition[Any], label: object, *, last: bool = False
    ) -> None:
        """Gather the payload of every message: unchecked, of any age, none dropped.

        Args:
            definition: Which message.
            label: What `take` knows it by.
            last: As for `subscribe`.

        Raises:
            RedefinedMessageError: Other handlers of this client get its values.
        """
        self._prepare(definition)
        self._subscriptions.subscribe_gathered(definition, label)
        if last:
            self.session.ask_last(definition.name)

    def take_gathered(self) -> None:
        """Deliver now what waits to be gathered."""
        self._subscriptions.take_gathered()

    @property
    def lost_by_message(self) -> dict[str, int]:
        """Number of subscribed messages that did not arrive, by message name."""
        return self._subscriptions.lost_by_message

    @property
    def lost(self) -> int:
        """Number of subscribed messages that did not arrive; an overtaken message did arrive."""
        return sum(self.lost_by_message.values())

    @property
    def unfit(self) -> dict[str, str]:
        """The first fault in a value of each message, in a sentence, by message name."""
        return self._subscriptions.unfit

    def unsubscribe(
        self,
        definition: MessageDefinition[T],
        handler: Callable[[T, MessageInfo], None] | None = None,
    ) -> None:
        """Remove `handler`, or all handlers; no error if there is none."""
        self._subscriptions.unsubscribe(definition.name, handler)

    def last_value(self, definition: MessageDefinition[T], *, timeout: float) -> T:
        """The last value that a connected module published, even without subscribers.

        Raises:
            QueryError: No module publishes it, no value was published yet, or the time ran out.
        """
        self._attend()
        self.define(definition)
        frame = self._pending_queries.ask_and_wait(definition.name, None, timeout, self.listen)
        try:
            value: T = decode(definition, frame)
        except CodecError as error:
            raise HandlerFailedError(str(error)) from error
        return value

    def last_notify(
        self,
        definition: MessageDefinition[T],
        *,
        timeout: float,
        answered: Callable[[T, MessageInfo], None],
        failed: Callable[[QueryError], None],
    ) -> None:
        """As `last_value`; exactly one of `answered` and `failed` is called later, by the loop."""
        self.define(definition)
        pending = self._pending_query(definition.name, definition, timeout, answered, failed)
        self._pending_queries.ask(pending, None)

    def respond(
        self,
        request: MessageDefinition[T],
        response: MessageDefinition[R],
        handler: Callable[[T], R],
    ) -> None:
        """Answer queries of `request`; a HubError of the handler goes to the asker."""
        self.respond_later(request, response, lambda value, reply: reply.answer(handler(value)))

    def respond_later(
        self,
        request: MessageDefinition[T],
        response: MessageDefinition[R],
        handler: Callable[[T, Reply[R]], None],
    ) -> None:
        """Answer queries of `request` by a `Reply`, at any later time."""
        self.define(request, response)
        self._responders.add(request, response, handler)

    def respond_frames(
        self,
        request: MessageDefinition[Any],
        handler: Callable[[frames.Frame, FrameReply], None],
    ) -> None:
        """Answer queries of `request` with frames, undecoded, at any later time."""
        self.define(request)
        self._responders.add_frames(request.name, handler)

    def respond_last(self, handler: AnswerLast) -> None:
        """Answer all questions for last values of what this client publishes."""
        self._responders.last_by = handler

    def query_notify(
        self,
        request: MessageDefinition[T],
        value: T,
        response: MessageDefinition[R],
        *,
        timeout: float,
        answered: Callable[[R, MessageInfo], None],
        failed: Callable[[QueryError], None],
    ) -> None:
        """Ask; exactly one of `answered` and `failed` is called later, by the loop."""
        self.define(request, response)
        pending = self._pending_query(request.name, response, timeout, answered, failed)
        self._pending_queries.ask(pending, self.session.pack(request, value, self._clock()))

    def query_payload(
        self,
        request: MessageDefinition[Any],
        payload: Buffer | None,
        *,
        timeout: float,
        answered: Callable[[frames.Frame], None],
        failed: Callable[[QueryError], None],
    ) -> None:
        """Ask with an encoded payload, or, with None, for the last value; pass on the frame.

        Exactly one of `answered` and `failed` is called later, by the loop.
        """
        self.define(request)
        pending = PendingQuery(
            name=request.name,
            read=lambda frame: frame,
            timeout=timeout,
            deadline=self._clock() + timeout,
            answered=lambda frame, _: answered(frame),
            failed=failed,
        )
        packed = None
        if payload is not None:
            packed = self.session.pack_payload(request, [payload], self._clock())
        self._pending_queries.ask(pending, packed)

    def query_response(
        self,
        request: MessageDefinition[T],
        value: T,
        response: MessageDefinition[R],
        *,
        timeout: float,
    ) -> R:
        """Ask, and serve everything else until the answer arrives.

        Raises:
            QueryError: No handler, it died or failed, or the time ran out.
        """
        self.define(response)
        frame = self.query_frame(request, value, timeout=timeout)
        try:
            answer: R = decode(response, frame)
        except CodecError as error:
            raise HandlerFailedError(str(error)) from error
        return answer

    def query_frame(
        self, request: MessageDefinition[T], value: T, *, timeout: float
    ) -> frames.Frame:
        """As `query_response`, for an answer of unknown type: its frame."""
        self._attend()
        self.define(request)
        frame = self.session.pack(request, value, self._clock())
        return self._pending_queries.ask_and_wait(request.name, frame, timeout, self.listen)

    def _pending_query(
        self,
        name: str,
        response: MessageDefinition[T],
        timeout: float,
        answered: Callable[[T, MessageInfo], None],
        failed: Callable[[QueryError], None],
    ) -> PendingQuery:
        return PendingQuery(
            name=name,
            read=lambda frame: decode(response, frame),
            timeout=timeout,
            deadline=self._clock() + timeout,
            answered=answered,
            failed=failed,
        )

    def _prepare(self, definition: MessageDefinition[Any]) -> None:
        """Define a message, and connect its plane."""
        self.define(definition)
        self.session.enter_planes()

    def _publisher(self, definition: MessageDefinition[Any]) -> Publisher:
        self._prepare(definition)
        publisher = self._ready_publishers[definition] = self._publishers.of(definition)
        return publisher
