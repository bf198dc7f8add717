"""The line to nodes that meet over Zenoh, as nodes with rmw_zenoh see another node.

Zenoh calls back on its own threads. They only fill queues and wake the loop of the line's thread;
all the rest happens in `advance`.
"""

from __future__ import annotations

import contextlib
import os
import socket
import time
from collections import deque
from collections.abc import Callable
from typing import Final

from hub.robots.interfaces import FileLoop
from hub.robots.ros.address import RosAddress
from hub.robots.ros.line import (
    Payload,
    RosGraph,
    RosLineState,
    RosMessage,
    TakeAnswer,
    TakeParameters,
)
from hub.robots.ros.zenoh.parameters import ParameterQuestion
from hub.robots.ros.zenoh.router_link import RouterLink
from hub.robots.ros.zenoh.service_calls import ServiceCalls
from hub.robots.ros.zenoh.token_graph import TokenGraph
from hub.robots.ros.zenoh.topics import NodeOfLine, TopicPublication, TopicSubscription
from hub.ros.publisher_clocks import PublisherClocks
from hub.ros.rmw_zenoh import EntityKind, tokens_of
from hub.zenoh.session import ZenohDeclared

_MOST_TOKENS_WAITING: Final = 50_000
_MOST_TOKENS_READ: Final = 1000
"""Most tokens of one `advance`, some 10 ms; the rest waits for the next one."""
_BAD_MESSAGES: Final = (
    "messages without the attachment of rmw_zenoh came and were left out; the nodes need rmw_zenoh "
    "of 2025 or later"
)
_BAD_TOKENS: Final = "tokens that are not of rmw_zenoh came and were left out"


