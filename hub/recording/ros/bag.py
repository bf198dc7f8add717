"""Opens what can be replayed: an MCAP file, a .db3 file of rosbag2, or a folder of either.

| in a folder | is |
| --- | --- |
| `*.mcap`, `*.db3` | a split |
| `*.mcap.zstd`, `*.db3.zstd` | a split that is packed as a whole: it is unpacked beside the log |
| `metadata.yaml` | says which splits are missing, and counts the messages of large databases |

A message that rosbag2 packed alone is unpacked when it is read.
"""

from __future__ import annotations

import heapq
import itertools
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from pathlib import Path
from typing import Final, Self

import numpy as np
import zstandard

from hub.errors import RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.budget import Allowance, BudgetError, ReadBudget
from hub.recording.chunks import LoggedMessage, MessageFacts
from hub.recording.open_recording import OpenRecording
from hub.recording.reader import AttachmentPlace, Recording
from hub.recording.ros.metadata import METADATA, BagMetadata
from hub.recording.ros.sqlite_bag import MAGIC, SqliteBag
from hub.recording.topics import RecordedTopic

_ZSTD: Final = b"\x28\xb5\x2f\xfd"
_MOST_SPLITS: Final = 10_000
LEAST_FREE: Final = 1 << 30
"""What unpacking leaves free on the disk [bytes]."""
_BATCH: Final = 10_000
"""Messages of a database that are counted at once."""
_TIMES: Final = 256
"""Unpacked messages count in the budget that are longer than this times their length."""


