"""The page of shared memory on which the processes of one run keep count, for all buses.

Nothing of a run travels beside the bus but these numbers: who is ready, how many messages were
sent and received, and how long each took.
"""

from __future__ import annotations

import mmap
import time
from collections.abc import Callable
from pathlib import Path

MAX_SUBSCRIBERS = 8
MAX_TIMES = 20_000

PREPARING, MEASURING, DONE = range(3)
_PHASE, _SENT, _START, _END, _STALLS = range(5)
_READY, _RECEIVED, _HIGHEST = range(3)
_BLOCKS = 64
_BLOCK = 8
_TIMES = _BLOCKS + MAX_SUBSCRIBERS * _BLOCK
_WORDS = _TIMES + MAX_SUBSCRIBERS * MAX_TIMES

now = time.monotonic_ns


class Page:
    """64-bit words in a file that every process of the run maps."""

    def __init__(self, path: Path, *, create: bool = False) -> None:
        with path.open("w+b" if create else "r+b") as file:
            if create:
                file.truncate(_WORDS * 8)
            self._map = mmap.mmap(file.fileno(), _WORDS * 8)
        self._words = memoryview(self._map).cast("q")

    @property
    def phase(self) -> int:
        return self._words[_PHASE]

    @property
    def sent(self) -> int:
        return self._words[_SENT]

    @property
    def stalls(self) -> int:
        """How often the sender gave up waiting for messages that did not come."""
        return self._words[_STALLS]

    @property
    def seconds(self) -> float:
        """From the first message until the last was received [s]."""
        return (self._words[_END] - self._words[_START]) * 1e-9

    def begin(self) -> None:
        """The measured part begins; in the pause the observer takes its first readings."""
        self._words[_PHASE] = MEASURING
        time.sleep(0.03)
        self._words[_START] = now()

    def end(self, sent: int, stalls: int) -> None:
        self._words[_END] = now()
        self._words[_SENT] = sent
        self._words[_STALLS] = stalls
        self._words[_PHASE] = DONE

    def set_ready(self, index: int) -> None:
        self._words[_BLOCKS + index * _BLOCK + _READY] = 1

    def ready(self, count: int) -> bool:
        return all(self._words[_BLOCKS + index * _BLOCK + _READY] for index in range(count))

    def received(self, index: int) -> int:
        return self._words[_BLOCKS + index * _BLOCK + _RECEIVED]

    def slowest(self, count: int) -> int:
        """The highest number that every one of `count` subscribers has seen."""
        words = self._words
        first = words[_BLOCKS + _HIGHEST]
        if count == 1:
            return first
        rest = (words[_BLOCKS + index * _BLOCK + _HIGHEST] for index in range(1, count))
        return min(first, *rest)

    def times(self, index: int) -> list[float]:
        """What subscriber `index` has noted [us]."""
        start = _TIMES + index * MAX_TIMES
        count = min(self.received(index), MAX_TIMES)
        return [value * 1e-3 for value in self._words[start : start + count]]

    def counter(self, index: int, *, timed: bool) -> Callable[[int, int], None]:
        """What subscriber `index` calls with the number and the stamp of every message [ns].

        Args:
            index: Which subscriber.
            timed: Whether to note how long each message took.
        """
        words, block = self._words, _BLOCKS + index * _BLOCK
        start = _TIMES + index * MAX_TIMES
        received = 0

        def take(number: int, stamp: int) -> None:
            nonlocal received
            if number == 0:
                words[block] = 1
                return
            if timed and received < MAX_TIMES:
                words[start + received] = now() - stamp
            received += 1
            words[block + _RECEIVED] = received
            words[block + _HIGHEST] = number

        return take

    def note(self, nanoseconds: int) -> None:
        """Add a round trip to the times of subscriber 0."""
        count = self._words[_BLOCKS + _RECEIVED]
        if count < MAX_TIMES:
            self._words[_TIMES + count] = nanoseconds
        self._words[_BLOCKS + _RECEIVED] = count + 1
