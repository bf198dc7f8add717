"""The base of a client: its connection, its loop and its definitions."""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import zmq

from hub.errors import (
    CentralUnreachableError,
    HubError,
)
from hub.hub_sockets import NAMED, process_at
from hub.ipc import endpoints
from hub.ipc.definition import MessageDefinition
from hub.ipc.node.connection import LOST_S
from hub.ipc.node.directory import Directory
from hub.ipc.node.publisher import Publisher
from hub.ipc.node.session import Session
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.security.token import Token
from hub.ipc.transport import heap, sockets
from hub.ipc.transport.client_transport import ClientTransport
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.ipc.transport.timers import Timer

_logger = logging.getLogger(__name__)

T = TypeVar("T")
R = TypeVar("R")

_MAX_SOCKETS = 4096
"""One for each plane and subscriber on this machine, and a few."""
_ATTEND_S = 2.0


def _never() -> bool:
    return False


class BaseClient:
    """A connection to one central under a unique name.

    Attributes:
        name: The name.
        endpoint: Address of central.
        faults: Dropped messages, by reason.
        loop: Its loop.
        directory: Central's list of peers.
        session: Its connection, and what it publishes, subscribes to, asks and answers there.
    """

    def __init__(
        self,
        name: str,
        endpoint: str = endpoints.DEFAULT_ENDPOINT,
        *,
        clock: Callable[[], float] = time.monotonic,
        loop: Loop | None = None,
        keys: ClientKeys | Token | None = None,
        near: bool = True,
    ) -> None:
        """Start connecting; this never waits.

        Args:
            name: Unique at central.
            endpoint: Address of central.
            clock: Monotonic time [s]; that of `loop` if one is given.
            loop: The shared loop of several clients; default a loop of its own.
            keys: For a central on another machine.
            near: Whether messages between clients of this machine go past central.

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
        self.session = Session(
            name,
            self.endpoint,
            transport=ClientTransport(context=self._context, loop=self.loop, faults=self.faults),
            keys=keys,
            near=near,
        )
        self._connection = self.session.connection
        self._pending_queries = self.session.pending_queries
        self._publishers = self.session.publishers
        self._subscriptions = self.session.subscriptions
        self._responders = self.session.responders
        self.directory = Directory(self._connection, self._wait, self._attend, self.endpoint)
        self.session.directory = self.directory
        self.loop.join(self.session)

    @property
    def connected(self) -> bool:
        """Whether central has this client and answered within `LOST_S`."""
        return self._connection.alive

    @property
    def number(self) -> int:
        """This client's number at central, as in frame headers; 0 while it is not connected."""
        return self._connection.publisher

    @property
    def near(self) -> bool:
        """Whether the hub is on this machine, without a link between."""
        return self._connection.near

    @property
    def addresses(self) -> tuple[str, ...]:
        """The addresses of the hub: control, then, once connected, of each plane in and out."""
        return (self.endpoint, *self.session.addresses)

    @property
    def round_trip(self) -> float:
        """Shortest time of the last seconds for an answer of central [s]; NaN before the first."""
        return self._connection.hub_time.round_trip

    @property
    def refusal(self) -> HubError | None:
        """Why central refused the connection; None: it did not."""
        return self._connection.refusal

    @property
    def closed_by(self) -> str:
        """The client that had central disconnect this one for good; empty: none."""
        return self._connection.closed

    def wait_connected(self, timeout: float, *, give_up: Callable[[], bool] = _never) -> None:
        """Serve until this client is connected, or `give_up` says to stop waiting.

        Raises:
            CentralUnreachableError: Not connected within `timeout` [s].
            NotAllowedError: Central refuses the key.
            NameTakenError: Another live module has the name.
        """
        self._wait(
            lambda: self.connected or give_up(),
            timeout,
            self._silence,
            lambda: _raise([self.refusal]),
        )

    def _silence(self) -> str:
        """A sentence for a hub that does not answer: whether it runs, and what to do."""
        if isinstance(self._keys, Token):
            # A hub gives no answer to another token.
            return (
                f"no hub answers at {self.endpoint} to the token in {self._keys.path}; is that "
                "the file of its own token?"
            )
        if self._keys is not None:
            # A hub gives no answer to the key of another hub.
            return (
                f"no hub answers at {self.endpoint} to the key in {self._keys.path}; is that its "
                "gateway's port, and was the key made on that robot?"
            )
        if self.endpoint.startswith("tcp://"):
            return (
                f"no hub answers at {self.endpoint}; is rune-hub running there? It answers only "
                "to a token or a key: give its file with --keys"
            )
        if process := process_at(self.endpoint):
            return (
                f"the hub runs and does not answer ({endpoints.shown(self.endpoint)}, process "
                f"{process}): it hangs, or is of another version of Rune; end its process, and "
                "start it again"
            )
        if self.endpoint.startswith(NAMED):
            return (
                f"no hub answers ({endpoints.shown(self.endpoint)}); start it with `rune-hub "
                "run ROBOT`, or go to a robot elsewhere with ssh, or with --hub and --keys"
            )
        return f"no hub answers at {self.endpoint}; is rune-hub running there?"

    def wait_defined(self, timeout: float, *, give_up: Callable[[], bool] = _never) -> None:
        """Serve until central has confirmed all definitions, or `give_up` says to stop waiting.

        Raises:
            RedefinedMessageError: One is defined with another format.
            NotAllowedError: The key does not allow to define one.
            CentralUnreachableError: Central did not answer within `timeout` [s].
        """
        self._wait(
            lambda: self.session.defined or give_up(),
            timeout,
            f"the hub at {endpoints.shown(self.endpoint)} does not confirm definitions",
            lambda: _raise(self.session.refused.values()),
        )

    def wait_subscribed(self, timeout: float, *, give_up: Callable[[], bool] = _never) -> None:
        """Serve until all subscriptions are complete: later messages are not missed.

        Raises:
            CentralUnreachableError: Central did not confirm them within `timeout` [s].
        """
        self._wait(
            lambda: (self._connection.publisher and self._subscriptions.standing) or give_up(),
            timeout,
            f"the hub at {endpoints.shown(self.endpoint)} does not confirm subscriptions",
        )

    def wait_published(self, timeout: float) -> None:
        """Serve until all published messages have left, so that the client may close.

        Raises:
            CentralUnreachableError: Central did not list the subscribers within `timeout` [s].
        """
        why = f"the hub at {endpoints.shown(self.endpoint)} does not list the subscribers"
        self._wait(lambda: self.connected and not self._publishers.holding, timeout, why)

    def define(self, *definitions: MessageDefinition[Any]) -> None:
        """Define messages at central; publishing, subscribing and answering define too.

        Raises:
            RedefinedMessageError: This client has defined one with another format.
        """
        for definition in definitions:
            self.session.define(definition)

    def demand_right(self, definition: MessageDefinition[Any]) -> None:
        """Refuse a message that this client's key or name does not let it publish.

        Raises:
            NotAllowedError: The text names the role that may.
        """
        self._connection.demand_right(definition)

    def every(self, period: float, work: Callable[[], None]) -> Timer:
        """Call `work` every `period` [s]; see `Loop` for all timers and files."""
        return self.loop.every(period, work)

    def alarm(self, work: Callable[[], None]) -> Timer:
        """Call `work` once at each time that the caller sets as the timer's `due` [s]."""
        return self.loop.alarm(work)

    def when_slept(self, work: Callable[[float], None]) -> None:
        """Call `work` with the time [s] after each sleep of this machine, before input is read."""
        self.loop.when_slept(work)

    def post(self, work: Callable[[], None]) -> None:
        """Let the loop call `work`; the only method that any thread may call."""
        self.loop.post(work)

    def listen(self, timeout: float) -> None:
        """Wait for up to `timeout` [s], and serve messages, timers and posted work."""
        self.loop.listen(timeout)

    def close(self) -> None:
        """Send BYE, and free all resources."""
        if self._context.closed:
            return
        self.loop.leave(self.session)
        self.session.close()
        self._context.term()
        if self._own_loop:
            self.loop.close()

    def _wait(
        self,
        done: Callable[[], object],
        timeout: float,
        why: str | Callable[[], str],
        refresh: Callable[[], None] = lambda: None,
    ) -> None:
        """Serve until `done` is true.

        Raises:
            CentralUnreachableError: Not within `timeout` [s].
        """
        deadline = self._clock() + timeout
        while not done():
            refresh()
            left = deadline - self._clock()
            if left <= 0:
                raise CentralUnreachableError(why if isinstance(why, str) else why())
            self.listen(min(left, 0.1))

    def _attend(self) -> None:
        """Before a query: connect again if this client has not listened for long."""
        if self.loop.stall_time > LOST_S:
            with contextlib.suppress(HubError):  # the query itself reports it
                self.listen(0.0)
                self.wait_connected(_ATTEND_S)


def _raise(errors: Iterable[HubError | None]) -> None:
    for error in errors:
        if error is not None:
            raise error
