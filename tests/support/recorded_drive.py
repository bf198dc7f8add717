"""A recording of two robots, for tests of what is done with recordings."""

from __future__ import annotations

import struct
from pathlib import Path

from hub.gcm.battery import BATTERY
from hub.gcm.navigation import DRIVE_STATE
from hub.gcm.recording import RECORD_MARK, RecordMark
from hub.recording.anchor import TimeAnchor
from hub.recording.topics import topic_of
from hub.recording.writer import RecordingWriter, WriterLimits

ANCHOR = TimeAnchor(1_790_000_000_000_000_000, 100.0)
LIMITS = WriterLimits(chunk_bytes=2000, least_free=0)


_CHUNK = 6


def damage_chunks(data: bytes) -> bytes:
    """The same file with each of its chunks damaged."""
    damaged = bytearray(data)
    for start, end in chunks_of(data):
        for at in range(start + 69, end - 10, 37):
            damaged[at] ^= 0xFF
    return bytes(damaged)


def chunks_of(data: bytes) -> list[tuple[int, int]]:
    """Begin and end of each chunk of a file [bytes]."""
    found, place = [], 8
    while place + 9 <= len(data) - 8:
        (length,) = struct.unpack_from("<Q", data, place + 1)
        if data[place] == _CHUNK:
            found.append((place, place + 9 + length))
        place += 9 + length
    return found


def write_drive(path: Path) -> None:
    """100 s of rover, twice a second, with one message lost on the way; 60 s of scout."""
    writer = RecordingWriter(path, ANCHOR, {"robot": "rover", "recorder": "hub"}, LIMITS)
    state, mark = topic_of("rover", DRIVE_STATE), topic_of("rover", RECORD_MARK)
    for number in range(1, 201):
        moment = 100 + number / 2
        if number != 50:
            writer.add(state, DRIVE_STATE.encode(DRIVE_STATE.type()), moment, moment, number)
        if number <= 120 and number % 2 == 0:
            payload = BATTERY.encode(BATTERY.type(voltage=number / 10))
            writer.add(topic_of("scout", BATTERY), payload, moment, moment, number // 2)
    writer.add(mark, RECORD_MARK.encode(RecordMark(number=1, text="a victim")), 140.0, 140.0, 1)
    writer.attach("search.xml", "application/xml", b"<layout/>", 100.0)
    writer.close()
