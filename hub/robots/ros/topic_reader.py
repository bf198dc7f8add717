"""Reads topics of a line: decodes their messages, and keeps what cannot be read."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Final

from hub.errors import RosMessageError
from hub.plain_text import plain
from hub.robots.ros.line import RosLine, RosMessage, RosTopic
from hub.ros.decoding import RosDecoder
from hub.ros.values import RosValue

Take = Callable[[RosValue, RosMessage], None]
UNFIT: Final = (
    RosMessageError,
    TypeError,
    ValueError,
    ArithmeticError,
    LookupError,
    AttributeError,
)
"""What the values of a message raise whose type is not what its name says."""
_LONGEST: Final = 200


class TopicReader:
    """The topics of one line.

    Attributes:
        faults: Why the newest message of a topic cannot be used, by the topic's name.
    """

    def __init__(self, line: RosLine) -> None:
        self.faults: dict[str, str] = {}
        self._line = line
        self._takers: dict[str, list[Take]] = {}
        self._decoders: dict[str, tuple[RosTopic, RosDecoder]] = {}
        self._waiting: dict[str, RosMessage] = {}

    def read(self, topic: str, take: Take, *, each: bool = False) -> None:
        """Give messages of a topic to `take`; without a name do nothing.

        Args:
            topic: Its name.
            take: Gets the decoded message and how it came.
            each: Whether each message counts, at once; else only the newest, at `decode_newest`.
        """
        if not topic:
            return
        takers = self._takers.setdefault(topic, [])
        takers.append(take)
        if len(takers) == 1:
            self._line.subscribe(topic, self._decode if each else self._keep)

    def stop(self, topic: str) -> None:
        """Read a topic no more."""
        if self._takers.pop(topic, None):
            self._line.unsubscribe(topic)
            self.faults.pop(topic, None)

    def decode_newest(self) -> None:
        """Decode the newest message of each topic."""
        if self._waiting:
            waiting, self._waiting = self._waiting, {}
            for message in waiting.values():
                self._decode(message)

    def _keep(self, message: RosMessage) -> None:
        self._waiting[message.topic.name] = dataclasses.replace(
            message, payload=bytes(message.payload)
        )

    def _decode(self, message: RosMessage) -> None:
        name = message.topic.name
        try:
            value = self._decoder(message.topic).as_ros(message.payload)
            for take in self._takers.get(name, ()):
                take(value, message)
        except UNFIT as error:
            self.faults[name] = plain(str(error))[:_LONGEST]
        else:
            self.faults.pop(name, None)

    def _decoder(self, topic: RosTopic) -> RosDecoder:
        known = self._decoders.get(topic.name)
        if known is None or known[0] is not topic:
            known = self._decoders[topic.name] = topic, RosDecoder.of(topic)
        return known[1]
