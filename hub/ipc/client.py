"""A module's connection to central: define, publish, subscribe, query, respond, timers, presence.

One thread owns a client and calls everything but `post`, which any thread may call. The connection
mends itself: when central comes back, the client defines, subscribes and handles again.
"""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import zmq

from hub.errors import (
    CentralUnreachableError,
    CodecError,
    HandlerFailedError,
    HubError,
    QueryError,
)
from hub.ipc import endpoints
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.codegen import Buffer
from hub.ipc.message_info import MessageInfo, decode
from hub.ipc.node.connection import LOST_S
from hub.ipc.node.directory import Directory
from hub.ipc.node.pending_queries import PendingQuery
from hub.ipc.node.publisher import Publisher
from hub.ipc.node.responders import Reply
from hub.ipc.node.session import Session
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.transport import heap, sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.ipc.transport.timers import Timer
from hub.ipc.wire import frames

_logger = logging.getLogger(__name__)

T = TypeVar("T")
R = TypeVar("R")

_MAX_SOCKETS = 4096
"""One for each plane and subscriber on this machine, and a few."""
_ATTEND_S = 2.0


def _never() -> bool:
    return False


class Client:
    """A connection to one central under a unique name.

    Attributes:
        name: The name.
        endpoint: Where central is.
        faults: What was dropped, by reason.
        loop: The loop that serves it.
        directory: What central knows of everybody.
    """

    def __init__(
        self,
        name: str,
        endpoint: str = endpoints.DEFAULT_ENDPOINT,
        *,
        clock: Callable[[], float] = time.monotonic,
        loop: Loop | None = None,
        keys: ClientKeys | None = None,
        near: bool = True,
    ) -> None:
        """Start connecting; this never waits.

        Args:
            name: Unique at central.
            endpoint: Where central is.
            clock: Monotonic time [s]; that of `loop` if one is given.
            loop: The loop of a program with several clients; default a loop of its own.
            keys: For a central on another machine.
            near: Whether messages may pass central by, to and from modules of this machine.

        Raises:
            EndpointError: The endpoint is malformed, or not on this machine and there are no keys.
        """
        heap.keep_heap()
        self.name = name
        self.endpoint = endpoints.connectable(endpoint, with_keys=keys is not None)
        self.loop = loop or Loop(clock=clock)
        self._own_loop = loop is None
        self._keys = keys
        self._clock = clock = self.loop.clock
        self.faults = FaultCounter(_logger, clock)
        self._context: sockets.Context = zmq.Context(2)
        self._context.max_sockets = _MAX_SOCKETS
        self._ready_publishers: dict[MessageDefinition[Any], Publisher] = {}
        self._session = Session(
            name,
            self.endpoint,
            context=self._context,
            loop=self.loop,
            faults=self.faults,
            keys=keys,
            near=near,
        )
        self._connection, self._pending_queries = (
            self._session.connection,
            self._session.pending_queries,
        )
        self._publishers, self._subscriptions = (
            self._session.publishers,
            self._session.subscriptions,
        )
        self._responders = self._session.responders
        self.directory = Directory(self._connection, self._wait, self._attend, self.endpoint)
        self._session.directory = self.directory
        self.loop.join(self._session)

    @property
    def connected(self) -> bool:
        """Whether central knows us and has answered lately."""
        return self._connection.alive

    @property
    def number(self) -> int:
        """Our number at central, as in frame headers; 0 while it does not know us."""
        return self._connection.publisher

    @property
    def near(self) -> bool:
        """Whether the hub is on this machine, and there is no link between."""
        return self._connection.near

    @property
    def round_trip(self) -> float:
        """Shortest time in the last seconds for central to answer [s]; NaN before it has."""
        return self._connection.hub_time.round_trip

    @property
    def refusal(self) -> HubError | None:
        """Why central refused to connect us, if it did."""
        return self._connection.refusal

    @property
    def closed_by(self) -> str:
        """Who had central disconnect us for good; empty if nobody."""
        return self._connection.closed

    def wait_connected(self, timeout: float, *, give_up: Callable[[], bool] = _never) -> None:
        """Serve until central has welcomed us, or `give_up` says that nobody wants it any more.

        Raises:
            CentralUnreachableError: It did not within `timeout` [s].
            NotAllowedError: It refuses our key.
            NameTakenError: Another live module has our name.
        """
        why = (
            f"no hub answers at {self.endpoint}; is rune-hub running there? A gateway answers only "
            "to a key: give its file with --keys"
        )
        if self._keys is not None:
            # To who has the key of another hub this one looks as if it were not there.
            why = (
                f"no hub answers at {self.endpoint} to the key in {self._keys.path}; is that its "
                "gateway's port, and was the key made on that robot?"
            )
        self._wait(
            lambda: self.connected or give_up(), timeout, why, lambda: _raise([self.refusal])
        )

    def wait_defined(self, timeout: float, *, give_up: Callable[[], bool] = _never) -> None:
        """Serve until central has confirmed all our definitions, or `give_up` says to stop waiting.

        Raises:
            RedefinedMessageError: One is defined with another format.
            NotAllowedError: Our key does not let us define one.
            CentralUnreachableError: Central did not answer within `timeout` [s].
        """
        self._wait(
            lambda: self._session.defined or give_up(),
            timeout,
            f"the hub at {self.endpoint} does not confirm definitions",
            lambda: _raise(self._session.refused.values()),
        )

    def wait_subscribed(self, timeout: float, *, give_up: Callable[[], bool] = _never) -> None:
        """Serve until all our subscriptions stand: nothing published from then on can be missed.

        Raises:
            CentralUnreachableError: Central did not say so within `timeout` [s].
        """
        self._wait(
            lambda: (self._connection.publisher and self._subscriptions.standing) or give_up(),
            timeout,
            f"the hub at {self.endpoint} does not confirm subscriptions",
        )

    def wait_published(self, timeout: float) -> None:
        """Serve until everything that was published has left, so that we may close.

        Raises:
            CentralUnreachableError: Central did not say within `timeout` [s] who has subscribed.
        """
        why = f"the hub at {self.endpoint} does not say who has subscribed"
        self._wait(lambda: self.connected and not self._publishers.holding, timeout, why)

    def define(self, *definitions: MessageDefinition[Any]) -> None:
        """Make messages known at central; whoever publishes, subscribes or answers defines.

        Raises:
            RedefinedMessageError: We have defined one with another format ourselves.
        """
        for definition in definitions:
            self._session.define(definition)

    def demand_right(self, definition: MessageDefinition[Any]) -> None:
        """Refuse a message that our key, or our name, does not let us publish.

        Raises:
            NotAllowedError: The text says who may.
        """
        self._connection.demand_right(definition)

    def publish(
        self, definition: MessageDefinition[T], value: T, *, measured: float | None = None
    ) -> None:
        """Broadcast to all who subscribe; never waits, lost without central.

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
        """Broadcast a payload that is encoded already; who receives it checks it."""
        self._publisher(definition).publish_payload([payload], measured)

    def has_subscribers(self, definition: MessageDefinition[Any]) -> bool:
        """Whether anybody subscribes to what we publish; known after `wait_published`."""
        return self._publisher(definition).wanted

    def subscribe(
        self,
        definition: MessageDefinition[T],
        handler: Callable[[T, MessageInfo], None],
        *,
        queue: int | None = None,
        priority: int | None = None,
        last: bool = False,
    ) -> None:
        """Call `handler` for every message of it; several handlers are called in turn.

        Args:
            definition: Which message.
            handler: Gets the value and how it came.
            queue: How many of each publisher wait at most while handlers are busy; beyond it the
                oldest are left out. Default what the definition says: the newest, or all.
            priority: Messages of higher priority are handed on first; default 0.
            last: Also ask for the last value that was published before, at each connection.
        """
        self._prepare(definition)
        self._subscriptions.subscribe(definition, handler, queue=queue, priority=priority)
        if last:
            self._session.ask_last(definition.name)

    def subscribe_payload(
        self, definition: MessageDefinition[Any], handler: Callable[[memoryview, MessageInfo], None]
    ) -> None:
        """As `subscribe`, but `handler` gets the payload as it came: to record or forward it."""
        self._prepare(definition)
        self._subscriptions.subscribe(definition, handler, raw=True)

    @property
    def lost(self) -> int:
        """Messages that did not come, of those we subscribe to; what newer ones overtook did."""
        return self._subscriptions.lost

    @property
    def unfit(self) -> dict[str, str]:
        """What was wrong first with values of each message, in a sentence by its name."""
        return self._subscriptions.unfit

    def unsubscribe(
        self,
        definition: MessageDefinition[T],
        handler: Callable[[T, MessageInfo], None] | None = None,
    ) -> None:
        """Call `handler` no longer, or none of the handlers; no error if it was not called."""
        self._subscriptions.unsubscribe(definition.name, handler)

    def last_value(self, definition: MessageDefinition[T], *, timeout: float) -> T:
        """The last value that a connected module published, also if nobody subscribed.

        Raises:
            QueryError: Nobody publishes it, nothing was published yet, or the time ran out.
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
        """Answer queries of `request`; a HubError from the handler is told to who asked."""
        self.respond_later(request, response, lambda value, reply: reply.answer(handler(value)))

    def respond_later(
        self,
        request: MessageDefinition[T],
        response: MessageDefinition[R],
        handler: Callable[[T, Reply[R]], None],
    ) -> None:
        """Answer queries of `request` by a `Reply` that may be kept and answered at any time."""
        self.define(request, response)
        self._responders.add(request, response, handler)

    def stop_responding(self, request: MessageDefinition[Any]) -> None:
        """Answer queries of `request` no longer; who asks already gets an error."""
        self._responders.remove(request.name)

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
        self._pending_queries.ask(pending, self._session.pack(request, value, self._clock()))

    def query_response(
        self,
        request: MessageDefinition[T],
        value: T,
        response: MessageDefinition[R],
        *,
        timeout: float,
    ) -> R:
        """Ask and serve everything else until the answer is there.

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
        """As `query_response`, for whoever does not know what message the answer will be."""
        self._attend()
        self.define(request)
        frame = self._session.pack(request, value, self._clock())
        return self._pending_queries.ask_and_wait(request.name, frame, timeout, self.listen)

    def every(self, period: float, work: Callable[[], None]) -> Timer:
        """Call `work` every `period` [s]; see `Loop` for all timers and files."""
        return self.loop.every(period, work)

    def post(self, work: Callable[[], None]) -> None:
        """Have `work` called by the loop; the one method that any thread may call."""
        self.loop.post(work)

    def listen(self, timeout: float) -> None:
        """Wait for up to `timeout` [s] and serve what has come: messages, timers, posted work."""
        self.loop.listen(timeout)

    def close(self) -> None:
        """Say goodbye and free everything; nothing is sent afterwards."""
        if self._context.closed:
            return
        self.loop.leave(self._session)
        self._session.close()
        self._context.term()
        if self._own_loop:
            self.loop.close()

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
        """Get ready to broadcast a message or to receive it."""
        self.define(definition)
        self._session.enter_planes()

    def _publisher(self, definition: MessageDefinition[Any]) -> Publisher:
        self._prepare(definition)
        publisher = self._ready_publishers[definition] = self._publishers.of(definition)
        return publisher

    def _wait(
        self,
        done: Callable[[], object],
        timeout: float,
        why: str,
        look: Callable[[], None] = lambda: None,
    ) -> None:
        """Serve until it is `done`.

        Raises:
            CentralUnreachableError: It was not within `timeout` [s].
        """
        deadline = self._clock() + timeout
        while not done():
            look()
            left = deadline - self._clock()
            if left <= 0:
                raise CentralUnreachableError(why)
            self.listen(min(left, 0.1))

    def _attend(self) -> None:
        """Before a question: who has not listened for long is perhaps not known any more."""
        if self.loop.neglect > LOST_S:
            with contextlib.suppress(HubError):  # the question itself will say it
                self.listen(0.0)
                self.wait_connected(_ATTEND_S)


def _raise(errors: Iterable[HubError | None]) -> None:
    for error in errors:
        if error is not None:
            raise error