class Bag(OpenRecording):
    """A file or a folder of splits; the attributes and methods are those of `Recording`.

    Equal topics of several splits are one channel.

    Attributes:
        path: The file or folder.
        start: Stamp of the first message [ns]; 0 without messages.
        end: Stamp of the last message [ns]; 0 without messages.
        channels: Topics by number.
        counts: Number of messages by channel, where the files say it.
        faults: What cannot be read, in sentences.
    """

    def __init__(
        self,
        path: Path,
        splits: Sequence[Recording | SqliteBag],
        faults: list[str],
        metadata: BagMetadata,
        budget: ReadBudget,
    ) -> None:
        """Use `open`."""
        self.path = path
        self._budget = budget
        self._faults = faults
        self._splits = sorted(splits, key=lambda split: (split.start, str(split.path)))
        self.start = min((split.start for split in splits if split.end), default=0)
        self.end = max(split.end for split in splits)
        numbers: dict[tuple[str, str, str, str, bytes], int] = {}
        self.channels: dict[int, RecordedTopic] = {}
        counts: Counter[int] = Counter()
        self.counts: dict[int, int] = counts
        self._numbers: list[dict[int, int]] = []
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        for split in self._splits:
            own: dict[int, int] = {}
            for channel, topic in split.channels.items():
                key = (
                    *(topic.name, topic.schema_name, topic.encoding, topic.schema_encoding),
                    topic.schema,
                )
                own[channel] = numbers.setdefault(key, len(numbers) + 1)
                self.channels.setdefault(own[channel], topic)
                if channel in split.counts:
                    counts[own[channel]] += split.counts[channel]
            self._numbers.append(own)
        self._count(metadata)

    @classmethod
    def open(cls, path: Path, *, partial: bool = False, unpacked: int = 0) -> Self:
        """Open a file or folder; a folder with one good split is open, `faults` has the others.

        Args:
            path: The file or folder.
            partial: See `Recording.open`.
            unpacked: Most bytes that are unpacked; 0: by its size, see `ReadBudget`.

        Raises:
            RecordingError: Nothing of it can be read.
        """
        if not path.exists():
            text = f"{path} does not exist"
            raise RecordingError(text)
        metadata = BagMetadata.of(path if path.is_dir() else path.parent)
        if not path.is_dir() and path.suffix != ".zstd":
            budget = ReadBudget(path.stat().st_size, unpacked)
            return cls(path, [_opened(path, budget, partial=partial)], [], metadata, budget)
        return cls._of_several(path, metadata, partial=partial, unpacked=unpacked)

    @classmethod
    def _of_several(
        cls, path: Path, metadata: BagMetadata, *, partial: bool, unpacked: int
    ) -> Self:
        """Open the splits of a folder, or what is packed in a file.

        Raises:
            RecordingError: Nothing of it can be read.
        """
        files, faults = _files(path, metadata) if path.is_dir() else ([path], [])
        budget = ReadBudget(sum(each.stat().st_size for each in files if each.is_file()), unpacked)
        folder = None
        splits: list[Recording | SqliteBag] = []
        for file in files:
            try:
                plain = file
                if file.suffix == ".zstd":
                    folder = folder or tempfile.TemporaryDirectory(prefix="rune-bag-")
                    plain = _unpacked_file(file, Path(folder.name), budget)
                splits.append(_opened(plain, budget, partial=partial))
            except RecordingError as error:
                faults.append(str(error))
        if not splits:
            if folder is not None:
                folder.cleanup()
            reason = "; ".join(faults[:3]) or "there is no .mcap or .db3 file in it"
            text = f"{path} cannot be read: {reason}"
            raise RecordingError(text)
        made = cls(path, splits, faults, metadata, budget)
        made._folder = folder
        return made

    def _count(self, metadata: BagMetadata) -> None:
        """Take the number of messages from the metadata, where a split does not say it."""
        files = sorted(Path(name).name.removesuffix(".zstd") for name in metadata.files)
        if files != sorted(split.path.name for split in self._splits):
            return
        if all(split.counts for split in self._splits):
            return
        names = Counter(topic.name for topic in self.channels.values())
        for channel, topic in self.channels.items():
            if names[topic.name] == 1 and topic.name in metadata.counts:
                self.counts[channel] = metadata.counts[topic.name]

    def close(self) -> None:
        """Close all files."""
        for split in self._splits:
            split.close()
        if self._folder is not None:
            self._folder.cleanup()

    @property
    def faults(self) -> list[str]:
        """What cannot be read, in sentences."""
        return [*self._faults, *(each for split in self._splits for each in split.faults)]

    @property
    def anchor(self) -> TimeAnchor | None:
        """The clock of the writer of the first split; None: the file does not say it."""
        return self._splits[0].anchor

    @property
    def about(self) -> Mapping[str, Mapping[str, str]]:
        """Metadata by name; that of earlier splits counts."""
        found: dict[str, Mapping[str, str]] = {}
        for split in reversed(self._splits):
            found |= split.about
        return found

    @property
    def attachments(self) -> tuple[AttachmentPlace, ...]:
        """Files within the first split."""
        return self._splits[0].attachments

    def attachment(self, place: AttachmentPlace) -> bytes:
        """The content of a file within the first split.

        Raises:
            RecordingError: It is damaged, or the split has no such file.
        """
        first = self._splits[0]
        if isinstance(first, Recording):
            return first.attachment(place)
        text = f"{first.path} has no files within it"
        raise RecordingError(text)

    @property
    def finished(self) -> bool:
        """All files have their index."""
        return all(each.finished for each in self._splits if isinstance(each, Recording))

    def facts(self) -> Iterator[MessageFacts]:
        """Facts of all messages, part after part."""
        for split, numbers in zip(self._splits, self._numbers, strict=True):
            if isinstance(split, Recording):
                table = np.zeros(1 << 16, np.uint16)
                table[list(numbers)] = list(numbers.values())
                for facts in split.facts():
                    yield facts._replace(channels=table[facts.channels])
            else:
                messages = (each for each in split.messages() if each.channel in numbers)
                while batch := list(itertools.islice(messages, _BATCH)):
                    yield MessageFacts(
                        np.array([numbers[each.channel] for each in batch], np.uint16),
                        np.array([each.stamp for each in batch], np.uint64),
                        np.array([each.number for each in batch], np.uint32),
                        np.array([len(each.payload) for each in batch], np.uint64),
                        np.zeros(0, np.uint64),
                    )

    def check(self, deadline: float) -> None:
        """Look for damage in parts of MCAP files until a time [s, monotonic clock].

        `faults` has what was found.
        """
        for split in self._splits:
            if isinstance(split, Recording):
                for _ in split.facts():
                    if time.monotonic() >= deadline:
                        return

    @property
    def unreadable(self) -> int:
        """Length of what is damaged in MCAP files [bytes], after `salvage`."""
        return sum(each.unreadable for each in self._splits if isinstance(each, Recording))

    def salvage(self) -> Iterator[LoggedMessage]:
        """All messages, split after split; see `Recording.salvage`."""
        left = self._budget.of_pass()
        for split, numbers in zip(self._splits, self._numbers, strict=True):
            found = split.salvage() if isinstance(split, Recording) else split.messages()
            for message in found:
                if message.channel in numbers:
                    yield self._unpacked(message, left)._replace(channel=numbers[message.channel])

    def _unpacked(self, message: LoggedMessage, left: Allowance) -> LoggedMessage:
        """The message as it was before rosbag2 packed it alone."""
        packed, part = message.payload, self._budget.part
        if packed[:4] != _ZSTD:  # no payload of ROS 2 begins so
            return message
        most = min(part, 1 + _TIMES * len(packed))
        try:
            said = zstandard.frame_content_size(packed)  # -1: it does not say
            with zstandard.ZstdDecompressor().stream_reader(packed) as reader:
                payload = reader.read(most)
                if len(payload) == most:
                    left.take(min(said, part) if said >= 0 else part)
                    payload += reader.read(part - most)
                    if reader.read(1):
                        text = f"a message in it unpacks to more than {part} bytes"
                        raise BudgetError(text)
        except zstandard.ZstdError:
            return message
        except BudgetError as error:
            if str(error) not in self._faults:
                self._faults.append(str(error))
            return message
        return message._replace(payload=payload)

    def newest(
        self, stamp: int, channels: AbstractSet[int] | None = None
    ) -> dict[int, LoggedMessage]:
        """The last message of each channel at or before a time [ns]; see `Recording.newest`."""
        found: dict[int, LoggedMessage] = {}
        unpacked = self._budget.of_pass()
        left = set(self.channels) if channels is None else set(channels)
        order = sorted(range(len(self._splits)), key=lambda at: -self._splits[at].end)
        for at in order:
            split, numbers = self._splits[at], self._numbers[at]
            # Neither this split nor those that end before it have newer ones.
            left -= {number for number, each in found.items() if each.stamp >= split.end}
            own = {channel for channel, number in numbers.items() if number in left}
            if split.start > stamp or not own:
                continue
            for channel, message in split.newest(stamp, own).items():
                number = numbers[channel]
                if number not in found or found[number].stamp < message.stamp:
                    found[number] = self._unpacked(message, unpacked)._replace(channel=number)
        return found

    def messages(
        self,
        start: int | None = None,
        end: int | None = None,
        channels: AbstractSet[int] | None = None,
        *,
        reverse: bool = False,
    ) -> Iterator[LoggedMessage]:
        """All messages by stamp; see `Recording.messages`."""
        first = self.start if start is None else start
        last = self.end if end is None else end
        left = self._budget.of_pass()

        def of(split: Recording | SqliteBag, numbers: Mapping[int, int]) -> Iterator[LoggedMessage]:
            own = None
            if channels is not None:
                own = {channel for channel, number in numbers.items() if number in channels}
            for message in split.messages(first, last, own, reverse=reverse):
                if message.channel in numbers:
                    yield self._unpacked(message, left)._replace(channel=numbers[message.channel])

        parts = [
            of(split, numbers)
            for split, numbers in zip(self._splits, self._numbers, strict=True)
            if split.start <= last and split.end >= first
        ]
        return heapq.merge(*parts, key=lambda message: message.stamp, reverse=reverse)


