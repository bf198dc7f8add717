"""Timers of a loop, and calls from other threads."""

from __future__ import annotations

import collections
import contextlib
import logging
import math
import os
import threading
from collections.abc import Callable

_logger = logging.getLogger(__name__)


class Timer:
    """Work that is due once, repeatedly, or whenever its owner says.

    Attributes:
        due: Next time [s]; its owner may change it.
    """

    __slots__ = ("_work", "due", "left", "period")

    def __init__(self, due: float, period: float, count: float, work: Callable[[], None]) -> None:
        self.due = due
        self.period = period
        self.left = count
        self._work = work

    def cancel(self) -> None:
        """Stop."""
        self.left = 0

    def run(self, now: float) -> None:
        """Do the work at `now` [s], and set its next time."""
        self.left -= 1
        self.due += self.period
        if self.due <= now:
            self.due = now + self.period  # late calls are skipped
        self._work()


class Timers:
    """All timers of one loop."""

    def __init__(self) -> None:
        self._timers: list[Timer] = []

    def add(
        self, now: float, period: float, work: Callable[[], None], *, count: float = math.inf
    ) -> Timer:
        """Call `work` `count` times, first one `period` [s] after `now` [s]."""
        timer = Timer(now + period, period, count, work)
        self._timers.append(timer)
        return timer

    def alarm(self, work: Callable[[], None]) -> Timer:
        """Call `work` once at each time that the owner sets as `due` [s]; none is set yet."""
        timer = Timer(math.inf, math.inf, math.inf, work)
        self._timers.append(timer)
        return timer

    def due(self, otherwise: float) -> float:
        """Time of the next call [s]; `otherwise`: there is none."""
        return min((timer.due for timer in self._timers if timer.left > 0), default=otherwise)

    def run(self, now: float) -> None:
        """Do the work that is due at `now` [s]."""
        for timer in self._timers:
            if timer.left > 0 and timer.due <= now:
                timer.run(now)
        if any(timer.left <= 0 for timer in self._timers):
            self._timers = [timer for timer in self._timers if timer.left > 0]


class CallQueue:
    """Work from other threads, with a pipe that wakes the loop's thread.

    Attributes:
        file: Readable when work may wait.
    """

    def __init__(self) -> None:
        self._work: collections.deque[Callable[[], None]] = collections.deque()
        # Reentrant, because signal handlers post too.
        self._lock = threading.RLock()
        self.file, self._wake = os.pipe()
        os.set_blocking(self.file, False)
        os.set_blocking(self._wake, False)

    def __len__(self) -> int:
        return len(self._work)

    def add(self, work: Callable[[], None]) -> None:
        """Add work; any thread may call this, even after `close`."""
        self._work.append(work)
        with self._lock:
            if self._wake < 0:
                # Another file may have the number of the closed file by now.
                _logger.debug("posted to a closed loop")
                return
            # A full pipe wakes the thread as well.
            with contextlib.suppress(BlockingIOError):
                os.write(self._wake, b"\0")

    def drain(self) -> None:
        """Forget the wake-ups."""
        with contextlib.suppress(BlockingIOError):
            while os.read(self.file, 4096):
                pass

    def run(self) -> None:
        """Do all posted work."""
        while self._work:
            self._work.popleft()()

    def close(self) -> None:
        """Free the pipe."""
        with self._lock:
            if self._wake >= 0:
                os.close(self.file)
                os.close(self._wake)
                self._wake = -1
