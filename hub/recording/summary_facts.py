"""Facts of an MCAP file: its topics, its parts with messages, its metadata."""

from __future__ import annotations

import struct
from dataclasses import field
from typing import Final, NamedTuple

from hub.errors import RecordingError
from hub.recording.chunks import ChunkPlace
from hub.recording.records import FOOTER, MAGIC, RECORD, SCHEMA
from hub.recording.ros_quality import ROSBAG2
from hub.recording.topics import RecordedTopic
from hub.values import dataclass

MOST_FAULTS: Final = 20
"""Most faults of a file that are named."""
FOOTER_BYTES: Final = RECORD.size + 20 + len(MAGIC)
MOST_SUMMARY: Final = 256 * 1024 * 1024
"""Longest index that is read, and all facts that a scan keeps [bytes]."""
MOST_METADATA: Final = 16 * 1024 * 1024
MOST_CHUNKS: Final = 4_000_000


class AttachmentPlace(NamedTuple):
    """Where a file within the recording is.

    Attributes:
        name: Its name.
        media_type: Its type: "application/xml".
        offset: The place of its record [bytes].
        size: Its length [bytes].
    """

    name: str
    media_type: str
    offset: int
    size: int


@dataclass(slots=True)
class Summary:
    """What is in a file.

    Attributes:
        topics: Topics by the number of their channel.
        chunks: Parts with messages, in the order of the file.
        about: Metadata by name; equal names are merged.
        attachments: Files within it.
        counts: Number of messages by channel; empty without an index.
        finished: The file has its index.
        faults: What is wrong with the file, in sentences.
        unreadable: Length of what lies between the parts and is damaged [bytes].
    """

    topics: dict[int, RecordedTopic] = field(default_factory=dict)
    chunks: list[ChunkPlace] = field(default_factory=list)
    about: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: list[AttachmentPlace] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    finished: bool = False
    faults: list[str] = field(default_factory=list)
    unreadable: int = 0


class Fields:
    """The fields of a record, one after another."""

    def __init__(self, data: bytes, at: int = 0) -> None:
        self.data = data
        self.at = at

    def number(self, code: str) -> int:
        """The next number, by the letter of `struct`."""
        (value,) = struct.unpack_from("<" + code, self.data, self.at)
        self.at += struct.calcsize("<" + code)
        return int(value)

    def bytes(self) -> bytes:
        """The next bytes, whose length stands before them.

        Raises:
            RecordingError: They are cut.
        """
        length = self.number("I")
        if length > len(self.data) - self.at:
            text = "a text in it is cut"
            raise RecordingError(text)
        self.at += length
        return self.data[self.at - length : self.at]

    def text(self) -> str:
        """The next bytes, as UTF-8; what is not UTF-8 is replaced."""
        return self.bytes().decode("utf-8", "replace")

    def map(self) -> dict[str, str]:
        """The next texts by name."""
        inner = Fields(self.bytes())
        found = {}
        while inner.at < len(inner.data):
            name = inner.text()
            found[name] = inner.text()
        return found


class Topics:
    """Gathers schemas and channels into topics.

    Attributes:
        complete: Each channel has its schema.
    """

    def __init__(self, summary: Summary) -> None:
        self.complete = True
        self._summary = summary
        self._schemas: dict[int, tuple[str, str, bytes]] = {}

    def take(self, kind: int, content: bytes) -> None:
        """Take a record with a schema or a channel."""
        fields = Fields(content)
        number = fields.number("H")
        if kind == SCHEMA:
            self._schemas[number] = fields.text(), fields.text(), fields.bytes()
            return
        schema = fields.number("H")
        if schema and schema not in self._schemas:
            self.complete = False
        name, encoding, text = self._schemas.get(schema, ("", "", b""))
        topic, coding = fields.text(), fields.text()
        self._summary.topics.setdefault(
            number, RecordedTopic(topic, name, encoding, text, coding, fields.map())
        )


def is_footer(tail: bytes) -> bool:
    """Whether these are the last bytes of a complete file."""
    whole = len(tail) == FOOTER_BYTES
    return whole and tail[-len(MAGIC) :] == MAGIC and tail[0] == FOOTER


def take_metadata(summary: Summary, content: bytes) -> None:
    """Take a record with metadata; those of rosbag2 do not count."""
    fields = Fields(content)
    name = fields.text()
    if name != ROSBAG2:
        summary.about.setdefault(name, {}).update(fields.map())
