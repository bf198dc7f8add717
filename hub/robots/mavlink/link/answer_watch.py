"""Lets a loop read a link while an answer is awaited, so that its time is known.

| state | event | action |
| --- | --- | --- |
| idle | an answer is awaited, and the link is open | watch its file descriptor |
| watching | bytes | read the link |
| watching | no answer is awaited any more, or the link closes | idle |

Else the owner's period is enough: each wake costs processor time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from hub.robots.interfaces import FileLoop
from hub.robots.mavlink.link.byte_link import ByteLink

_NONE: Final = -1


class AnswerWatch:
    """The watch of one link."""

    def __init__(self, loop: FileLoop, link: ByteLink, read: Callable[[], None]) -> None:
        """Watch nothing yet.

        Args:
            loop: Waits for file descriptors.
            link: The link.
            read: Reads it, and calls `follow`.
        """
        self._loop, self._link, self._read = loop, link, read
        self._file = _NONE
        link.closing = self._end

    def follow(self, *, awaits: bool) -> None:
        """Watch the link from now on if an answer is awaited."""
        if not awaits:
            self._end()
        elif self._file == _NONE and self._link.file != _NONE:
            self._file = self._link.file
            self._loop.watch(self._file, self._read)

    def _end(self) -> None:
        if self._file != _NONE:
            file, self._file = self._file, _NONE
            self._loop.unwatch(file)
