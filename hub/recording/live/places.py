"""Where the files of a robot's recorder are."""

from __future__ import annotations

import datetime
import itertools
import os
import re
from collections.abc import Callable
from pathlib import Path

from hub.errors import RecordingError
from hub.paths import as_file_name, for_recordings

SUFFIX = ".mcap"


class RecordingFolder:
    """The folder of one robot's recordings.

    Attributes:
        path: The folder.
        ring: The folder of the ring's files.
        snapshots: The folder of snapshots.
        running: The file that says which recording an order began.
    """

    def __init__(self, wanted: str, robot: str) -> None:
        """Name the folders; `wanted` replaces the usual one for all robots."""
        self.path = for_recordings(wanted) / as_file_name(robot)
        self.ring = self.path / "ring"
        self.snapshots = self.path / "snapshots"
        self.running = self.path / "running.json"

    def recording(self, name: str) -> Path:
        """The first file of a new recording of this name."""
        return free_path(self.path / (_safe(name) + SUFFIX))

    def ring_file(self, _number: int) -> Path:
        """The next file of the ring."""
        return free_path(self.ring / (date_name() + SUFFIX))

    def snapshot(self, name: str) -> Path:
        """The file of a snapshot of this name."""
        return free_path(self.snapshots / (_safe(name) + SUFFIX))


def demand_folder(folder: Path) -> None:
    """Make a folder for recordings.

    Raises:
        RecordingError: It cannot be made, or files in it cannot.
    """
    change = "name another folder in [recording] of the robot file"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = error.strerror or str(error)
        text = f"nothing is recorded: {folder} cannot be made: {reason}; {change}"
        raise RecordingError(text) from error
    if not os.access(folder, os.W_OK | os.X_OK):
        text = f"nothing is recorded: {folder} cannot be written: it is read-only; {change}"
        raise RecordingError(text)


def numbered(first: Path) -> Callable[[int], Path]:
    """The next file of a recording that is not there yet: FILE.mcap, FILE_1.mcap, FILE_2.mcap."""

    def path(number: int) -> Path:
        for count in itertools.count(number):
            name = f"{first.stem}_{count}{first.suffix}" if count else first.name
            if not first.with_name(name).exists():
                return first.with_name(name)
        raise AssertionError

    return path


def free_path(path: Path) -> Path:
    """The path itself, or another one beside it if it is taken."""
    number, free = 1, path
    while free.exists():
        number += 1
        free = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return free


def date_name() -> str:
    """The present date and time as the name of a file."""
    return datetime.datetime.now().astimezone().strftime("%Y-%m-%d_%H-%M-%S")


def _safe(name: str) -> str:
    """A name as that of a file; date and time without one."""
    if not name:
        return date_name()
    return re.sub(r"[^A-Za-z0-9._-]", "-", name).lstrip(".-")[:100] or date_name()
