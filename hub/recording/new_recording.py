"""Writes a recording from messages that exist: it is put in place when it is complete."""

from __future__ import annotations

import contextlib
import os
import struct
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from hub.errors import RecordingError
from hub.files import sync_folder
from hub.recording.encoder import McapEncoder, Payload
from hub.recording.topics import RecordedTopic

CHUNK_BYTES: Final = 512 * 1024
"""Length of messages with which a part of the file ends [bytes]."""
PARTIAL: Final = ".partial"
"""How the name of a file ends that is not complete; the number of its process is before it."""


class NewRecording:
    """A new file, for one thread; use it with `with`: an error leaves nothing of it.

    Attributes:
        path: Its place.
        messages: Number of messages so far.
    """

    def __init__(self, path: Path, *, compression: str = "lz4", replace: bool = False) -> None:
        """Begin.

        Args:
            path: Its place.
            compression: How it is packed: lz4, zstd or none.
            replace: Whether it may replace a file.

        Raises:
            RecordingError: There is a file, or it cannot be written.
        """
        self.path = path
        self.messages = 0
        self._replace = replace
        self._channels: dict[RecordedTopic, int] = {}
        self._encoder = McapEncoder(compression)
        if not replace and (path.exists() or path.is_symlink()):
            raise self._taken()
        self._partial = path.with_name(f".{path.name}.{os.getpid()}{PARTIAL}")
        try:
            self._file = self._partial.open("wb", buffering=0)
        except OSError as error:
            raise self._fault(error) from error
        self._write(self._encoder.begin())

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            self._remove()
            return
        self._write(self._encoder.end())
        try:
            os.fdatasync(self._file.fileno())
            self._file.close()
            if self._replace:
                self._partial.replace(self.path)
            else:
                self.path.hardlink_to(self._partial)  # fails where a file came meanwhile
                self._partial.unlink()
        except FileExistsError as taken:
            self._remove()
            raise self._taken() from taken
        except OSError as fault:
            self._remove()
            raise self._fault(fault) from fault
        sync_folder(self.path.parent)

    @property
    def size(self) -> int:
        """Length of the file so far [bytes]."""
        return self._encoder.length

    def add(
        self, topic: RecordedTopic, stamp: int, published: int, number: int, payload: Payload
    ) -> None:
        """Write a message.

        Args:
            topic: Where it belongs.
            stamp: When it was logged [ns since 1970].
            published: When its content was measured [ns since 1970].
            number: Its number at the receiver; 0 has none.
            payload: Its bytes.

        Raises:
            RecordingError: The file cannot be written, or a number does not fit.
        """
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._encoder.register(topic)
        try:
            self._encoder.add(channel, stamp, max(0, published), number, payload)
        except struct.error as error:
            text = f"a message of {topic.name} at {stamp} ns cannot be written: {error}"
            raise RecordingError(text) from error
        self.messages += 1
        if self._encoder.open_bytes >= CHUNK_BYTES:
            self._write(self._encoder.end_chunk())
            self._encoder.keep()

    def add_facts(self, name: str, facts: Mapping[str, str]) -> None:
        """Write metadata.

        Raises:
            RecordingError: The file cannot be written.
        """
        self._write(self._encoder.end_chunk())
        self._write(self._encoder.metadata(name, facts))

    def attach(self, name: str, media_type: str, data: bytes, stamp: int = 0) -> None:
        """Write a file into the recording.

        Raises:
            RecordingError: The file cannot be written.
        """
        self._write(self._encoder.end_chunk())
        self._write(self._encoder.attachment(name, media_type, data, stamp))

    def _write(self, data: bytes) -> None:
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) or 0 :]
        except OSError as error:
            self._remove()
            raise self._fault(error) from error

    def _remove(self) -> None:
        with contextlib.suppress(OSError):
            self._file.close()
        with contextlib.suppress(OSError):
            self._partial.unlink()

    def _taken(self) -> RecordingError:
        text = f"{self.path} exists; choose another name, or replace it with --force"
        return RecordingError(text)

    def _fault(self, error: OSError) -> RecordingError:
        text = f"{self.path} cannot be written: {error.strerror or error}"
        return RecordingError(text)