def _files(folder: Path, metadata: BagMetadata) -> tuple[list[Path], list[str]]:
    """The splits in a folder, and which ones are missing, in sentences."""
    try:
        names = sorted(each.name for each in folder.iterdir())
    except OSError as error:
        text = f"{folder} cannot be read: {error.strerror}"
        raise RecordingError(text) from error
    endings = (".mcap", ".db3", ".mcap.zstd", ".db3.zstd")
    packed = {name.removesuffix(".zstd") for name in names}
    # A split that was unpacked beside its packed file counts once.
    found = [
        folder / name
        for name in names
        if name.endswith(endings) and not (name.endswith(".zstd") and name[:-5] in names)
    ][:_MOST_SPLITS]
    missing = [
        name for name in metadata.files if Path(name).name.removesuffix(".zstd") not in packed
    ]
    return found, [f"{METADATA} names {name[:80]}, which is missing" for name in missing]


def _opened(path: Path, budget: ReadBudget, *, partial: bool) -> Recording | SqliteBag:
    try:
        with path.open("rb") as file:
            head = file.read(len(MAGIC))
    except OSError as error:
        text = f"{path} cannot be read: {error.strerror}"
        raise RecordingError(text) from error
    if head == MAGIC:
        return SqliteBag.open(path)
    return Recording.open(path, partial=partial, budget=budget)


def _unpacked_file(path: Path, folder: Path, budget: ReadBudget) -> Path:
    """A copy of a packed file, unpacked.

    Raises:
        BudgetError: It is longer than the budget allows.
        RecordingError: It is damaged, or the disk lacks the room.
    """
    copy = folder / path.name.removesuffix(".zstd")
    room = shutil.disk_usage(folder).free - LEAST_FREE
    try:
        with path.open("rb") as packed, copy.open("wb") as out:
            for block in zstandard.ZstdDecompressor().read_to_iter(packed, write_size=1 << 20):
                room -= len(block)
                budget.all_files.take(len(block), path)
                if room < 0:
                    text = f"{path} is not unpacked: {folder} has no room for it"
                    raise RecordingError(text)
                out.write(block)
    except zstandard.ZstdError as error:
        # The part before the damage may be readable.
        if not copy.stat().st_size:
            text = f"{path} cannot be unpacked: {error}"
            raise RecordingError(text) from error
    except OSError as error:
        text = f"{path} cannot be unpacked: {error.strerror}"
        raise RecordingError(text) from error
    return copy
