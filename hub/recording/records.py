"""Records of MCAP files: their numbers and their heads; https://mcap.dev/spec."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Final

from hub.errors import RecordingError

MAGIC: Final = b"\x89MCAP0\r\n"
"""First and last bytes of a file."""
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX = range(9, 14)
SUMMARY_OFFSET, DATA_END = 14, 15
RECORD = struct.Struct("<BQ")
"""Head of a record: its number, and the length of its content [bytes]."""


def fault_of_begin(head: bytes) -> str:
    """Why a file that begins so is no MCAP file, and what to do; empty: it is one."""
    if head.startswith(b"#ROSBAG"):
        return (
            "it is a bag of ROS 1; `rosbags-convert --src FILE --dst FOLDER` (pip install rosbags) "
            "makes a folder that can be read"
        )
    return "" if head.startswith(MAGIC) else "it is no MCAP file"


def records_of(data: bytes, start: int = 0) -> Iterator[tuple[int, int, int]]:
    """Kind, begin and end of the content of each record.

    Raises:
        RecordingError: A record is longer than the data, or none.
    """
    at = start
    while at < len(data):
        if at + RECORD.size > len(data):
            text = "a record is cut"
            raise RecordingError(text)
        kind, length = RECORD.unpack_from(data, at)
        at += RECORD.size
        if length > len(data) - at or not kind:
            text = "a record is longer than its part of the file, or none"
            raise RecordingError(text)
        yield kind, at, at + length
        at += length
