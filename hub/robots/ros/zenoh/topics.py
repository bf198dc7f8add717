"""What a line subscribes to and publishes, across sessions."""

from __future__ import annotations

import math
import os
import time
from collections import deque
from collections.abc import Callable
from typing import Final

from hub.errors import RosMessageError
from hub.robots.ros.line import Payload, RosMessage, RosTopic
from hub.robots.ros.zenoh.token_graph import TokenGraph
from hub.ros.publisher_clocks import PublisherClocks
from hub.ros.rmw_zenoh import (
    GID_BYTES,
    HASH_OF_HUMBLE,
    Endpoint,
    Entity,
    EntityKind,
    MessageOrigin,
    QualityOfService,
    unpack_origin,
)
from hub.ros.type_hashes import type_hash
from hub.values import dataclass
from hub.zenoh.session import ZenohDeclared, ZenohPublisher, ZenohSample, ZenohSession

LARGE_BYTES: Final = 16_384
"""Of messages from here on, only the newest waits [bytes]."""
MOST_WAITING: Final = 64
"""Most messages of a topic that wait for the line's thread."""
MOST_HISTORY: Final = 16
"""Most messages of before that are asked of each publisher."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeOfLine:
    """Who a line is among the nodes.

    Attributes:
        domain: Domain of ROS.
        name: Name of its node.
    """

    domain: int
    name: str

    def declare(
        self, session: ZenohSession, number: int, kind: EntityKind, end: Endpoint | None
    ) -> ZenohDeclared:
        """Announce the node, or what it has."""
        entity = Entity(
            session=session.zid, number=number, kind=kind, node_name=self.name, endpoint=end
        )
        return session.declare_token(entity.token(self.domain))


class TopicSubscription:
    """A topic that is subscribed to; it is declared as soon as a node publishes it."""

    def __init__(self, name: str, take: Callable[[RosMessage], None], number: int) -> None:
        self._name, self._take, self._number = name, take, number
        self._end: Endpoint | None = None
        self._declared: list[ZenohDeclared] = []
        self._waiting: deque[tuple[float, ZenohSample]] = deque(maxlen=MOST_WAITING)

    def fit(
        self,
        session: ZenohSession,
        node: NodeOfLine,
        graph: TokenGraph,
        clock: Callable[[], float],
        wake: Callable[[], None],
    ) -> None:
        """Declare what the graph now asks for."""
        ends = graph.endpoints(EntityKind.PUBLISHER, self._name)
        if not ends:
            return  # what is declared stays: its publisher may come back
        latched = any(each.quality.latched for each in ends)
        depth = max(each.quality.depth for each in ends)
        wanted = Endpoint(
            name=self._name,
            type=ends[0].type,
            hash=ends[0].hash,
            quality=QualityOfService(
                reliable=all(each.quality.reliable for each in ends),
                latched=latched,
                depth=min(max(depth, 1), MOST_HISTORY),
            ),
        )
        if wanted == self._end:
            return
        self.leave()
        self._end = wanted

        def came(sample: ZenohSample) -> None:
            if len(sample.payload) >= LARGE_BYTES:
                self._waiting.clear()
            self._waiting.append((clock(), sample))
            wake()

        # Without the token, publishers of some versions use other keys for large messages.
        self._declared.append(node.declare(session, self._number, EntityKind.SUBSCRIBER, wanted))
        pattern = f"{wanted.key(node.domain).rpartition('/')[0]}/*"
        history = wanted.quality.depth if latched else 0
        self._declared.append(session.subscribe(pattern, came, history=history))

    def deliver(self, graph: TokenGraph, clocks: PublisherClocks) -> int:
        """Hand over what waits; returns how many messages made no sense."""
        faults = 0
        for _ in range(len(self._waiting)):
            try:
                arrived, sample = self._waiting.popleft()
            except IndexError:  # a large message has just taken the place of all before
                break
            topic = graph.graph.topics.get(self._name)
            try:
                origin = unpack_origin(sample.attachment)
            except RosMessageError:
                faults += 1
                continue
            if topic is None:
                topic = self._last_known()
            age = clocks.age(origin, arrived)
            if self._end is not None and self._end.quality.latched:
                age = math.nan  # it may be one of before
            message = RosMessage(
                payload=sample.payload,
                topic=topic,
                arrived=arrived,
                age=age,
                time_ns=origin.stamp_ns,
            )
            self._take(message)
        return faults

    def leave(self) -> None:
        """Subscribe no more, or to declare it again."""
        for each in self._declared:
            each.undeclare()
        self.forget()

    def forget(self) -> None:
        """Its session is gone."""
        self._declared.clear()
        self._end = None

    def _last_known(self) -> RosTopic:
        return RosTopic(
            name=self._name,
            schema_name=self._end.type if self._end is not None else "",
            encoding="cdr",
        )


class TopicPublication:
    """A topic that is advertised."""

    def __init__(self, name: str, type_name: str, number: int) -> None:
        self._name, self._type, self._number = name, type_name, number
        self._end: Endpoint | None = None
        self._token: ZenohDeclared | None = None
        self._publisher: ZenohPublisher | None = None
        self._gid = os.urandom(GID_BYTES)
        self._sequence = 0

    @property
    def end(self) -> Endpoint | None:
        """As it is declared; None: it is not."""
        return self._end

    def fit(self, session: ZenohSession, node: NodeOfLine, graph: TokenGraph) -> None:
        """Declare what the graph now asks for: the hash is that of those who subscribe."""
        ends = graph.endpoints(EntityKind.SUBSCRIBER, self._name)
        hashes = [each.hash for each in ends if each.type == self._type]
        own = HASH_OF_HUMBLE if graph.is_humble else type_hash(self._type)
        wanted = hashes[0] if hashes else own
        if not wanted or (self._end is not None and self._end.hash == wanted):
            return
        self.leave()
        self._end = Endpoint(name=self._name, type=self._type, hash=wanted)
        self._token = node.declare(session, self._number, EntityKind.PUBLISHER, self._end)
        self._publisher = session.publisher(self._end.key(node.domain), urgent=True)

    def put(self, payload: Payload) -> bool:
        """Publish; returns whether there is somewhere to."""
        if self._publisher is None:
            return False
        self._sequence += 1
        origin = MessageOrigin(sequence=self._sequence, stamp_ns=time.time_ns(), gid=self._gid)
        return self._publisher.put(payload, origin.pack())

    def leave(self) -> None:
        """Publish no more, or to declare it again."""
        if self._token is not None:
            self._token.undeclare()
        if self._publisher is not None:
            self._publisher.undeclare()
        self.forget()

    def forget(self) -> None:
        """Its session is gone."""
        self._end = self._token = self._publisher = None
