"""A disk that is full, for tests that need no disk of their own."""

from __future__ import annotations

import resource
import signal
import sys


class files_no_longer_than:  # noqa: N801 - reads as words
    """As if the disk were full: the system writes no file beyond this size [bytes].

    Python would write cut caches of the modules that it imports then, so it writes none.
    """

    def __init__(self, size: int) -> None:
        self._size = size

    def __enter__(self) -> None:
        self._caches, sys.dont_write_bytecode = sys.dont_write_bytecode, True
        self._before = resource.getrlimit(resource.RLIMIT_FSIZE)
        self._signal = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (self._size, self._before[1]))

    def __exit__(self, *_: object) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, self._before)
        signal.signal(signal.SIGXFSZ, self._signal)
        sys.dont_write_bytecode = self._caches
