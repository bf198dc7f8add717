"""What a recorder records and keeps: the table [recording] of a robot file."""

from __future__ import annotations

import re

from hub import toml_reader as toml
from hub.gcm.vision import ImageCoding
from hub.recording.live import words
from hub.toml_reader import choice, key, several, text, truth
from hub.values import dataclass

RING_SPLIT_S = 60.0
"""Length of a file of the ring, which is deleted as a whole [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureSettings:
    """The pictures of a recording: the recorder asks the cameras for them.

    Attributes:
        rate: Of each camera [1/s].
        size: Largest width and height [pixels].
        format: Coding.
    """

    rate: float = key(
        words.said(words.rate_of, "up to 100"), 5.0, "pictures a second of each camera; 0: none"
    )
    size: tuple[int, int] = key(
        words.said(words.size_of, "1 to 8192 each"),
        (320, 240),
        "largest width and height [pixels]",
        without="[320, 240]",
    )
    format: ImageCoding = key(
        choice({each.name: each for each in ImageCoding}),
        ImageCoding.WEBP,
        "coding of the pictures",
        without="`WEBP`",
    )


def _pictures(value: object) -> PictureSettings:
    problems = toml.Problems()
    fields = toml.read_table(toml.keys_of(PictureSettings), value, "pictures", problems)
    if problems:
        raise toml.RefusedError("; ".join(problems))
    return PictureSettings(**fields)


_PATTERNS = several(words.pattern_of, 100)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingTable:
    """The table `[recording]` of a robot file; each field has its `key` there."""

    always: bool = key(truth, default=False, meaning="record from the start of the hub")
    keep: float = key(
        words.said(words.seconds_of, "a span of time"),
        0.0,
        "with `always`: keep only so much, such as `2h`, and delete what is older",
        without="everything",
    )
    most: int = key(
        words.said(words.file_bytes_of, "a size from 1 MB"),
        8 * 2**30,
        "with `keep`: size above which the oldest files are deleted too",
        without="`8 GiB`",
    )
    split: tuple[float, int] = key(
        words.said(words.split_of, "a span of time, or a size from 1 MB"),
        (0.0, 0),
        "go on in a new file after this time or at this size, such as `10 min` or `500 MB`",
        without="one file; with `keep` `60 s`",
    )
    file: str = key(
        text(1000), "", "with `always`, without `keep`: the first file", without="date and time"
    )
    folder: str = key(text(1000), "", "where recordings are kept", without="the user's own")
    least_free: int = key(
        words.said(words.bytes_of, "a size"),
        2**30,
        "room on the disk below which nothing is recorded",
        without="`1 GiB`",
    )
    pictures: PictureSettings = key(
        _pictures,
        PictureSettings(),
        "a table with `rate`, `size` and `format`",
        without='`{ rate = 5, size = [320, 240], format = "WEBP" }`',
    )
    maps: float = key(
        words.said(words.seconds_of, "a span of time"),
        10.0,
        "time between two maps; 0: none",
        without="`10 s`",
    )
    topics: tuple[re.Pattern[str], ...] = key(
        _PATTERNS, (), "regular expressions: record only topics with one of them", without="all"
    )
    exclude: tuple[re.Pattern[str], ...] = key(
        _PATTERNS, (), "regular expressions: leave out topics with one of them", without="none"
    )
    ros_names: bool = key(
        truth, default=False, meaning="name topics as ROS 2 does where it has a name: `/tf`"
    )
    wake: bool = key(
        truth,
        default=False,
        meaning="keep modules for pictures, maps and the robot's state running for the recording",
    )

    @property
    def rings(self) -> bool:
        """Whether only the last part of all time is kept."""
        return self.always and self.keep > 0.0

    def chooses(self, topic: str) -> bool:
        """Whether a topic is recorded."""
        return not (
            (self.topics and not any(each.search(topic) for each in self.topics))
            or any(each.search(topic) for each in self.exclude)
        )
