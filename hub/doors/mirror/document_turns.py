"""Which document of a robot is read when: a flood of large ones must not hold up the rest; pure."""

from __future__ import annotations

from collections.abc import Callable

from hub.bucket import Bucket

_AT_ONCE, _PER_S = 10.0, 2.0
"""Documents of a robot that are read at once, and in the long run: a large one takes 20 ms."""


class DocumentTurns:
    """The newest document of each key waits for its turn."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """Have none."""
        self._clock = clock
        self._bucket = Bucket(_PER_S, _AT_ONCE)
        self._waiting: dict[str, Callable[[], None]] = {}

    def add(self, key: str, read: Callable[[], None]) -> None:
        """Have a document read, in place of one of the same key that waits."""
        self._waiting[key] = read
        self.work()

    def work(self) -> None:
        """Read those whose turn it is; call it often."""
        while self._waiting and self._bucket.take(1.0, self._clock()):
            self._waiting.pop(next(iter(self._waiting)))()

    def clear(self) -> None:
        """Read none that waits."""
        self._waiting.clear()
