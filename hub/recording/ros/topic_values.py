"""The newest message of each topic of a recording, decoded and converted when it is needed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any, Final, Protocol

from hub.errors import RosMessageError
from hub.plain_text import plain
from hub.recording.chunks import LoggedMessage
from hub.recording.ros.topic_roles import RosRole, TopicRole, roles_of
from hub.recording.topics import RecordedTopic
from hub.ros.decoding import RosDecoder
from hub.ros.values import RosValue
from hub.values import dataclass

Convert = Callable[[RosValue], Any]

_UNFIT: Final = (RosMessageError, TypeError, ValueError, IndexError, OverflowError)
"""Faults of messages: a definition may have fields of the usual names and other types."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownMessage:
    """A message of Rune made of one of ROS 2.

    Attributes:
        value: The value.
        stamp: When it was logged [ns].
    """

    value: Any
    stamp: int


class TopicMessages(Protocol):
    """Recordings, one or several; see `hub.recording.reader.Recording`.

    Attributes:
        channels: Topics by number.
        counts: Number of messages by channel, where the files say it.
    """

    channels: dict[int, RecordedTopic]
    counts: dict[int, int]

    @property
    def start(self) -> int:
        """Stamp of the first message [ns]; 0 without messages."""

    @property
    def end(self) -> int:
        """Stamp of the last message [ns]; 0 without messages."""

    def newest(
        self, stamp: int, channels: AbstractSet[int] | None = None
    ) -> dict[int, LoggedMessage]:
        """The last message of each channel at or before a time [ns]."""

    def messages(
        self,
        start: int | None = None,
        end: int | None = None,
        channels: AbstractSet[int] | None = None,
        *,
        reverse: bool = False,
    ) -> Iterator[LoggedMessage]:
        """All messages by stamp [ns]."""


class TopicValues:
    """The newest messages; for one thread.

    Attributes:
        newest: The newest message of each topic.
        decoders: The decoders of all topics that can be read.
        unreadable: Why no message of a topic can be read, by its number.
        faults: What cannot be used, once for each topic, in sentences.
    """

    def __init__(self, bag: TopicMessages) -> None:
        """Find out what can be read of a bag."""
        self.newest: dict[int, LoggedMessage] = {}
        self.faults: list[str] = []
        self._topics = bag.channels
        self._failed: set[int] = set()
        self._made: dict[int, tuple[LoggedMessage, Any]] = {}
        decoders: dict[int, RosDecoder] = {}
        unreadable: dict[int, str] = {}
        for channel, topic in bag.channels.items():
            try:
                decoders[channel] = RosDecoder.of(topic)
            except RosMessageError as error:
                unreadable[channel] = str(error)
        self.unreadable: Mapping[int, str] = unreadable
        self.decoders: Mapping[int, RosDecoder] = decoders
        self._of_role: dict[RosRole, list[TopicRole]] = {}
        for each in roles_of(bag.channels, bag.counts):
            if each.channel in decoders:
                self._of_role.setdefault(each.role, []).append(each)

    def of_role(self, *roles: RosRole) -> Sequence[TopicRole]:
        """The topics of some roles, those of each role with the preferred first."""
        return [each for role in roles for each in self._of_role.get(role, ())]

    def name(self, channel: int) -> str:
        """The name of a topic."""
        return self._topics[channel].name

    def decoded(self, message: LoggedMessage) -> RosValue | None:
        """A decoded message; None: it cannot be read."""
        decoder = self.decoders.get(message.channel)
        try:
            return decoder.decode(message.payload) if decoder is not None else None
        except RosMessageError as error:
            self.note(message.channel, error)
            return None

    def as_ros(self, message: LoggedMessage) -> RosValue | None:
        """A decoded message as one of ROS; None: it cannot be read."""
        decoder = self.decoders.get(message.channel)
        return decoder.as_ros(message.payload) if decoder is not None else None

    def converted(self, message: LoggedMessage, convert: Convert) -> Any:  # noqa: ANN401 - any type
        """What a message becomes; None: it cannot be used."""
        try:
            value = self.as_ros(message)
            return convert(value) if value is not None else None
        except _UNFIT as error:
            self.note(message.channel, error)
            return None

    def shown(self, channel: int, convert: Convert) -> ShownMessage | None:
        """What the newest message of a topic becomes; each message is converted once."""
        message = self.newest.get(channel)
        if message is None:
            return None
        known = self._made.get(channel)
        if known is None or known[0] is not message:
            known = self._made[channel] = message, self.converted(message, convert)
        return None if known[1] is None else ShownMessage(value=known[1], stamp=message.stamp)

    def all_shown(self, convert: Convert, *roles: RosRole) -> Iterator[ShownMessage]:
        """What the newest messages of all topics of some roles become."""
        found = (self.shown(each.channel, convert) for each in self.of_role(*roles))
        return (each for each in found if each is not None)

    def first(self, convert: Convert, *roles: RosRole) -> ShownMessage | None:
        """What the newest message of the preferred topic becomes; None: no topic has one."""
        return next(self.all_shown(convert, *roles), None)

    def note(self, channel: int, error: Exception) -> None:
        """Keep a fault of a topic, if it is its first one."""
        if channel not in self._failed:
            self._failed.add(channel)
            self.faults.append(f"{plain(self._topics[channel].name)[:80]}: {error}")


def whole(value: RosValue) -> RosValue:
    """The message itself."""
    return value
