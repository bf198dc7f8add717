"""Writes a span of time from the files of a series into one file; a program of its own.

A robot's recorder runs it, so that its own work does not wait.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from hub.errors import HubError, RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.new_recording import NewRecording
from hub.recording.reader import LoggedMessage, Recording
from hub.recording.topics import RecordedTopic
from hub.recording.writer import ABOUT


def write_snapshot(files: Sequence[Path], target: Path, begin: float, end: float) -> int:
    """Write the messages of a span of time into a file, in order.

    It begins with the newest message before the span of each topic.

    Args:
        files: The files of one recorder, in order.
        target: The file; it replaces one of that name.
        begin: The first moment, on the monotonic clock [s].
        end: The last.

    Returns:
        The number of messages.

    Raises:
        RecordingError: No file can be read, none has a clock, or the target cannot be written.
    """
    with contextlib.ExitStack() as stack:
        recordings = [stack.enter_context(each) for each in _opened(files)]
        anchors = [each.anchor for each in recordings]
        anchor = next((each for each in reversed(anchors) if each is not None), None)
        if anchor is None:
            text = f"no file of {', '.join(map(str, files))} can be read"
            raise RecordingError(text)
        with NewRecording(target, replace=True) as new:
            copy = _Copy(new, anchor, recordings)
            copy.write_newest(begin)
            for recording, own in zip(recordings, anchors, strict=True):
                if own is not None:
                    copy.write_span(recording, own, begin, end)
    return new.messages


def _opened(files: Sequence[Path]) -> Iterator[Recording]:
    for path in files:
        with contextlib.suppress(RecordingError):
            yield Recording.open(path)


class _Copy:
    """Copies messages into a new file."""

    def __init__(
        self, new: NewRecording, anchor: TimeAnchor, recordings: Sequence[Recording]
    ) -> None:
        self._new, self._anchor, self._recordings = new, anchor, recordings
        about = {**recordings[-1].about.get(ABOUT, {})}
        about |= {"wall_ns": str(anchor.wall_ns), "monotonic": repr(anchor.monotonic)}
        new.add_facts(ABOUT, about)
        for place in recordings[-1].attachments:
            new.attach(place.name, place.media_type, recordings[-1].attachment(place))

    def write_newest(self, begin: float) -> None:
        """Write what held when the span began, as of that moment."""
        newest: dict[str, tuple[RecordedTopic, LoggedMessage, TimeAnchor]] = {}
        for recording in self._recordings:
            own = recording.anchor
            if own is not None:
                for channel, message in recording.newest(own.stamp(begin) - 1).items():
                    topic = recording.channels[channel]
                    newest[topic.name] = topic, message, own
        for topic, message, own in newest.values():
            self._write(topic, message, begin, own)

    def write_span(self, recording: Recording, own: TimeAnchor, begin: float, end: float) -> None:
        """Write the messages of a span."""
        for message in recording.messages(own.stamp(begin), own.stamp(end)):
            self._write(
                recording.channels[message.channel], message, own.moment(message.stamp), own
            )

    def _write(
        self, topic: RecordedTopic, message: LoggedMessage, moment: float, own: TimeAnchor
    ) -> None:
        self._new.add(
            topic,
            self._anchor.stamp(moment),
            self._anchor.stamp(own.moment(message.published)),
            message.number,
            message.payload,
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Write a snapshot; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", type=Path)
    parser.add_argument("begin", type=float)
    parser.add_argument("end", type=float)
    parser.add_argument("files", type=Path, nargs="+")
    options = parser.parse_args(arguments)
    with contextlib.suppress(OSError):
        os.nice(10)
    try:
        write_snapshot(options.files, options.target, options.begin, options.end)
    except (HubError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
