"""Reads what is needed of metadata.yaml, which rosbag2 writes beside its splits."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from hub.errors import RecordingError
from hub.values import dataclass

METADATA: Final = "metadata.yaml"
_MOST_METADATA: Final = 1 << 24
_LISTED = re.compile(r"relative_file_paths:[ ]*\n((?:[ ]*-[^\n]*\n?)+)")
_ENTRY = re.compile(r"^[ ]*-[ ]+(?=topic_metadata:|message_count:)", re.MULTILINE)
_NAME = re.compile(r"^[ ]*name:[ ]+([^\n]+)", re.MULTILINE)
_COUNT = re.compile(r"^[ ]*message_count:[ ]+(\d{1,18})[ ]*$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class BagMetadata:
    """What metadata.yaml says of a folder; a folder without it has nothing of it.

    Attributes:
        files: Names of the splits.
        counts: Number of messages by the name of the topic.
    """

    files: tuple[str, ...]
    counts: Mapping[str, int]

    @classmethod
    def of(cls, folder: Path) -> BagMetadata:
        """Read the metadata of a folder.

        Raises:
            RecordingError: The file is there, and cannot be read.
        """
        path = folder / METADATA
        try:
            if not path.is_file():
                return cls((), {})
            with path.open("rb") as file:
                raw = file.read(_MOST_METADATA)
        except OSError as error:
            text = f"{path} cannot be read: {error.strerror}"
            raise RecordingError(text) from error
        text = raw.decode("utf-8", "replace").replace("\r\n", "\n")
        listed = _LISTED.search(text)
        lines = listed[1].splitlines() if listed else []
        return cls(tuple(_bare(line.strip().removeprefix("-")) for line in lines), _counts(text))


def _counts(text: str) -> dict[str, int]:
    """Number of messages by topic; the writers have name and count in either order."""
    found: dict[str, int] = {}
    for entry in _ENTRY.split(text.partition("topics_with_message_count:")[2])[1:]:
        name, count = _NAME.search(entry), _COUNT.search(entry)
        if name is not None and count is not None:
            found[_bare(name[1])] = found.get(_bare(name[1]), 0) + int(count[1])
    return found


def _bare(text: str) -> str:
    return text.strip().strip("\"'")
