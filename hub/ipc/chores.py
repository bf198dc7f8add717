"""What a client does beside messages: timers, and work that other threads post to it."""

from __future__ import annotations

import collections
import contextlib
import logging
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass

_logger = logging.getLogger(__name__)


@dataclass(slots=True)
class _Timer:
    due: float
    period: float
    work: Callable[[], None]


class Timers:
    """Work that is due again and again."""

    def __init__(self) -> None:
        self._timers: list[_Timer] = []

    def add(self, now: float, period: float, work: Callable[[], None]) -> None:
        """Call `work` every `period` [s] from `now` [s] on, the first time after one period."""
        self._timers.append(_Timer(now + period, period, work))

    def due(self, otherwise: float) -> float:
        """When the next is due [s]; `otherwise` if there is none."""
        return min((timer.due for timer in self._timers), default=otherwise)

    def run(self, now: float) -> None:
        """Call what is due at `now` [s]; late calls are skipped, not made up for."""
        for timer in self._timers:
            if timer.due <= now:
                timer.due += timer.period
                if timer.due <= now:
                    timer.due = now + timer.period
                timer.work()


class Posted:
    """Work from other threads, with a pipe that wakes the thread that does it.

    Attributes:
        file: Readable when there may be work.
    """

    def __init__(self) -> None:
        self._work: collections.deque[Callable[[], None]] = collections.deque()
        # Reentrant, because signal handlers post as well.
        self._lock = threading.RLock()
        self.file, self._wake = os.pipe()
        os.set_blocking(self.file, False)
        os.set_blocking(self._wake, False)

    def __len__(self) -> int:
        return len(self._work)

    def add(self, work: Callable[[], None]) -> None:
        """Have `work` done; any thread may call this, also when it is too late."""
        self._work.append(work)
        with self._lock:
            if self._wake < 0:
                # The number of the closed file may be another file's by now.
                _logger.debug("posted to a closed client")
                return
            # A full pipe wakes just as well.
            with contextlib.suppress(BlockingIOError):
                os.write(self._wake, b"\0")

    def drain(self) -> None:
        """Forget the wake-ups."""
        with contextlib.suppress(BlockingIOError):
            while os.read(self.file, 4096):
                pass

    def run(self) -> None:
        """Do all that is there."""
        while self._work:
            self._work.popleft()()

    def close(self) -> None:
        """Free the pipe."""
        with self._lock:
            os.close(self.file)
            os.close(self._wake)
            self._wake = -1
