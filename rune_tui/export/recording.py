"""Everything that comes from robots and goes to them, as an MCAP file.

Payloads are written as they are on the bus, which is as ROS 2 writes them, with the ROS 2 text of
each message beside it: Foxglove and the mcap tools open it. A file that was cut off, as its writer
was killed, lacks its index only; `mcap recover` makes that anew.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from pathlib import Path
from typing import Any

from mcap.writer import Writer

from hub.errors import CodecError
from hub.ipc.definition import MessageDefinition
from hub.ipc.schema import ros2msg, ros_type

_logger = logging.getLogger(__name__)

_MOST_WAITING = 4000
"""Messages that wait for the disk; what comes beyond is left out and counted."""


class Recording:
    """A file that grows while anybody hands it messages; `add` may be called by any thread.

    Attributes:
        path: The file.
        count: Messages written.
        dropped: Messages left out, as the disk was too slow.
        fault: Why nothing more is written; empty while all is well.
    """

    def __init__(self, path: Path, about: dict[str, str]) -> None:
        """Begin.

        Args:
            path: A file that is not there yet.
            about: What else is to be known of it, such as the layout and the number of the run.

        Raises:
            OSError: The file cannot be written.
        """
        self.path = path
        self.count = self.dropped = 0
        self.fault = ""
        self._channels: dict[tuple[str, str], int] = {}
        self._schemas: dict[str, int] = {}
        self._waiting: queue.Queue[_Entry | None] = queue.Queue(_MOST_WAITING)
        self._file = path.open("xb")
        self._writer = Writer(self._file)
        self._writer.start(profile="", library="rune")
        self._writer.add_metadata("rune", about)
        self._thread = threading.Thread(target=self._write_all, name="recording", daemon=True)
        self._thread.start()

    def add(
        self, robot: str, definition: MessageDefinition[Any], value: object, measured: float
    ) -> None:
        """Write a message of this robot that was measured then, on the monotonic clock [s]."""
        try:
            self._waiting.put_nowait((robot, definition, value, measured, time.time_ns()))
        except queue.Full:
            self.dropped += 1

    def close(self) -> None:
        """Write what waits, and the index."""
        self._waiting.put(None)
        self._thread.join()

    def _write_all(self) -> None:
        try:
            while (entry := self._waiting.get()) is not None:
                if not self.fault:
                    self._write(*entry)
        finally:
            self._end()

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
            self.fault = error.strerror or str(error)
        else:
            self.count += 1

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
        try:
            if not self.fault:
                self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.close()
        except OSError as error:
            self.fault = self.fault or error.strerror or str(error)


_Entry = tuple[str, MessageDefinition[Any], object, float, int]
