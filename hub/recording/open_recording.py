"""What every open recording is: one file, a folder of splits, or several on one time line."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from types import TracebackType
from typing import Self

from hub.recording.chunks import LoggedMessage
from hub.recording.topics import RecordedTopic


class OpenRecording(ABC):
    """A recording that is read, and closed with its context; for one thread.

    Attributes:
        channels: Topics by number.
        counts: Number of messages by channel, where the files say it.
        start: Stamp of the first message [ns]; 0 without messages.
        end: Stamp of the last message [ns]; 0 without messages.
    """

    channels: Mapping[int, RecordedTopic]
    counts: Mapping[int, int]
    start: int
    end: int

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @abstractmethod
    def close(self) -> None:
        """Close all files; once."""

    @abstractmethod
    def newest(
        self, stamp: int, channels: AbstractSet[int] | None = None
    ) -> dict[int, LoggedMessage]:
        """The last message of each channel at or before a time.

        Args:
            stamp: The time [ns].
            channels: Which channels; default all.
        """

    @abstractmethod
    def messages(
        self,
        start: int | None = None,
        end: int | None = None,
        channels: AbstractSet[int] | None = None,
        *,
        reverse: bool = False,
    ) -> Iterator[LoggedMessage]:
        """All messages by stamp; equal stamps by their place in the files.

        Args:
            start: The first stamp [ns]; default the first of all.
            end: The last stamp [ns]; default the last of all.
            channels: Which channels; default all.
            reverse: The last message first.
        """
