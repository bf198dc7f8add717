"""The subscriptions of a line, over all its connections; pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hub.robots.ros.foxglove import wire
from hub.robots.ros.foxglove.bridge_graph import BridgeTopics
from hub.robots.ros.line import RosMessage, RosTopic
from hub.values import dataclass


@dataclass(slots=True, kw_only=True, eq=False)
class WantedTopic:
    """A topic that is wanted.

    Attributes:
        take: Takes its messages.
        topic: The topic of its channel; None: the bridge has none now.
        number: Its number on this connection.
        channel: The number of its channel.
    """

    take: Callable[[RosMessage], None]
    topic: RosTopic | None = None
    number: int = 0
    channel: int = 0


class TopicSubscriptions:
    """Topics that are wanted, and the bridge's channels that have them."""

    def __init__(self, topics: BridgeTopics, say: Callable[[bytes], object]) -> None:
        """Subscribe to nothing yet.

        Args:
            topics: What the bridge has.
            say: Sends a text to the bridge.
        """
        self._topics, self._say = topics, say
        self._wanted: dict[str, WantedTopic] = {}
        self._by_number: dict[int, WantedTopic] = {}
        self._last = 0

    def want(self, topic: str, take: Callable[[RosMessage], None]) -> None:
        """Have each message of a topic from now on."""
        self._wanted.setdefault(topic, WantedTopic(take=take)).take = take
        self.follow((topic,))

    def drop(self, topic: str) -> None:
        """Have no more of them."""
        wanted = self._wanted.pop(topic, None)
        if wanted is not None:
            self._end(wanted)

    @property
    def names(self) -> tuple[str, ...]:
        """The topics that are wanted."""
        return tuple(self._wanted)

    def of(self, number: int) -> WantedTopic | None:
        """The subscription of a number; None: it has ended."""
        return self._by_number.get(number)

    def was_made(self, number: int) -> bool:
        """Whether a number was that of a subscription at any time."""
        return 0 < number <= self._last

    def follow(self, topics: Iterable[str] | None = None) -> None:
        """Subscribe to the channels that the bridge has now.

        Args:
            topics: Those whose channels may be others than before; None: all.
        """
        made: dict[int, int] = {}
        for name in tuple(self._wanted) if topics is None else topics:
            wanted = self._wanted.get(name)
            channel = self._topics.channel(name)
            if wanted is None:
                continue
            topic = None if channel is None else self._topics.topic(channel)
            if wanted.topic is not None and (channel != wanted.channel or topic != wanted.topic):
                self._end(wanted)
            if wanted.topic is None and channel is not None:
                self._last += 1
                wanted.topic, wanted.channel, wanted.number = topic, channel, self._last
                self._by_number[self._last] = wanted
                made[self._last] = channel
        if made:
            self._say(wire.subscribe(made))

    def clear(self) -> None:
        """Note that the connection is lost; what is wanted is subscribed to on the next one."""
        for wanted in self._wanted.values():
            wanted.topic = None
        self._by_number.clear()

    def _end(self, wanted: WantedTopic) -> None:
        if wanted.topic is not None:
            wanted.topic = None
            del self._by_number[wanted.number]
            if self._topics.has(wanted.channel):  # else the bridge has ended it
                self._say(wire.unsubscribe(wanted.number))
