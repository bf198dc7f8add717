"""Writes clips of a recording while it is shown, in a thread of its own."""

from __future__ import annotations

import importlib.util
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from hub.errors import HubError
from rune_tui.errors import ConsoleError
from rune_tui.replay.clip import ClipOptions, write_clip
from rune_tui.replay.player import Player
from rune_tui.replay.source import ReplaySource

_ENDING_S = 5.0
"""Longest wait for a clip that is dropped [s]."""


class _DroppedError(ConsoleError):
    """The replay ends, and with it the clip."""


class ClipWriter:
    """Writes one clip at a time, beside the recording."""

    def __init__(self, opened: Callable[[], ReplaySource], recording: Path) -> None:
        """Prepare.

        Args:
            opened: Opens the recording, for the thread alone.
            recording: Its file or folder.
        """
        self._opened = opened
        self._place = recording.absolute()
        self._thread: threading.Thread | None = None
        self._dropped = False
        self._share = 0.0
        self._name = ""
        self._result = ""

    @property
    def progress(self) -> str:
        """What it writes, and how far it is; empty: nothing."""
        writes = self._thread is not None and self._thread.is_alive()
        return f"writing {self._name}: {self._share:.0%}" if writes else ""

    def result(self) -> str:
        """What became of the last clip, in one sentence; empty: it was asked for, or none is."""
        if self._thread is None or self._thread.is_alive():
            return ""
        self._thread = None
        result, self._result = self._result, ""
        return result

    def write(self, begin: int, end: int) -> str:
        """Begin to write a clip; returns why not, or empty.

        Args:
            begin: Its begin after that of the recording [ns].
            end: Its end after the begin of the recording [ns].
        """
        if self._thread is not None and self._thread.is_alive():
            return f"{self._name} is still written; wait for it"
        path = self._free(begin, end)
        self._name, self._share = path.name, 0.0
        options = ClipOptions(start=begin, end=end)
        self._thread = threading.Thread(
            target=self._write, args=(path, options), name="clip", daemon=True
        )
        self._thread.start()
        return ""

    def close(self) -> None:
        """Drop what is not complete."""
        self._dropped = True
        if self._thread is not None:
            self._thread.join(_ENDING_S)

    def _write(self, path: Path, options: ClipOptions) -> None:
        try:
            with closing(Player(self._opened)) as player:
                write_clip(player, path, options, self._note)
            self._result = f"{path} is written"
        except _DroppedError:
            pass
        except (ConsoleError, HubError, OSError, ValueError) as error:
            self._result = f"the clip is not written: {error}"

    def _note(self, share: float) -> None:
        if self._dropped:
            raise _DroppedError
        self._share = share

    def _free(self, begin: int, end: int) -> Path:
        """A name that no file has."""
        suffix = ".mp4" if importlib.util.find_spec("av") is not None else ".gif"
        stem = f"{self._place.name}.clip-{_name_of(begin)}-{_name_of(end)}"
        path, number = self._place.with_name(stem + suffix), 2
        while path.exists():
            path, number = self._place.with_name(f"{stem}-{number}{suffix}"), number + 1
        return path


def _name_of(nanoseconds: int) -> str:
    """A time in the name of a file, such as 1m02.5s."""
    tenths = nanoseconds // 100_000_000
    return f"{tenths // 600}m{tenths % 600 / 10:04.1f}s"
