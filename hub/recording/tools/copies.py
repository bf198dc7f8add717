"""Copies of parts of recordings: cut, merged, filtered, packed, named as ROS 2 does, saved.

Memory does not grow with the file: messages pass one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from hub.errors import RecordingError
from hub.recording.chunks import LoggedMessage
from hub.recording.new_recording import NewRecording
from hub.recording.recording_set import RecordingSet
from hub.recording.ros.bag import Bag
from hub.recording.tools.ros_copy import RosCopy, write_bag_metadata
from hub.recording.tools.selection import Selection
from hub.recording.writer import ABOUT
from hub.values import dataclass

Progress = Callable[[float], None]
"""Is called now and then with the share that is done."""
RECOVERED = "rune recovered"
"""Name of the metadata with the faults of parts whose messages may be wrong."""
_SELDOM = 2000
"""Messages between two reports of progress."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CopyOptions:
    """How a copy is written.

    Attributes:
        compression: How it is packed: lz4, zstd or none.
        replace: Whether it may replace a file.
        newest: Whether it begins with the newest message of each topic before its span.
        ros_names: Whether topics are named as ROS 2 does, with a folder as rosbag2 makes it.
    """

    compression: str = "lz4"
    replace: bool = False
    newest: bool = False
    ros_names: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Copied:
    """What a copy has.

    Attributes:
        path: The file or folder.
        messages: Number of its messages.
        bytes: Its length [bytes].
        unreadable: Length of what could not be read [bytes].
        missing: Messages that the index of the source counts and the copy lacks; -1: not known.
        faults: What could not be read, in sentences.
    """

    path: Path
    messages: int
    bytes: int
    unreadable: int = 0
    missing: int = -1
    faults: tuple[str, ...] = ()


def copy(
    recording: RecordingSet,
    target: Path,
    selection: Selection,
    options: CopyOptions,
    progress: Progress,
) -> Copied:
    """Write a part of recordings into a new file, in order.

    Raises:
        RecordingError: The part is empty, or the file cannot be written.
    """
    channels = selection.channels(recording)
    first, last = selection.span(recording)
    path = target
    if options.ros_names and target.suffix != ".mcap":
        path = _file_in_new_folder(target, replace=options.replace)
    with NewRecording(path, compression=options.compression, replace=options.replace) as new:
        faults = _copy_facts(recording, new)
        ros = RosCopy(new, recording.channels) if options.ros_names else None
        add = ros.add if ros is not None else _adder(new, recording)
        if options.newest:
            for message in _by_age(recording.newest(first - 1, channels)):
                add(message._replace(stamp=first))
        length = max(1, last - first)
        for count, message in enumerate(recording.messages(first, last, channels)):
            add(message)
            if count % _SELDOM == 0:
                progress((message.stamp - first) / length)
    if ros is not None and path != target:
        write_bag_metadata(target, path.name, ros)
    return Copied(
        path=target, messages=new.messages, bytes=new.size, faults=(*recording.faults, *faults)
    )


def recover(
    source: Path,
    target: Path,
    *,
    compression: str,
    replace: bool,
    progress: Progress,
    damaged: bool = False,
    unpacked: int = 0,
) -> Copied:
    """Write what is whole of a damaged or unfinished recording into a new file.

    Messages keep the order of an MCAP file.

    Args:
        source: The file or folder.
        target: The new file.
        compression: How it is packed: lz4, zstd or none.
        replace: Whether it may replace a file.
        progress: Is called now and then with the share that is done.
        damaged: Whether those messages count that can be found in damaged parts; they may be wrong
            themselves, and the metadata `rune recovered` names these parts.
        unpacked: Most bytes that are unpacked; 0: by its size.

    Raises:
        RecordingError: Nothing of it can be read, or the new file cannot be written.
    """
    with Bag.open(source, partial=damaged, unpacked=unpacked) as recording:
        counted = sum(recording.counts.values()) if recording.counts else -1
        size = max(1, source.stat().st_size if source.is_file() else counted)
        with NewRecording(target, compression=compression, replace=replace) as new:
            for name, facts in recording.about.items():
                new.add_facts(name, facts)
            faults = _copy_attachments(recording, new)
            done = 0
            for message in recording.salvage():
                new.add(
                    recording.channels[message.channel],
                    message.stamp,
                    message.published,
                    message.number,
                    message.payload,
                )
                done += len(message.payload) if source.is_file() else 1
                if new.messages % _SELDOM == 0:
                    progress(min(1.0, done / size))
            if damaged and recording.faults:
                numbered = {str(n): fault for n, fault in enumerate(recording.faults, 1)}
                new.add_facts(RECOVERED, numbered)
        return Copied(
            path=target,
            messages=new.messages,
            bytes=new.size,
            unreadable=recording.unreadable,
            missing=max(0, counted - new.messages) if counted >= 0 else -1,
            faults=(*recording.faults, *faults),
        )


def _adder(new: NewRecording, recording: RecordingSet) -> Callable[[LoggedMessage], None]:
    topics = recording.channels

    def add(message: LoggedMessage) -> None:
        channel, stamp, published, number, payload = message
        new.add(topics[channel], stamp, published, number, payload)

    return add


def _by_age(messages: dict[int, LoggedMessage]) -> Iterator[LoggedMessage]:
    return iter(sorted(messages.values(), key=lambda message: message.stamp))


def _copy_facts(recording: RecordingSet, new: NewRecording) -> list[str]:
    """Copy metadata and attachments; the clock is that of the first recording.

    Returns what cannot be read, in sentences.
    """
    for number, each in enumerate(recording.recordings):
        for name, facts in each.about.items():
            new.add_facts(f"{name} {number + 1}" if number and name == ABOUT else name, facts)
    return _copy_attachments(recording, new)


def _copy_attachments(recording: Bag | RecordingSet, new: NewRecording) -> list[str]:
    faults = []
    for place in recording.attachments:
        try:
            data = recording.attachment(place)
        except RecordingError as error:
            faults.append(str(error))
            continue
        new.attach(place.name, place.media_type, data)
    return faults


def _file_in_new_folder(folder: Path, *, replace: bool) -> Path:
    """The file of a bag in a folder that is made."""
    try:
        folder.mkdir(exist_ok=replace)
    except FileExistsError as error:
        text = f"{folder} exists; choose another name, or replace its files with --force"
        raise RecordingError(text) from error
    except OSError as error:
        text = f"{folder} cannot be made: {error.strerror}"
        raise RecordingError(text) from error
    return folder / f"{folder.name}_0.mcap"