class ZenohLine:
    """A `RosLine` over a Zenoh router."""

    def __init__(
        self,
        address: RosAddress,
        *,
        certificates: str = "",
        node: str = "",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Connect with the first `advance`.

        Args:
            address: Where the router is.
            certificates: Folder with certificates for TLS; empty: those of the system.
            node: Name of the node that the robot's nodes see; empty: one with this process.
            clock: Monotonic time [s].
        """
        self._node = NodeOfLine(domain=address.domain, name=node or f"rune_{os.getpid()}")
        self._clock = clock
        self._tokens = TokenGraph()
        self._clocks = PublisherClocks()
        self._near, self._far = socket.socketpair()
        self._near.setblocking(False)  # noqa: FBT003 - a method of the library
        self._far.setblocking(False)  # noqa: FBT003 - a method of the library
        self._awake = self._closed = False
        self._link = RouterLink(address, clock, self._wake, certificates)
        self._calls = ServiceCalls(self._wake)
        self._subscriptions: dict[str, TopicSubscription] = {}
        self._publications: dict[str, TopicPublication] = {}
        self._declared: list[ZenohDeclared] = []
        self._news: deque[tuple[str, str, bool]] = deque(maxlen=_MOST_TOKENS_WAITING)
        self._numbers = 0
        self._dropped = self._faults = 0
        self._heard = -float("inf")
        self._notes: tuple[str, ...] = ()
        self._loop: FileLoop | None = None

    @property
    def state(self) -> RosLineState:
        """What it does."""
        return RosLineState(
            up=self._link.up,
            why=self._link.why,
            refused_since=self._link.refused_since,
            connections=self._link.connections,
            heard=max(self._link.heard, self._heard),
            dropped=self._dropped,
            faults=self._faults + self._tokens.faults,
            notes=self._notes,
        )

    @property
    def graph(self) -> RosGraph:
        """The robot's topics and services, as far as they are known now."""
        return self._tokens.graph

    def subscribe(self, topic: str, take: Callable[[RosMessage], None]) -> None:
        """Have each message of a topic from now on, as soon as a node publishes it."""
        self.unsubscribe(topic)
        self._numbers += 1

        def noted(message: RosMessage) -> None:
            self._heard = message.arrived
            take(message)

        self._subscriptions[topic] = TopicSubscription(topic, noted, self._numbers)
        self._fit()

    def unsubscribe(self, topic: str) -> None:
        """Have no more of them."""
        found = self._subscriptions.pop(topic, None)
        if found is not None:
            found.leave()

    def advertise(self, topic: str, type_name: str) -> None:
        """Be a publisher of a topic from now on."""
        self.unadvertise(topic)
        self._numbers += 1
        self._publications[topic] = TopicPublication(topic, type_name, self._numbers)
        self._fit()

    def unadvertise(self, topic: str) -> None:
        """Be one no more."""
        found = self._publications.pop(topic, None)
        if found is not None:
            found.leave()

    def encoding(self, topic: str) -> str:
        """The encoding that an advertised topic takes: "cdr"; empty: it is not declared yet."""
        found = self._publications.get(topic)
        return "cdr" if found is not None and found.end is not None else ""

    def publish(self, topic: str, payload: Payload, *, late: bool = False) -> bool:
        """Send a message of an advertised topic at once, or drop it."""
        del late  # Zenoh itself drops what cannot leave
        found = self._publications.get(topic)
        left = found is not None and self._link.up and found.put(payload)
        self._dropped += not left
        return left

    def call(self, service: str, payload: Payload, answered: TakeAnswer, timeout: float) -> None:
        """Call a service."""
        ends = self._tokens.endpoints(EntityKind.SERVER, service)
        session = self._link.session
        if session is None or not self._link.up:
            self._calls.refuse(answered, "the Zenoh router does not answer")
        elif not ends:
            self._calls.refuse(answered, f"no node has the service {service}")
        else:
            now, domain = self._clock(), self._node.domain
            self._calls.call(session, domain, ends[0], bytes(payload), answered, timeout, now)

    def ask_parameters(
        self, names: tuple[str, ...], answered: TakeParameters, timeout: float
    ) -> None:
        """Read parameters, such as "/diff_drive_controller.cmd_vel_timeout"; no names: all."""
        ParameterQuestion(self, answered, timeout).ask(names)

    def fetch(self, _name: str, answered: TakeAnswer, _timeout: float) -> None:
        """Nodes of ROS give no files."""
        answered(None, "nodes of ROS give no files; a bridge for Foxglove does")

    def reconnect(self, why: str) -> None:
        """Drop the session with all that waits in it, and open a new one at once."""
        self._link.leave(why, self._clock())
        self._forget()
        self._wake()

    def advance(self, now: float) -> None:
        """Connect if need be, receive, send what is due; never waits."""
        if self._closed:
            return
        with contextlib.suppress(BlockingIOError):
            while self._near.recv(4096):
                pass
        self._awake = False
        if self._link.advance(now):
            self._forget()
            self._join()
        if self._read_tokens():
            self._fit()
        self._calls.advance(now)
        faults = 0
        for each in tuple(self._subscriptions.values()):
            faults += each.deliver(self._tokens, self._clocks)
        self._faults += faults
        if faults:
            self._note(_BAD_MESSAGES)
        if self._tokens.faults:
            self._note(_BAD_TOKENS)

    def watch(self, loop: FileLoop, work: Callable[[], None]) -> None:
        """Have a loop call `work` whenever there is something to read."""
        self._loop = loop
        loop.watch(self._near.fileno(), work)

    def close(self) -> None:
        """Leave."""
        if self._closed:
            return
        self._closed = True
        if self._loop is not None:
            self._loop.unwatch(self._near.fileno())
        self._link.close()
        self._near.close()
        self._far.close()

    def _join(self) -> None:
        """Be a node of a new session."""
        session = self._link.session
        if session is None:
            return
        self._tokens.own = zid = session.zid
        self._declared = [
            self._node.declare(session, 0, EntityKind.NODE, None),
            session.watch_tokens(
                tokens_of(self._node.domain), lambda key, alive: self._heard_of(zid, key, alive)
            ),
        ]
        self._fit()

    def _forget(self) -> None:
        """The session is gone, with all that it had."""
        self._tokens.clear()
        self._declared = []
        for subscription in self._subscriptions.values():
            subscription.forget()
        for publication in self._publications.values():
            publication.forget()

    def _fit(self) -> None:
        session = self._link.session
        if session is None:
            return
        for subscription in self._subscriptions.values():
            subscription.fit(session, self._node, self._tokens, self._clock, self._wake)
        for publication in self._publications.values():
            publication.fit(session, self._node, self._tokens)

    def _read_tokens(self) -> bool:
        """Read waiting tokens; returns whether there were any."""
        waiting = min(len(self._news), _MOST_TOKENS_READ)
        for _ in range(waiting):
            zid, key, alive = self._news.popleft()
            if self._link.session is not None and self._link.session.zid == zid:
                self._tokens.take(key, alive=alive)
        return waiting > 0

    def _heard_of(self, zid: str, key: str, alive: bool) -> None:  # noqa: FBT001 - Zenoh calls it
        self._news.append((zid, key, alive))
        self._wake()

    def _note(self, text: str) -> None:
        if text not in self._notes:
            self._notes = (*self._notes, text)

    def _wake(self) -> None:
        if not self._awake and not self._closed:
            self._awake = True
            with contextlib.suppress(OSError):  # full, so it wakes anyhow; or just closed
                self._far.send(b"\0")
