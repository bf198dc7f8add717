"""The topics that a hub offers to panels, and what the hub sends while panels show them.

| topic | from |
| --- | --- |
| `/rune/NAME` | each message of the hub, unchanged |
| the usual name of ROS 2 | messages that are its types, unchanged |
| `/odom`, `/scan/NAME`, `/map` ... | what `hub.ros.standard_topics` makes of messages |
| `/scan` | the first group of range sensors |
| `/rosout` | what `events` makes of messages |
"""

from __future__ import annotations

import logging
import time
from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import Any, Final

from hub.doors.definitions import MOST_OTHERS, definitions_of
from hub.doors.panels.events import EVENTS, LOG, LOG_TOPIC, EventLog
from hub.doors.panels.wishes import CMD_VEL, TopicServer, Wishes
from hub.errors import CodecError, HubError, MessageFormatError
from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.catalog import BY_NAME, MESSAGES
from hub.gcm.mapping import MAP, MAP_REQUEST, MapRequest
from hub.gcm.providers import PROVIDED_BY
from hub.gcm.ranges import RANGES
from hub.gcm.vision import IMAGE, IMAGE_REQUEST, ImageCoding, ImageRequest
from hub.ipc.client import Client
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.message_info import Gathered, MessageInfo
from hub.ipc.ros_schema import ros2msg, ros_type
from hub.ipc.transport.timers import Timer
from hub.ipc.wire.control import Change, Presence
from hub.ipc.wire.definition_listing import from_listing
from hub.recording.live.answers import RepeatedQuestion
from hub.recording.topics import RecordedTopic
from hub.ros.standard_topics import SCAN, USUAL_NAMES, StandardTopic, standard_topics
from hub.ros.standard_topics import translated as parts_of
from hub.values import dataclass

_logger = logging.getLogger(__name__)

_SLOW_HZ: Final = 2.0
"""The last message of topics that are not faster is sent again to a panel that comes later [Hz]."""
_PASS_ON_S: Final = 0.02
"""Longest wait of a message in the door [s]."""
_MAP_S: Final = 2.0
_QUESTIONS: Final = frozenset({IMAGE.name, MAP.name})
"""Messages that are answers to questions."""
_PICTURE_FAULT: Final = "the robot makes no JPEG pictures: install Pillow on it"


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureWishes:
    """The pictures that panels get.

    Attributes:
        rate: Pictures a second of each camera.
        width_px: Largest width.
        height_px: Largest height.
    """

    rate: float = 10.0
    width_px: int = 640
    height_px: int = 480


@dataclass(frozen=True, slots=True)
class _Offer:
    """A topic that is offered.

    Attributes:
        number: Of the server.
        name: Of the topic.
        sources: The messages that it is made of.
        part: Camera or group of sensors.
    """

    number: int
    name: str
    sources: tuple[MessageDefinition[Any], ...]
    part: str = ""


