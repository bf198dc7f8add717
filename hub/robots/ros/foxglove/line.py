"""A line to a robot by a bridge for Foxglove."""

from __future__ import annotations

import collections
import itertools
import math
from collections.abc import Callable, Mapping
from typing import Final

from hub.errors import RosMessageError
from hub.plain_text import plain
from hub.robots.interfaces import FileLoop
from hub.robots.ros.address import RosAddress
from hub.robots.ros.foxglove import bridge_events as events
from hub.robots.ros.foxglove import wire
from hub.robots.ros.foxglove.ages import LineAges
from hub.robots.ros.foxglove.bridge_graph import BridgeTopics
from hub.robots.ros.foxglove.connection import HUBS_DOOR, FoxgloveConnection
from hub.robots.ros.foxglove.questions import OpenQuestions
from hub.robots.ros.foxglove.refusals import BridgeRefusals
from hub.robots.ros.foxglove.subscriptions import TopicSubscriptions
from hub.robots.ros.line import (
    Payload,
    RosGraph,
    RosLineState,
    RosMessage,
    TakeAnswer,
    TakeParameters,
)

_MOST_STATUSES: Final = 8
"""Newest sentences of the bridge that are kept."""
_MOST_HANDLED: Final = 1 << 18
"""About the most bytes of messages of one `advance`; the rest waits for the next one."""
_NO_COMMANDS: Final = (
    "the bridge takes no commands: it lacks the capability clientPublish or the encodings cdr, ros1"
)


