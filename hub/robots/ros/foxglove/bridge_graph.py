"""The topics and services that a bridge has now, within bounds; pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from hub.robots.ros.foxglove.bridge_events import BridgeGraph
from hub.robots.ros.foxglove.wire import ENCODINGS
from hub.robots.ros.line import RosGraph, RosService, RosTopic

MOST_TOPICS: Final = 5000
"""Most channels, and most services, that are kept."""
MOST_SCHEMAS: Final = 1 << 25
"""Most bytes of all definitions."""


class BridgeTopics:
    """The channels and services of a bridge.

    A topic that nodes only subscribe to may have no channel; then its type is not known. A topic
    has several channels if nodes use it with several types; the first counts that has an
    encoding of ROS.

    Attributes:
        left_out: Why some are not known; empty: all are.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Drop what a connection has advertised; a new one advertises all again."""
        self.left_out = ""
        self._channels: dict[int, RosTopic] = {}
        self._by_topic: dict[str, dict[int, None]] = {}
        self._services: dict[int, RosService] = {}
        self._publishers: dict[str, tuple[str, ...]] = {}
        self._subscribers: dict[str, tuple[str, ...]] = {}
        self._size = 0
        self._whole = False
        self._graph: RosGraph | None = None

    def graph(self, distribution: str) -> RosGraph:
        """All of it; the same object while nothing changes."""
        if self._graph is None:
            found = (self.channel(name) for name in self._by_topic)
            topics = (self._with_nodes(self._channels[each]) for each in found if each is not None)
            self._graph = RosGraph(
                distribution=distribution,
                topics={topic.name: topic for topic in (*self._without_channels(), *topics)},
                services={each.name: each for each in self._services.values()},
                whole=self._whole,
            )
        return self._graph

    def _without_channels(self) -> Iterator[RosTopic]:
        """Topics that are subscribed to only: the bridge for ROS 1 has no channels for them."""
        for name, nodes in self._subscribers.items():
            if nodes and name not in self._by_topic:
                publishers = self._publishers.get(name, ())
                yield RosTopic(name=name, subscribers=nodes, publishers=publishers)

    def _with_nodes(self, topic: RosTopic) -> RosTopic:
        publishers = self._publishers.get(topic.name, ())
        subscribers = self._subscribers.get(topic.name, ())
        if not publishers and not subscribers:
            return topic
        return dataclasses.replace(topic, publishers=publishers, subscribers=subscribers)

    def topic(self, channel: int) -> RosTopic:
        """The topic of a channel, without its nodes."""
        return self._channels[channel]

    def has(self, channel: int) -> bool:
        """Whether there is such a channel."""
        return channel in self._channels

    def channel(self, topic: str) -> int | None:
        """The number of the channel that has a topic; None: there is none."""
        channels = self._by_topic.get(topic, {})
        readable = (each for each in channels if self._channels[each].encoding in ENCODINGS)
        return next(readable, next(iter(channels), None))

    def service(self, name: str) -> tuple[int, RosService] | None:
        """A service and its number; None: there is none of this name."""
        return next((found for found in self._services.items() if found[1].name == name), None)

    def add(self, channels: Mapping[int, RosTopic]) -> None:
        """Take channels that there are from now on."""
        self.remove(channels)
        for number, topic in channels.items():
            if len(self._channels) >= MOST_TOPICS:
                self.left_out = (
                    f"the bridge has more than {MOST_TOPICS} topics; the rest is not seen"
                )
                break
            if self._size + len(topic.schema) > MOST_SCHEMAS:
                self.left_out = "the definitions of the bridge's messages take too much memory"
                break
            self._size += len(topic.schema)
            self._channels[number] = topic
            self._by_topic.setdefault(topic.name, {})[number] = None
        self._graph = None

    def remove(self, channels: Iterable[int]) -> None:
        """Forget channels."""
        for number in channels:
            topic = self._channels.pop(number, None)
            if topic is not None:
                self._size -= len(topic.schema)
                of_topic = self._by_topic[topic.name]
                del of_topic[number]
                if not of_topic:
                    del self._by_topic[topic.name]
        self._graph = None

    def add_services(self, services: Mapping[int, RosService]) -> None:
        """Take services that there are from now on."""
        for number, service in services.items():
            if len(self._services) >= MOST_TOPICS and number not in self._services:
                self.left_out = f"the bridge has more than {MOST_TOPICS} services"
                break
            self._services[number] = service
        self._graph = None

    def remove_services(self, services: Iterable[int]) -> None:
        """Forget services."""
        for number in services:
            self._services.pop(number, None)
        self._graph = None

    def connect(self, change: BridgeGraph) -> None:
        """Take the nodes that publish and subscribe."""
        for nodes, changed in (
            (self._publishers, change.publishers),
            (self._subscribers, change.subscribers),
        ):
            for topic in change.gone:
                nodes.pop(topic, None)
            for topic, names in changed.items():
                if len(nodes) < MOST_TOPICS or topic in nodes:
                    nodes[topic] = names
        # The bridge for ROS 2 sends an empty graph first, and the nodes with the next change.
        self._whole = any(self._publishers.values()) or any(self._subscribers.values())
        self._graph = None
