"""Records a hub into one or several series of files at once."""

from __future__ import annotations

import dataclasses
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from hub.gcm.capability import Capability
from hub.gcm.recording import MOST_TOPICS, LostMessages
from hub.gcm.supervision import CAPABILITY_WANTS, LEASE_S, CapabilityWants
from hub.ipc.client import Client
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.message_info import Gathered, MessageInfo
from hub.recording.live.answers import PictureQuestions, ask_for_maps
from hub.recording.live.bus_tap import BusTap, described
from hub.recording.live.ros_names import RosTopics
from hub.recording.live.series import LatchedMessage, RecordingSeries
from hub.recording.live.settings import RecordingTable
from hub.recording.topics import RecordedTopic, topic_of

T = TypeVar("T")

_LARGEST_LATCHED = 16 * 2**20
"""Longest message that begins each file [bytes]."""
_WAKES = (
    Capability.VIS_VID,
    Capability.NAV_STATE,
    Capability.PRO_MAP,
    Capability.PRO_POINTS,
)


class BusRecorder:
    """Taps a hub, and gives each message to each series.

    Attributes:
        series: The recordings that run.
        latched: The newest message of each topic that is published at changes only.
    """

    def __init__(
        self,
        client: Client,
        robot: str,
        settings: RecordingTable,
        *,
        cameras: Sequence[str] = ("",),
        added: Sequence[str] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Tap a hub.

        Args:
            client: A client for this alone.
            robot: Name of the robot in topics.
            settings: What is recorded.
            cameras: Names of the robot's cameras; "" is the main one.
            added: Names of the messages that come by `add`, and not over the hub.
            clock: Monotonic time [s].
        """
        self._client, self._robot, self._settings = client, robot, settings
        self._clock = clock
        self._ros = RosTopics(robot) if settings.ros_names else None
        self.series: list[RecordingSeries] = []
        self.latched: dict[str, LatchedMessage] = {}
        self._definitions: dict[str, MessageDefinition[Any]] = {}
        self._latched: set[str] = set()
        self._answered: dict[str, RecordedTopic] = {}
        self._before: dict[RecordingSeries | None, Counter[str]] = {}  # losses that do not count

        def taps(name: str) -> bool:
            return name not in added and self._wants(name)

        self._tap = BusTap(client, self._take, self._topic, taps, wake=settings.wake)
        PictureQuestions(client, cameras, settings.pictures, self._keep_answer)
        ask_for_maps(client, settings.maps, self._keep_answer)
        self._answers: Counter[str] = Counter()
        if settings.wake:
            client.define(CAPABILITY_WANTS)
            client.every(LEASE_S / 3.0, self._want)

    @property
    def topics(self) -> int:
        """Number of messages that it is subscribed to."""
        return len(self._tap.names)

    def lost(self, *ended: RecordingSeries) -> Counter[str]:
        """Number of messages that are in no file since `reset_losses`, by topic, largest of all.

        Args:
            ended: Series that are none of `series` any more, and count too.
        """
        lost: Counter[str] = Counter()
        for each in (*self.series, *ended):
            lost |= Counter(each.state.lost) - self._before.get(each, Counter())
        return lost + (self._unheard() - self._before.get(None, Counter()))

    def reset_losses(self) -> None:
        """Count losses from now on."""
        self._before = {each: Counter(each.state.lost) for each in self.series}
        self._before[None] = self._unheard()

    def _unheard(self) -> Counter[str]:
        """Number of messages that did not reach the tap, by topic."""
        return Counter({f"/{self._robot}/{name}": each for name, each in self._tap.lost.items()})

    def look(self) -> None:
        """Split, delete and retry what is due."""
        for each in self.series:
            each.look()

    def subscribe(self) -> None:
        """Subscribe to what is defined now.

        Raises:
            HubError: The hub does not answer.
        """
        self._tap.look()

    def take_now(self) -> None:
        """Give the series all messages until now."""
        self._client.take_gathered()

    def close(self) -> None:
        """Disconnect; the series stay."""
        self._tap.close()

    def _wants(self, name: str) -> bool:
        return self._settings.chooses(f"/{self._robot}/{name}")

    def _take(self, messages: list[Gathered]) -> None:
        """Give messages to each series, under the topics that are their labels."""
        if self._ros is not None:
            messages = [each for one in messages for each in self._in_ros_names(self._ros, one)]
        for each in self.series:
            each.add_all(messages)
        newest = {message[0].name: message for message in messages}
        for name in newest.keys() & self._latched:
            topic, payload, _, measured, number, length = newest[name]
            if length <= _LARGEST_LATCHED:
                self.latched[name] = LatchedMessage(topic, payload, measured, number)

    def _in_ros_names(self, ros: RosTopics, message: Gathered) -> Iterator[Gathered]:
        """A message under the topics that ROS 2 has for it."""
        topic, payload, came, measured, number, length = message
        definition = self._definitions[topic.name]
        latched = topic.name in self._latched
        for other, part in ros.translated(definition, payload):
            if latched:
                self._latched.add(other.name)
            yield other, part, came, measured, number, len(part)
        named = ros.named(definition, topic)
        if latched:
            self._latched.add(named.name)
        yield named, payload, came, measured, number, length

    def _topic(self, definition: MessageDefinition[Any]) -> RecordedTopic:
        """The topic of a message."""
        topic = topic_of(self._robot, definition)
        topic = dataclasses.replace(topic, metadata=described(definition))
        self._definitions[topic.name] = definition
        if _is_latched(definition):
            self._latched.add(topic.name)
        return topic

    def _keep_answer(self, definition: MessageDefinition[T], value: T, info: MessageInfo) -> None:
        self.add(definition, value, info.measured)

    def add(self, definition: MessageDefinition[T], value: T, measured: float) -> bool:
        """Give the series a message of this process.

        Args:
            definition: Its definition.
            value: The message.
            measured: When its content was measured, on the monotonic clock [s].

        Returns:
            Whether the settings choose it.
        """
        if not self._wants(definition.name):
            return False
        self._answers[definition.name] += 1
        number = self._answers[definition.name]
        payload = b"".join(definition.encode(value))
        topic = self._answered.get(definition.name) or self._topic(definition)
        self._answered[definition.name] = topic
        now = self._clock()
        self._take([(topic, payload, now, measured, number, len(payload))])
        return True

    def _want(self) -> None:
        wants = CapabilityWants(
            holder=self._client.name, capabilities=" ".join(_WAKES), lease_s=LEASE_S
        )
        self._client.publish(CAPABILITY_WANTS, wants)


def _is_latched(definition: MessageDefinition[Any]) -> bool:
    """Whether the last message holds until the next one comes."""
    return (
        definition.rate_hz == 0.0
        and definition.keep is Keep.NEWEST
        and definition.plane is Plane.STATE
    )


def reported(lost: Counter[str]) -> tuple[LostMessages, ...]:
    """Losses as a message has them."""
    return tuple(
        LostMessages(topic=topic[:128], count=min(count, 0xFFFF_FFFF))
        for topic, count in lost.most_common(MOST_TOPICS)
    )
