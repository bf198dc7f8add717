"""Logs of ground stations (.tlog): made from recordings, and read into them.

An entry is the date [us since 1970], 8 bytes with the highest first, and a frame as it was on the
wire. What is no entry is skipped byte by byte, to the next frame with a date of this century.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, Final, NamedTuple

import numpy as np

from hub.errors import CodecError, RecordingError
from hub.files import sync_folder
from hub.gcm.autopilot import MAVLINK_FRAMES, MavlinkFrames
from hub.recording.new_recording import NewRecording
from hub.recording.recording_set import RecordingSet
from hub.recording.tools.copies import Copied, CopyOptions, Progress
from hub.recording.tools.selection import Selection
from hub.recording.topics import topic_of
from hub.robots.mavlink.profiles.profile import STATION
from hub.robots.mavlink.wire.frames import VERSION_1, VERSION_2, FrameParser
from hub.robots.mavlink.wire.signing import SIGNATURE

ENDING: Final = ".tlog"
_STAMP: Final = struct.Struct(">Q")
_LONGEST: Final = _STAMP.size + 10 + 255 + 2 + SIGNATURE
_READ: Final = 1 << 16
_FIRST_US: Final = 946_684_800_000_000
_LAST_US: Final = 4_102_444_800_000_000
"""Dates of this century [us since 1970]."""
_SELDOM: Final = 2000
"""Messages between two reports of progress."""


class TlogEntry(NamedTuple):
    """One frame of a log.

    Attributes:
        stamp: When it came or left [us since 1970].
        frame: Its bytes.
    """

    stamp: int
    frame: bytes


class TlogReader:
    """Reads the entries of a log.

    Attributes:
        skipped: Bytes that are no entry.
        read: Bytes so far.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.skipped = self.read = 0

    def __iter__(self) -> Iterator[TlogEntry]:
        data, at, whole, ended = b"", 0, True, False
        while True:
            if len(data) - at < _LONGEST and not ended:
                piece = self._file.read(_READ)
                self.read += len(piece)
                ended = not piece
                data, at = data[at:] + piece, 0
                continue
            if at >= len(data):
                return
            length = _frame_length(data, at + _STAMP.size)
            end = at + _STAMP.size + length
            stamp = _STAMP.unpack_from(data, at)[0] if length else 0
            if length and end <= len(data) and (whole or _FIRST_US <= stamp <= _LAST_US):
                yield TlogEntry(stamp, data[at + _STAMP.size : end])
                at, whole = end, True
            else:
                self.skipped += 1
                at, whole = at + 1, False


def _frame_length(data: bytes, at: int) -> int:
    """Length of the frame that begins here; 0: none does."""
    if len(data) < at + 3:
        return 0
    if data[at] == VERSION_2:
        return 10 + data[at + 1] + 2 + SIGNATURE * (data[at + 2] & 1)
    return 6 + data[at + 1] + 2 if data[at] == VERSION_1 else 0


def to_tlog(
    recording: RecordingSet,
    target: Path,
    selection: Selection,
    options: CopyOptions,
    progress: Progress,
) -> Copied:
    """Write the frames of one robot's link into a log.

    Raises:
        RecordingError: The recording has none, or those of several robots, or the file cannot be
            written.
    """
    first, last = selection.span(recording)
    meant = selection.channels(recording)
    channels = {
        number: topic.robot
        for number, topic in recording.channels.items()
        if number in meant and topic.message == MAVLINK_FRAMES.name
    }
    if len(set(channels.values())) != 1:
        which = ", ".join(sorted(set(channels.values()))) or "no robot"
        advice = "; choose one with --robot" if channels else ""
        text = f"{recording.path} has MAVLink frames of {which}{advice}"
        raise RecordingError(text)
    frames = entries = size = 0
    faults: list[str] = []
    parsers = FrameParser(), FrameParser()
    with _NewFile(target, replace=options.replace) as write:
        for count, message in enumerate(recording.messages(first, last, set(channels))):
            try:
                piece = MAVLINK_FRAMES.decode(message.payload)
            except CodecError as error:
                faults = [f"a message of {MAVLINK_FRAMES.name} cannot be read: {error}"]
                continue
            data = piece.data.tobytes()
            size += len(data)
            stamp = round(piece.stamp * 1e6) or message.stamp // 1000
            for frame in parsers[piece.sent].feed(data):
                write(_STAMP.pack(stamp) + frame.raw)
                frames += len(frame.raw)
                entries += 1
            if count % _SELDOM == 0:
                progress((message.stamp - first) / max(1, last - first))
    return Copied(
        path=target,
        messages=entries,
        bytes=frames + _STAMP.size * entries,
        unreadable=size - frames,
        faults=(*recording.faults, *faults),
    )


def from_tlog(
    source: Path, target: Path, options: CopyOptions, progress: Progress, *, robot: str = "vehicle"
) -> Copied:
    """Write a log as a recording with the messages that a hub records.

    Args:
        source: The log.
        target: The new recording.
        options: How it is written.
        progress: Is called now and then.
        robot: Name of the robot in the topic.

    Raises:
        RecordingError: The log cannot be read, or the file cannot be written.
    """
    topic = topic_of(robot, MAVLINK_FRAMES)
    stations = {STATION}
    parser = FrameParser()
    try:
        length = max(1, source.stat().st_size)
        with (
            source.open("rb") as file,
            NewRecording(target, compression=options.compression, replace=options.replace) as new,
        ):
            reader = TlogReader(file)
            for number, entry in enumerate(reader, 1):
                for frame in parser.datagram(entry.frame):
                    if frame.name == "HEARTBEAT" and frame["type"] == 6:
                        stations.add(frame.system)
                system = entry.frame[5 if entry.frame[0] == VERSION_2 else 3]
                value = MavlinkFrames(
                    stamp=entry.stamp / 1e6,
                    sent=int(system in stations),
                    data=np.frombuffer(entry.frame, np.uint8),
                )
                payload = b"".join(MAVLINK_FRAMES.encode(value))
                new.add(topic, 1000 * entry.stamp, 1000 * entry.stamp, number, payload)
                if number % _SELDOM == 0:
                    progress(reader.read / length)
            if not new.messages:
                text = f"{source} has no frames of MAVLink: it is no log of a ground station"
                raise RecordingError(text)
    except OSError as fault:
        text = f"{source} cannot be read: {fault.strerror or fault}"
        raise RecordingError(text) from fault
    return Copied(path=target, messages=new.messages, bytes=new.size, unreadable=reader.skipped)


class _NewFile:
    """A new file in one step; an error leaves nothing of it."""

    def __init__(self, path: Path, *, replace: bool) -> None:
        self._path, self._replace = path, replace
        self._partial = path.with_name(f".{path.name}.{os.getpid()}.partial")

    def __enter__(self) -> Callable[[bytes], object]:
        if not self._replace and self._path.exists():
            text = f"{self._path} exists; choose another name, or replace it with --force"
            raise RecordingError(text)
        try:
            self._file = self._partial.open("wb")
        except OSError as fault:
            raise self._fault(fault) from fault
        return self._file.write

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        try:
            self._file.close()
            if kind is None:
                self._partial.replace(self._path)
                sync_folder(self._path.parent)
        except OSError as fault:
            raise self._fault(fault) from fault
        finally:
            self._partial.unlink(missing_ok=True)

    def _fault(self, fault: OSError) -> RecordingError:
        text = f"{self._path} cannot be written: {fault.strerror or fault}"
        return RecordingError(text)