class HubTopics:
    """Offers the topics, and passes messages on."""

    def __init__(
        self,
        client: Client,
        server: TopicServer,
        pictures: PictureWishes,
        described: Callable[[RobotBody], None],
    ) -> None:
        """Offer the messages of GCM.

        Args:
            client: A client that has no other subscriptions.
            server: Where panels are.
            pictures: How many, and how large.
            described: Gets each description of the robot.
        """
        self._client, self._server, self._pictures = client, server, pictures
        self._described = described
        self._offers: dict[int, _Offer] = {}
        self._own: dict[str, int] = {}
        self._made: dict[str, list[int]] = defaultdict(list)
        self._parts: tuple[StandardTopic, ...] = ()
        self._watched: frozenset[int] = frozenset()
        self._subscribed: dict[str, MessageDefinition[Any]] = {}
        self._questions: dict[tuple[str, str], RepeatedQuestion] = {}
        self._last: dict[int, tuple[bytes, int]] = {}
        self._translated: frozenset[str] = frozenset()
        self._map = b""
        self._log = EventLog()
        self._asked = False
        self._hurry: Timer | None = None
        client.gather(self._take)
        for definition in MESSAGES:
            self._offer_own(definition)
        self._log_number = self._offer(LOG_TOPIC, LOG, EVENTS)
        self._subscribe(ROBOT_DESCRIPTION)
        client.directory.watch(self._on_presence)

    @property
    def wanted(self) -> frozenset[str]:
        """The capabilities that bring what is watched."""
        names = {*self._subscribed, *(name for name, _ in self._questions)}
        found = {PROVIDED_BY[name][0] for name in names if name in PROVIDED_BY}
        return frozenset(each.value for each in found)

    def follow(self, wishes: Wishes) -> None:
        """Subscribe to what is watched now, and to nothing else."""
        self._watched = wishes.watched & self._offers.keys()
        if self._watched and self._hurry is None:
            self._hurry = self._client.every(_PASS_ON_S, self._client.take_gathered)
        elif not self._watched and self._hurry is not None:
            self._hurry.cancel()
            self._hurry = None
        offers = [self._offers[number] for number in self._watched]
        sources = {source.name: source for offer in offers for source in offer.sources}
        own = frozenset(self._own.values())
        self._translated = frozenset(
            source.name for offer in offers if offer.number not in own for source in offer.sources
        )
        for name in self._subscribed.keys() - sources.keys() - {ROBOT_DESCRIPTION.name}:
            self._client.unsubscribe(self._subscribed.pop(name))
        for name in sources.keys() - self._subscribed.keys() - _QUESTIONS:
            self._subscribe(sources[name])
        self._ask(sources)
        for number in self._last.keys() - self._watched - {self._own[ROBOT_DESCRIPTION.name]}:
            del self._last[number]
        for number in wishes.fresh & self._last.keys():
            self._server.send(number, *self._last[number])

    def look_for_others(self) -> None:
        """Offer the messages that modules have defined besides those of GCM."""
        self._asked = False
        for entry in definitions_of(self._client):
            full = len(self._own) >= len(MESSAGES) + MOST_OTHERS
            if entry.name in BY_NAME or entry.name in self._own or full:
                continue
            try:
                self._offer_own(from_listing(entry))
            except HubError as error:
                _logger.warning("%s is not offered: %s", entry.name, error)

    def _on_presence(self, presence: Presence) -> None:
        new = presence.change is Change.DEFINED and presence.message not in BY_NAME
        if (new and presence.message not in self._own) and not self._asked:
            self._asked = True
            self._client.post(self.look_for_others)

    def _offer_own(self, definition: MessageDefinition[Any]) -> None:
        """Offer a message as it is; one that has no type of ROS 2 cannot be."""
        name = USUAL_NAMES.get(definition.name, f"/rune/{definition.name}")
        if name == CMD_VEL:  # there, panels send; this is what the robot gets
            name = f"/rune/{definition.name}"
        try:
            self._own[definition.name] = self._offer(name, definition, (definition,))
        except MessageFormatError as error:
            _logger.info("%s is not offered: %s", definition.name, error)

    def _offer(
        self,
        name: str,
        definition: MessageDefinition[Any],
        sources: tuple[MessageDefinition[Any], ...],
        part: str = "",
    ) -> int:
        kind, text = ros_type(definition), ros2msg(definition)
        number = self._server.open(RecordedTopic(name, schema_name=kind, schema=text.encode()))
        self._offers[number] = _Offer(number, name, sources, part)
        return number

    def _offer_parts(self, body: RobotBody) -> None:
        """Offer what is made of messages of this body, and no more what was made of another."""
        parts = standard_topics(body)
        if parts == self._parts:
            return
        for number in (number for numbers in self._made.values() for number in numbers):
            self._server.close_topic(number)
            del self._offers[number]
        self._made.clear()
        self._parts = parts
        main = next((each for each in parts if each.source is RANGES), None)
        for each in parts:
            self._made[each.name].append(
                self._offer(each.name, each.definition, (each.source,), each.part)
            )
        if main is not None:
            self._made[main.name].append(self._offer("/scan", SCAN, (RANGES,), main.part))
        self._watched &= self._offers.keys()

    def _subscribe(self, definition: MessageDefinition[Any]) -> None:
        self._subscribed[definition.name] = definition
        try:
            self._client.subscribe_gathered(definition, definition, last=True)
        except HubError as error:
            _logger.warning("%s cannot be shown: %s", definition.name, error)

    def _ask(self, sources: Iterable[str]) -> None:
        """Begin and end the questions for pictures and maps."""
        wanted = {(MAP.name, "")} if MAP.name in sources else set()
        if IMAGE.name in sources:
            main = next((each.part for each in self._parts if each.source is IMAGE), "")
            wanted |= {
                (IMAGE.name, self._offers[number].part or main)
                for number in self._watched
                if IMAGE in self._offers[number].sources
            }
        for key in self._questions.keys() - wanted:
            self._questions.pop(key).end()
        for key in wanted - self._questions.keys():
            self._questions[key] = self._question(*key)

    def _question(self, name: str, camera: str) -> RepeatedQuestion:
        client, keep = self._client, self._keep_answer
        if name == MAP.name:
            self._map = b""
            return RepeatedQuestion(client, MAP_REQUEST, MAP, MapRequest, _MAP_S, keep)
        wishes = self._pictures
        request = ImageRequest(
            camera=camera, width_px=wishes.width_px, height_px=wishes.height_px,
            coding=ImageCoding.JPEG,
        )  # fmt: skip
        return RepeatedQuestion(
            client, IMAGE_REQUEST, IMAGE, lambda: request, 1.0 / wishes.rate, keep,
            lambda: self._server.say(_PICTURE_FAULT),
        )  # fmt: skip

    def _keep_answer(
        self,
        definition: MessageDefinition[Any],
        value: Any,  # noqa: ANN401 - any message
        info: MessageInfo,
    ) -> None:
        payload = b"".join(definition.encode(value))
        if definition is MAP:
            if payload == self._map:
                return
            self._map = payload
        self._pass_on(definition, payload, info.measured)
        if definition.name in self._translated:
            self._translate(definition, value, info.measured)

    def _take(self, messages: list[Gathered]) -> None:
        """Pass messages on."""
        for definition, payload, _, measured, _, _ in messages:
            self._pass_on(definition, payload, measured)
            name = definition.name
            if name in self._translated or definition is ROBOT_DESCRIPTION:
                try:
                    value = definition.decode(payload)
                except CodecError:
                    continue
                self._read(definition, value, measured)

    def _read(
        self,
        definition: MessageDefinition[Any],
        value: Any,  # noqa: ANN401 - any message
        measured: float,
    ) -> None:
        if definition is ROBOT_DESCRIPTION:
            self._offer_parts(value)
            self._described(value)
        if self._log_number in self._watched and definition in EVENTS:
            for entry in self._log.entries(definition, value, _date(measured) / 1e9):
                self._send(self._log_number, LOG, b"".join(LOG.encode(entry)), measured)
        self._translate(definition, value, measured)

    def _translate(
        self,
        definition: MessageDefinition[Any],
        value: Any,  # noqa: ANN401 - any message
        measured: float,
    ) -> None:
        """Send what a message holds of ROS 2, to who watches it."""
        try:
            parts = [*parts_of(definition, value)]
        except CodecError:
            return
        for name, part, content in parts:
            numbers = [each for each in self._made.get(name, ()) if each in self._watched]
            if numbers:
                payload = b"".join(part.encode(content))
                for number in numbers:
                    self._send(number, definition, payload, measured)

    def _pass_on(self, definition: MessageDefinition[Any], payload: bytes, measured: float) -> None:
        number = self._own.get(definition.name, 0)
        # The hub says once what the robot is; panels that come later get it from here.
        if number in self._watched or definition is ROBOT_DESCRIPTION:
            self._send(number, definition, payload, measured)

    def _send(
        self, number: int, definition: MessageDefinition[Any], payload: bytes, measured: float
    ) -> None:
        stamp = _date(measured)
        slow = definition.rate_hz <= _SLOW_HZ and definition.plane is Plane.STATE
        if slow and definition.keep is Keep.NEWEST and definition is not IMAGE:
            self._last[number] = payload, stamp
        self._server.send(number, payload, stamp)


def _date(measured: float) -> int:
    """A monotonic time [s] as a date [ns since the epoch]."""
    return time.time_ns() - round((time.monotonic() - measured) * 1e9)
