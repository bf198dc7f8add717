"""Reads topics of a line: decodes their messages, and keeps what cannot be read."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Final

from hub.bucket import Bucket
from hub.errors import RosMessageError
from hub.plain_text import plain
from hub.robots.ros.line import RosLine, RosMessage
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
MOST_BYTES: Final = 1 << 18
"""Longest message that is read beside driving [bytes]; reading it takes 0.15 s at most."""
_LONGEST: Final = 200
_BYTES_PER_S, _BYTES_AT_ONCE = 4096.0, 262_144.0
_FIELDS_PER_S, _FIELDS_AT_ONCE = 100.0, 4000.0
"""Bytes and fields of new definitions: a field takes 0.2 ms, and a robot has some hundreds."""


class TopicReader:
    """The topics of one line.

    Attributes:
        faults: Why the newest message of a topic cannot be used, by the topic's name.
    """

    def __init__(self, line: RosLine) -> None:
        self.faults: dict[str, str] = {}
        self._line = line
        self._takers: dict[str, list[Take]] = {}
        self._decoders: dict[str, tuple[tuple[str, str, str, bytes], RosDecoder]] = {}
        self._waiting: dict[str, RosMessage] = {}
        self._bytes = Bucket(_BYTES_PER_S, _BYTES_AT_ONCE)
        self._fields = Bucket(_FIELDS_PER_S, _FIELDS_AT_ONCE)

    def read(self, topic: str, take: Take, *, each: bool = False, most: int = MOST_BYTES) -> None:
        """Give messages of a topic to `take`; without a name do nothing.

        Args:
            topic: Its name.
            take: Gets the decoded message and how it came.
            each: Whether each message counts, at once; else only the newest, at `decode_newest`.
            most: Longest message that is read [bytes].
        """
        if not topic:
            return
        takers = self._takers.setdefault(topic, [])
        takers.append(take)
        if len(takers) == 1:
            self._line.subscribe(topic, self._short(self._decode if each else self._keep, most))

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

    def _short(self, take: Callable[[RosMessage], None], most: int) -> Callable[[RosMessage], None]:
        """Takes messages that are not too long."""

        def came(message: RosMessage) -> None:
            if len(message.payload) > most:
                self.faults[message.topic.name] = f"messages of more than {most} bytes are not read"
            else:
                take(message)

        return came

    def _keep(self, message: RosMessage) -> None:
        self._waiting[message.topic.name] = dataclasses.replace(
            message, payload=bytes(message.payload)
        )

    def _decode(self, message: RosMessage) -> None:
        name = message.topic.name
        try:
            value = self._decoder(message).as_ros(message.payload)
            for take in self._takers.get(name, ()):
                take(value, message)
        except UNFIT as error:
            self.faults[name] = plain(str(error))[:_LONGEST]
        else:
            self.faults.pop(name, None)

    def _decoder(self, message: RosMessage) -> RosDecoder:
        """The decoder of a message's topic.

        Raises:
            RosMessageError: There is none, or the definition changes all the time.
        """
        topic, now = message.topic, message.arrived
        described = topic.schema_name, topic.encoding, topic.schema_encoding, topic.schema
        known = self._decoders.get(topic.name)
        if known is None or known[0] != described:
            _demand(self._bytes, len(topic.schema), now)
            made = RosDecoder.of(topic)
            _demand(self._fields, made.fields, now)
            known = self._decoders[topic.name] = described, made
        return known[1]


def _demand(bucket: Bucket, amount: int, now: float) -> None:
    """Take an amount for a new definition.

    Raises:
        RosMessageError: It is not there.
    """
    if not bucket.take(amount, now):
        text = "its definition changes too often"
        raise RosMessageError(text)
