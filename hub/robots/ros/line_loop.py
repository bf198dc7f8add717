"""The loop of a thread around one line to a robot with ROS."""

from __future__ import annotations

import selectors
import time
from collections.abc import Callable

from hub.robots.ros.line import RosLine


class LineLoop:
    """Waits for what a line receives; implements `FileLoop`.

    Attributes:
        line: The line; it is closed with the loop.
    """

    def __init__(self, line: RosLine) -> None:
        """Watch a line, which belongs to this loop from now on."""
        self.line = line
        self._selector = selectors.DefaultSelector()
        line.watch(self, self.advance)

    def watch(self, file: int, work: Callable[[], None]) -> None:
        """Call `work` whenever the file descriptor is readable; for the line."""
        self._selector.register(file, selectors.EVENT_READ, work)

    def unwatch(self, file: int) -> None:
        """Stop watching it."""
        self._selector.unregister(file)

    def advance(self) -> None:
        """Let the line do what is due."""
        self.line.advance(time.monotonic())

    def wait(self, seconds: float) -> None:
        """Wait until the line receives something, this time at most [s], and let it read that."""
        for key, _ in self._selector.select(seconds):
            key.data()

    def close(self) -> None:
        """Leave the line."""
        self.line.close()
        self._selector.close()
