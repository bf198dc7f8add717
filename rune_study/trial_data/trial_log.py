"""The messages of a trial in recordings, by robot and kind, in seconds of the trial."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from hub.errors import CodecError
from hub.gcm.catalog import BY_NAME
from hub.ipc.definition import MessageDefinition
from hub.recording.chunks import LoggedMessage
from hub.recording.recording_set import RecordingSet

T = TypeVar("T")
CONSOLE = "console"
"""First part of the topics of a console's own records."""
_SECOND = 1_000_000_000


class TrialLog:
    """What recordings have of one trial.

    Attributes:
        begin: Stamp of its first moment [ns].
        end: Stamp of its last moment [ns].
        damaged: Messages that could not be read.
    """

    def __init__(
        self, recordings: RecordingSet, begin: int | None = None, end: int | None = None
    ) -> None:
        """Look at a part of open recordings; default all of them."""
        self._recordings = recordings
        self.begin = recordings.start if begin is None else begin
        self.end = recordings.end if end is None else end
        self.damaged = 0

    @property
    def seconds(self) -> float:
        """Length of the trial [s]."""
        return max(0.0, (self.end - self.begin) / _SECOND)

    @property
    def has_console(self) -> bool:
        """Whether the recordings have a console's records of itself."""
        return any(topic.robot == CONSOLE for topic in self._recordings.channels.values())

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of the robots that the recordings have messages of."""
        return tuple(
            sorted(
                {
                    topic.robot
                    for topic in self._recordings.channels.values()
                    if topic.message in BY_NAME and topic.robot not in ("", CONSOLE)
                }
            )
        )

    @property
    def last_of_console(self) -> float:
        """When the console recorded something for the last time, also after it [s of the trial]."""
        own = {
            number for number, topic in self._recordings.channels.items() if topic.robot == CONSOLE
        }
        newest = self._recordings.newest(self._recordings.end, own) if own else {}
        stamps = (message.stamp for message in newest.values())
        return (max(stamps, default=self.begin) - self.begin) / _SECOND

    def values(
        self, robot: str, definition: MessageDefinition[T], *, before: bool = False
    ) -> Iterator[tuple[float, T]]:
        """A robot's messages of one kind, and when each was measured [s of the trial].

        Hub and console both may have recorded them; the fuller recording counts. Messages that
        cannot be read are counted in `damaged`.

        Args:
            robot: Its name.
            definition: The kind.
            before: Whether messages from before the trial are wanted too; their times are negative.
        """
        for message in self._messages(robot, definition, before=before):
            try:
                value = definition.decode(message.payload)
            except CodecError:
                self.damaged += 1
                continue
            yield (message.published - self.begin) / _SECOND, value

    def own(
        self, definition: MessageDefinition[T], *, before: bool = False
    ) -> Iterator[tuple[float, T]]:
        """A console's records of itself of one kind, as `values`."""
        return self.values(CONSOLE, definition, before=before)

    def numbers(self, robot: str, definition: MessageDefinition[T]) -> dict[int, float]:
        """When each message was measured [s of the trial], by its received number."""
        return {
            message.number: (message.published - self.begin) / _SECOND
            for message in self._messages(robot, definition)
        }

    def last(self, robot: str, definition: MessageDefinition[T]) -> T | None:
        """The last message of one kind; None: there is none that can be read."""
        for message in self._messages(robot, definition, reverse=True):
            try:
                return definition.decode(message.payload)
            except CodecError:
                self.damaged += 1
        return None

    def _messages(
        self,
        robot: str,
        definition: MessageDefinition[T],
        *,
        reverse: bool = False,
        before: bool = False,
    ) -> Iterator[LoggedMessage]:
        channels = [
            number
            for number, topic in self._recordings.channels.items()
            if topic.name == f"/{robot}/{definition.name}"
        ]
        if channels:
            counts = self._recordings.counts
            channel = max(channels, key=lambda number: (counts.get(number, 0), -number))
            begin, end = None if before else self.begin, self.end
            yield from self._recordings.messages(begin, end, {channel}, reverse=reverse)
