"""The recording of a console: messages of its robots and of itself, in one file."""

from __future__ import annotations

import dataclasses
import functools
import logging
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hub.errors import CodecError
from hub.ipc.definition import MessageDefinition
from hub.recording.anchor import TimeAnchor
from hub.recording.topics import RecordedTopic, topic_of
from hub.recording.writer import PATIENCE_S, RecordingWriter, WriterState

_logger = logging.getLogger(__name__)


class ConsoleRecording:
    """A file of messages; any thread may call `add`."""

    def __init__(
        self, path: Path, about: Mapping[str, str], clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Begin.

        Args:
            path: A new file.
            about: Facts, such as the layout and the number of the run.
            clock: Monotonic time [s].

        Raises:
            OSError: The file cannot be written.
        """
        self.path = path
        self._clock = clock
        anchor = TimeAnchor(time.time_ns(), clock())
        self._writer = RecordingWriter(path, anchor, about)

    @property
    def state(self) -> WriterState:
        """How far the recording has got."""
        return self._writer.state

    def add(
        self,
        robot: str,
        definition: MessageDefinition[Any],
        value: object,
        measured: float,
        number: int = 0,
        *,
        part: str = "",
    ) -> None:
        """Write a message; never waits.

        Args:
            robot: The first part of its topic.
            definition: Which message.
            value: Its value.
            measured: When it was measured, on the monotonic clock [s].
            number: Its received number; 0 has none.
            part: The last part of its topic; empty: none.
        """
        try:
            payload = definition.encode(value)
        except CodecError as error:
            _logger.warning("%s of %s is not recorded: %s", definition.name, robot, error)
            return
        topic = _part_of(robot, definition, part) if part else topic_of(robot, definition)
        self._writer.add(topic, payload, self._clock(), measured, number)

    def attach(self, name: str, data: bytes) -> None:
        """Write a file into the recording."""
        self._writer.attach(name, "application/octet-stream", data, self._clock())

    def close(self, patience: float = PATIENCE_S) -> str:
        """Write the waiting messages and the index, as `RecordingWriter.close` does."""
        return self._writer.close(patience)


@functools.cache
def _part_of(robot: str, definition: MessageDefinition[Any], part: str) -> RecordedTopic:
    topic = topic_of(robot, definition)
    return dataclasses.replace(topic, name=f"{topic.name}/{part}")
