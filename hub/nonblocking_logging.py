"""Logging that never waits: a held terminal or an unread pipe must not stop a robot.

Records go into a bounded queue and a thread writes them to standard error. When the queue is full,
records are dropped and counted, and the next line that gets through says how many.
"""

from __future__ import annotations

import atexit
import contextlib
import logging
import os
import queue
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable

from hub.bucket import Bucket
from hub.plain_text import plain

LEVELS = ("debug", "info", "warning", "error")
"""The names of log levels."""

AT_ONCE, PER_S = 50, 1.0
"""Lines of one place in the program: in one burst, and each second; more are left out."""
_ROOM = 1000
_LAST_WORDS_S = 0.5
"""How long the end of the process waits for the last lines to be written [s]."""


class Bound:
    """Bounds how often one place in the program logs.

    So a client with many refused requests does not fill the disk, or push older lines out of a log
    file.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Start without a place.

        Args:
            clock: Monotonic time [s].
        """
        self._clock = clock
        self._places: dict[tuple[str, int], Bucket] = {}
        self._left_out: Counter[tuple[str, int]] = Counter()

    def before(self, record: logging.LogRecord) -> int | None:
        """How many lines of its place were left out before it; None: it is left out too."""
        if record.levelno <= logging.DEBUG:
            return 0
        place = record.pathname, record.lineno
        if not self._places.setdefault(place, Bucket(PER_S, AT_ONCE)).take(1.0, self._clock()):
            self._left_out[place] += 1
            return None
        return self._left_out.pop(place, 0)


class NonBlockingHandler(logging.Handler):
    """Hands records to a thread of its own."""

    def __init__(self) -> None:
        super().__init__()
        self._bound = Bound()
        self._queue: queue.Queue[str] = queue.Queue(_ROOM)
        self._dropped = 0
        threading.Thread(target=self._write, name="log", daemon=True).start()

    def emit(self, record: logging.LogRecord) -> None:
        """Put the record's line into the queue, or count it as left out or dropped."""
        left_out = self._bound.before(record)
        if left_out is None:
            return
        more = f" ({left_out} lines like it were left out)" if left_out else ""
        self.pass_on(plain(self.format(record), lines=True) + more + "\n")

    def pass_on(self, line: str) -> None:
        """Put a whole line into the queue, or count it as dropped."""
        if self._dropped:
            line = f"({self._dropped} lines dropped)\n{line}"
        try:
            self._queue.put_nowait(line)
        except queue.Full:
            self._dropped += 1
        else:
            self._dropped = 0

    def last_words(self) -> None:
        """Give the thread a short time to write the queue."""
        end = time.monotonic() + _LAST_WORDS_S
        while self._queue.unfinished_tasks and time.monotonic() < end:
            time.sleep(0.005)

    def _write(self) -> None:
        while True:
            line = self._queue.get()
            # Standard error is closed or full: nothing can report this.
            with contextlib.suppress(OSError, ValueError, AttributeError):
                # Past the buffer of Python: a full pipe would hold its lock, which the end of the
                # process takes.
                os.write(sys.stderr.fileno(), line.encode(errors="backslashreplace"))
            self._queue.task_done()


def pass_on(line: str) -> None:
    """Write a line that another process has logged, as it is."""
    for handler in logging.getLogger().handlers:
        if isinstance(handler, NonBlockingHandler):
            handler.pass_on(line)


def start_logging(name: str, level: int) -> None:
    """Log to standard error under this name, from now to the end of the process."""
    handler = NonBlockingHandler()
    handler.setFormatter(logging.Formatter(f"%(asctime)s {name} %(levelname)s %(message)s"))
    logging.basicConfig(level=level, handlers=[handler])
    atexit.register(handler.last_words)
