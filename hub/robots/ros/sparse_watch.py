"""Wakes a loop for a line at most once between two steps of the body.

A wake asks for the next step while the robot moves, and lets the line measure how long answers
take. More of them would only cost processor time: messages have an age of their own.
"""

from __future__ import annotations

from collections.abc import Callable

from hub.robots.interfaces import FileLoop


class SparseWatch:
    """Implements `FileLoop` for one line."""

    def __init__(self, loop: FileLoop) -> None:
        self._loop = loop
        self._work: Callable[[], None] | None = None
        self._file = -1
        self._watching = False

    def watch(self, file: int, work: Callable[[], None]) -> None:
        """Call `work` when the file descriptor is readable, once after each step."""
        self._file, self._work = file, work
        self.step()

    def unwatch(self, file: int) -> None:
        """Stop watching it."""
        self._rest()
        if file == self._file:
            self._file = -1

    def step(self) -> None:
        """Wake again when something comes."""
        if self._file >= 0 and not self._watching:
            self._watching = True
            self._loop.watch(self._file, self._woken)

    def _woken(self) -> None:
        self._rest()
        if self._work is not None:
            self._work()

    def _rest(self) -> None:
        if self._watching:
            self._watching = False
            self._loop.unwatch(self._file)