class FoxgloveLine:
    """A `RosLine`: a client of a bridge for Foxglove."""

    def __init__(self, address: RosAddress) -> None:
        """Take the bridge's address; the first `advance` connects."""
        self._connection = FoxgloveConnection(address)
        self._connection.lost = self._lost
        self._ages = LineAges()
        self._connection.answered = self._ages.answered
        self._topics = BridgeTopics()
        self._info: events.BridgeInfo | None = None
        self._encoding = ""
        self._subscriptions = TopicSubscriptions(self._topics, self._say)
        self._published: dict[str, tuple[int, str]] = {}
        self._numbers = itertools.count(1)
        self._calls: OpenQuestions[Payload] = OpenQuestions()
        self._questions: OpenQuestions[Mapping[str, object]] = OpenQuestions()
        self._statuses: collections.deque[events.BridgeStatus] = collections.deque(
            maxlen=_MOST_STATUSES
        )
        self._refusals = BridgeRefusals()
        self._called: dict[str, None] = {}
        self._fault_note = ""
        self._simulated = False  # whether the robot's times are those of a simulation
        self._dropped = self._faults = 0
        self._now = 0.0

    @property
    def state(self) -> RosLineState:
        """What it does."""
        refused = self._info is not None and self._published and not self._encoding
        own = (_NO_COMMANDS if refused else "", self._topics.left_out, self._fault_note)
        said = dict.fromkeys((*own, *(each.text for each in self._statuses)))
        return RosLineState(
            up=self._connection.up,
            why=self._connection.why,
            refused_since=self._connection.refused_since,
            connections=self._connection.made,
            heard=self._connection.heard,
            dropped=self._dropped,
            faults=self._faults,
            notes=tuple(text for text in said if text),
            refusals=self._refusals.words,
        )

    @property
    def graph(self) -> RosGraph:
        """The robot's topics and services; the same object while nothing changes."""
        return self._topics.graph(self._info.distribution if self._info is not None else "")

    def subscribe(self, topic: str, take: Callable[[RosMessage], None]) -> None:
        """Have each message of a topic from now on, as soon as the robot has the topic."""
        self._subscriptions.want(topic, take)

    def unsubscribe(self, topic: str) -> None:
        """Have no more of them."""
        self._subscriptions.drop(topic)
        self._refusals.drop(topic)

    def advertise(self, topic: str, type_name: str) -> None:
        """Be a publisher of a topic from now on."""
        before = self._published.get(topic)
        if before is None or before[1] != type_name:
            self.unadvertise(topic)
            self._published[topic] = (next(self._numbers), type_name)
            self._announce(topic)

    def unadvertise(self, topic: str) -> None:
        """Be one no more."""
        number, _ = self._published.pop(topic, (0, ""))
        self._refusals.drop(topic)
        if number and self._encoding:
            self._say(wire.unadvertise(number))

    def encoding(self, topic: str) -> str:
        """The encoding that an advertised topic takes, "cdr" or "ros1"; empty: not known yet."""
        return self._encoding if topic in self._published else ""

    def publish(self, topic: str, payload: Payload, *, late: bool = False) -> bool:
        """Send a message of an advertised topic at once, or drop it; returns whether it left."""
        number, _ = self._published.get(topic, (0, ""))
        left = (
            number != 0
            and bool(self._encoding)
            and (late or self._connection.prompt)
            and self._connection.send(wire.data(number, payload), text=False)
        )
        self._dropped += not left
        return left

    def call(self, service: str, payload: Payload, answered: TakeAnswer, timeout: float) -> None:
        """Call a service."""
        found = self._topics.service(service)
        if not self._connection.up:
            answered(None, self._connection.why or "the line is not connected")
        elif found is None:
            answered(None, f"the robot has no service {service}")
        elif self._calls.full:
            answered(None, "too many calls wait for their answers")
        else:
            number, known = found
            self._called[service] = None
            self._refusals.drop(service)
            name = next(self._numbers)
            self._calls.add(name, answered, self._now + timeout)
            encoding = known.encoding or self._encoding
            self._connection.send(wire.request(number, name, encoding, payload), text=False)

    def ask_parameters(
        self, names: tuple[str, ...], answered: TakeParameters, timeout: float
    ) -> None:
        """Read parameters."""
        if not self._can(wire.PARAMETERS) or self._questions.full:
            answered({})
            return
        name = f"rune-{next(self._numbers)}"
        self._questions.add(name, lambda values, _: answered(values or {}), self._now + timeout)
        self._say(wire.get_parameters(names, name))

    def fetch(self, name: str, answered: TakeAnswer, timeout: float) -> None:
        """Read a file of the robot."""
        if not self._can(wire.FILES):
            answered(None, "its bridge gives no files (capability assets)")
        elif self._calls.full:
            answered(None, "too many questions wait for their answers")
        else:
            number = next(self._numbers)
            self._calls.add(number, answered, self._now + timeout)
            self._say(wire.fetch_file(name, number))

    def reconnect(self, why: str) -> None:
        """Drop the connection with all that waits in it, and make a new one at once."""
        self._connection.lose(why, at_once=True)

    def advance(self, now: float) -> None:
        """Connect if need be, receive, send what is due; never waits."""
        self._now = now
        self._connection.advance(now)
        size = 0
        while size < _MOST_HANDLED and (message := self._connection.receive()) is not None:
            is_text, data = message
            size += len(data)
            self._read(memoryview(data), is_text=is_text)
        self._calls.expire(now)
        self._questions.expire(now)

    def watch(self, loop: FileLoop, work: Callable[[], None]) -> None:
        """Have a loop call `work` whenever there is something to read."""
        self._connection.watch(loop, work)

    def close(self) -> None:
        """Leave."""
        self._connection.close()
        self._lost()

    def _read(self, data: memoryview, *, is_text: bool) -> None:
        try:
            event = wire.read_text(data, self._refuse) if is_text else wire.read_binary(data)
        except RosMessageError as fault:
            self._refuse(str(fault))
            return
        if isinstance(event, events.BridgeData):
            self._pass_on(event)
        elif event is not None:
            self._note(event)

    def _pass_on(self, data: events.BridgeData) -> None:
        wanted = self._subscriptions.of(data.subscription)
        if wanted is None or wanted.topic is None:
            if not self._subscriptions.was_made(data.subscription):  # else it was on its way
                self._refuse("a message is of a subscription that was never made")
            return
        message = RosMessage(
            payload=data.payload,
            topic=wanted.topic,
            arrived=self._now,
            age=math.nan if self._simulated else self._ages.age(data.time_ns, self._now),
            time_ns=data.time_ns,
        )
        if self._refusals.words:
            self._refusals.drop(wanted.topic.name)  # the bridge serves it
        wanted.take(message)

    def _note(self, event: events.BridgeEvent) -> None:
        match event:
            case events.BridgeInfo():
                self._greet(event)
            case events.BridgeAnswer():
                self._calls.end(event.call, event.payload, event.why)
            case events.BridgeParameters():
                self._questions.end(event.question, event.values)
            case events.BridgeStatus():
                self._forget_statuses((event.id,))
                self._statuses.append(event)
                named = (*self._subscriptions.names, *self._called)
                self._refusals.note(event, self._published, named)
            case events.GoneStatuses():
                self._forget_statuses(event.ids)
                self._refusals.take_back(event.ids)
            case _:
                self._change(event)

    def _change(self, event: events.BridgeEvent) -> None:
        """Note other topics or services."""
        match event:
            case events.BridgeChannels():
                self._topics.add(event.channels)
                self._subscriptions.follow({topic.name for topic in event.channels.values()})
            case events.GoneChannels():
                self._topics.remove(event.ids)
                self._subscriptions.follow()
            case events.BridgeServices():
                self._topics.add_services(event.services)
            case events.GoneServices():
                self._topics.remove_services(event.ids)
            case events.BridgeGraph():
                self._topics.connect(event)

    def _greet(self, info: events.BridgeInfo) -> None:
        """Begin the session of a bridge, or end it if the bridge has another one."""
        if info.of_hub:
            self._connection.lose(HUBS_DOOR)
            return
        if self._info is not None and self._connection.up and info.session != self._info.session:
            # It does not list its channels again on this connection.
            self._connection.lose("the bridge began another session", at_once=True)
            return
        if self._info is None or info.session != self._info.session:
            self._ages.clear()
        self._info = info
        self._simulated = wire.SIMULATED_TIME in info.capabilities
        self._topics.clear()
        self._connection.greet()
        if self._can(wire.PUBLISHING):
            self._encoding = next((each for each in wire.ENCODINGS if each in info.encodings), "")
        for topic in self._published:
            self._announce(topic)
        if self._can(wire.GRAPH):
            self._say(wire.subscribe_graph())

    def _announce(self, topic: str) -> None:
        """Say that a topic is published, if the bridge takes messages."""
        if self._encoding:
            number, type_name = self._published[topic]
            self._say(wire.advertise(number, topic, type_name, self._encoding))

    def _can(self, capability: str) -> bool:
        info = self._info
        return self._connection.up and info is not None and capability in info.capabilities

    def _say(self, text: bytes) -> None:
        if self._connection.up:
            self._connection.send(text, text=True)

    def _forget_statuses(self, names: tuple[str, ...]) -> None:
        for each in tuple(self._statuses):
            if each.id and each.id in names:
                self._statuses.remove(each)

    def _refuse(self, reason: str) -> None:
        """Count what makes no sense; the first is described."""
        self._faults += 1
        if not self._fault_note:
            self._fault_note = f"the bridge sent what makes no sense: {plain(reason)}"

    def _lost(self) -> None:
        self._encoding = ""
        self._topics.clear()
        self._subscriptions.clear()
        self._statuses.clear()
        self._refusals.clear()
        self._called.clear()
        why = ": ".join(filter(None, ("the line was lost", self._connection.why)))
        self._calls.fail(why)
        self._questions.fail(why)
