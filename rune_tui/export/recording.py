"""Writes all messages from and to robots into an MCAP file.

Payloads are those of the bus, in ROS 2's encoding, with the ROS 2 definition of each message:
Foxglove and the mcap tools open the file. The system gets all messages within FLUSH_S. After a
kill or on a full disk, a file has all messages before that, but no index; `mcap recover` writes it.
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import queue
import threading
import time
from pathlib import Path
from typing import Any

from mcap.writer import Writer

from hub.errors import CodecError
from hub.ipc.definition import MessageDefinition
from hub.ipc.ros_schema import ros2msg, ros_type

_logger = logging.getLogger(__name__)

FLUSH_S = 0.5
"""Longest time until the system gets a message [s]."""
_MOST_WAITING = 4000
"""Most messages that wait for the disk; further messages are dropped and counted."""


class Recording:
    """A file of messages; any thread may call `add`.

    Attributes:
        path: The file.
        count: Number of messages that the system has.
        dropped: Number of messages dropped for a slow disk.
        fault: Why writing ended; else empty.
    """

    def __init__(self, path: Path, about: dict[str, str]) -> None:
        """Begin.

        Args:
            path: A new file.
            about: Facts, such as the layout and the number of the run.

        Raises:
            OSError: The file cannot be written.
        """
        self.path = path
        self.count = self.dropped = 0
        self.fault = ""
        self._channels: dict[tuple[str, str], int] = {}
        self._schemas: dict[str, int] = {}
        self._unflushed = 0
        self._flush_due = math.inf
        self._end_of_whole = 0
        self._waiting: queue.Queue[_Entry | None] = queue.Queue(_MOST_WAITING)
        self._file = path.open("xb")
        self._writer = Writer(self._file)
        self._writer.start(profile="", library="rune")
        self._writer.add_metadata("rune", about)
        self._flush()
        self._thread = threading.Thread(target=self._write_all, name="recording", daemon=True)
        self._thread.start()

    def add(
        self, robot: str, definition: MessageDefinition[Any], value: object, measured: float
    ) -> None:
        """Write a message of this robot, measured at this time of the monotonic clock [s]."""
        try:
            self._waiting.put_nowait((robot, definition, value, measured, time.time_ns()))
        except queue.Full:
            self.dropped += 1

    def close(self) -> None:
        """Write the waiting messages and the index."""
        self._waiting.put(None)
        self._thread.join()

    def _write_all(self) -> None:
        try:
            while (entry := self._next()) is not None:
                if entry and not self.fault:
                    self._write(*entry)
                if time.monotonic() >= self._flush_due:
                    self._flush()
        finally:
            self._end()

    def _next(self) -> _Entry | tuple[()] | None:
        """The next message; empty when a flush is due, None at the end."""
        left = self._flush_due - time.monotonic()
        try:
            return self._waiting.get(timeout=None if math.isinf(left) else max(0.0, left))
        except queue.Empty:
            return ()

    def _flush(self) -> None:
        """Pass all bytes to the system; cut off the bytes that it does not take."""
        self._flush_due = math.inf
        if self.fault:
            return
        try:
            self._writer.flush()  # type: ignore[no-untyped-call]
        except OSError as error:
            self._give_up(error)
        else:
            self.count += self._unflushed
            self._unflushed = 0
            self._end_of_whole = self._file.tell()

    def _give_up(self, error: OSError) -> None:
        """Stop writing; the file ends with its last complete part."""
        self.fault = error.strerror or str(error)
        with contextlib.suppress(OSError):
            os.truncate(self.path, self._end_of_whole)

    def _write(
        self,
        robot: str,
        definition: MessageDefinition[Any],
        value: object,
        measured: float,
        logged_ns: int,
    ) -> None:
        try:
            payload = b"".join(definition.encode(value))
            age_ns = int(max(0.0, time.monotonic() - measured) * 1e9)
            self._writer.add_message(
                channel_id=self._channel(robot, definition),
                log_time=logged_ns,
                publish_time=max(0, time.time_ns() - age_ns),
                data=payload,
            )
        except CodecError as error:
            _logger.warning("%s of %s is not recorded: %s", definition.name, robot, error)
        except OSError as error:
            self._give_up(error)
        else:
            self._unflushed += 1
            if math.isinf(self._flush_due):
                self._flush_due = time.monotonic() + FLUSH_S

    def _channel(self, robot: str, definition: MessageDefinition[Any]) -> int:
        key = (robot, definition.name)
        if key not in self._channels:
            if definition.name not in self._schemas:
                self._schemas[definition.name] = self._writer.register_schema(
                    name=ros_type(definition),
                    encoding="ros2msg",
                    data=ros2msg(definition).encode(),
                )
            self._channels[key] = self._writer.register_channel(
                topic=f"/{robot}/{definition.name}",
                message_encoding="cdr",
                schema_id=self._schemas[definition.name],
            )
        return self._channels[key]

    def _end(self) -> None:
        self._flush()
        try:
            if not self.fault:
                self._writer.finish()  # type: ignore[no-untyped-call]
                self._file.flush()
        except OSError as error:
            self._give_up(error)
        # The file's buffer still has the rest, and `close` writes it again.
        with contextlib.suppress(OSError):
            self._file.close()
        if self.fault:
            with contextlib.suppress(OSError):
                os.truncate(self.path, self._end_of_whole)


_Entry = tuple[str, MessageDefinition[Any], object, float, int]
