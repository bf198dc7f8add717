"""Between a hub's loop and the threads of Zenoh, both ways.

Both are bounded. Of what has the same name, the newest wins; beyond the bound, the oldest is
dropped and counted.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Hashable

_logger = logging.getLogger(__name__)

Work = Callable[[], None]
MOST_BYTES = 1 << 26
"""Most bytes of the messages that wait for the loop."""
_AT_ONCE = 100
"""Most calls in one turn of the loop, so that a flood does not keep others waiting."""


class _Waiting:
    """Calls in order, bounded; threads may add and take."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._calls: dict[Hashable, tuple[Work, bool, int]] = {}
        self._number = self._bytes = 0
        self.dropped = 0

    def __len__(self) -> int:
        return len(self._calls)

    def add(self, work: Work, name: Hashable | None, *, keep: bool, size: int = 0) -> None:
        """Add a call of `size` [bytes]; one of the same name is replaced, in its place."""
        self._number += 1
        key = ("", self._number) if name is None else name
        before = self._calls.get(key)
        more = size - (before[2] if before else 0)
        while not before and len(self._calls) >= self._most:
            if not self._drop_oldest(key):
                return
        # What is kept, such as a stop, comes in even beyond the bytes.
        while not keep and self._bytes + more > MOST_BYTES:
            if size > MOST_BYTES or not self._drop_oldest(key):
                self.dropped += size > MOST_BYTES
                return
        self._bytes += more
        self._calls[key] = work, keep, size

    def take(self) -> Work | None:
        """The oldest call."""
        if not self._calls:
            return None
        work, _, size = self._calls.pop(next(iter(self._calls)))
        self._bytes -= size
        return work

    def _drop_oldest(self, but: Hashable) -> bool:
        """Drop the oldest call that need not be kept; without one, the new call is dropped."""
        others = (each for each, (_, kept, _) in self._calls.items() if not kept and each != but)
        oldest = next(others, None)
        self.dropped += 1
        if oldest is not None:
            self._bytes -= self._calls.pop(oldest)[2]
        return oldest is not None


class Handover:
    """Calls from any thread, made by the loop of a client.

    Attributes:
        dropped: Number of calls that were dropped, because too many waited.
    """

    def __init__(self, post: Callable[[Work], None], most: int = 1000) -> None:
        """Begin.

        Args:
            post: Has the loop make a call: `Client.post`.
            most: Most calls that wait.
        """
        self._post = post
        self._lock = threading.Lock()
        self._waiting = _Waiting(most)
        self._posted = False

    @property
    def dropped(self) -> int:
        """Number of calls that were dropped, because too many waited."""
        return self._waiting.dropped

    def add(
        self, work: Work, *, name: Hashable | None = None, keep: bool = False, size: int = 0
    ) -> None:
        """Have the loop call `work`.

        Args:
            work: The call.
            name: A waiting call of the same name is replaced.
            keep: Whether others are dropped first when too many wait.
            size: Of its message [bytes].
        """
        with self._lock:
            self._waiting.add(work, name, keep=keep, size=size)
            wake, self._posted = not self._posted, True
        if wake:
            self._post(self._run)

    def _run(self) -> None:
        for _ in range(_AT_ONCE):
            with self._lock:
                work = self._waiting.take()
                if work is None:
                    self._posted = False
                    return
            try:
                work()
            except Exception:  # one bad call must not stop what waits behind it
                _logger.exception("a call from a fleet failed")
        self._post(self._run)


class Sender:
    """A thread that makes calls which may wait for a line: puts and replies.

    Attributes:
        dropped: Number of calls that were dropped, because too many waited or they were too old.
    """

    def __init__(self, name: str, most: int = 200) -> None:
        """Start the thread.

        Args:
            name: Of the thread.
            most: Most calls that wait.
        """
        self._changed = threading.Condition()
        self._waiting = _Waiting(most)
        self._late = 0
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """Number of calls that were dropped, because too many waited or they were too old."""
        return self._waiting.dropped + self._late

    def add(self, work: Work, *, until: float, name: Hashable | None = None) -> None:
        """Have the thread call `work`, unless the monotonic time is past `until` [s] by then.

        A waiting call of the same name is replaced.
        """

        def call() -> None:
            if time.monotonic() > until:
                self._late += 1
            else:
                work()

        with self._changed:
            self._waiting.add(call, name, keep=False)
            self._changed.notify()

    def close(self) -> None:
        """End the thread, without the calls that wait."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join(2.0)

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._closed and not self._waiting:
                    self._changed.wait()
                work = None if self._closed else self._waiting.take()
            if work is None:
                return
            try:
                work()
            except Exception:  # one bad call must not stop the line
                _logger.exception("a put to a fleet failed")
