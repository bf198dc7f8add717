"""Serves clients from within an asyncio program, such as one with a user interface.

`zmq.asyncio` costs 20 to 40 times as much a message. Here asyncio only watches the descriptors that
the loop would wait on and lets the loop do all that is there, a bounded turn at a time.
"""

from __future__ import annotations

import asyncio

from hub.ipc.loop import Loop, Serve

_LONGEST_S = 1.0


class AsyncioPump:
    """Serves a loop's clients in the thread of the running asyncio loop, until it is closed."""

    def __init__(self, loop: Loop) -> None:
        """Start; the loop must not be listened to by anybody else.

        Raises:
            RuntimeError: No asyncio loop is running.
        """
        self._loop = loop
        self._asyncio = asyncio.get_running_loop()
        self._watched: dict[int, Serve] = {}
        self._timer: asyncio.Handle = self._asyncio.call_soon(self._turn)
        self._closed = False
        self._idle, self._since = 0.0, loop.clock()

    def close(self) -> None:
        """Serve no longer; the clients are closed by who made them."""
        self._closed = True
        self._timer.cancel()
        self._watch({})

    def _turn(self) -> None:
        """One turn of the loop, and when the next is due."""
        self._timer.cancel()
        if self._closed:
            return
        try:
            now = self._loop.clock()
            self._loop.serve(0.0, waited=min(now - self._since, self._idle))
        finally:  # a handler that raises is told to asyncio, and the others go on
            if not self._closed:
                self._watch(self._loop.files())
                # Also when there is more at once: asyncio's own work must have its turn between.
                self._idle, self._since = self._loop.idle_for(_LONGEST_S), self._loop.clock()
                self._timer = self._asyncio.call_later(self._idle, self._turn)

    def _watch(self, files: dict[int, Serve]) -> None:
        for file, serve in self._watched.items():
            if files.get(file) is not serve:
                self._asyncio.remove_reader(file)
        for file, serve in files.items():
            if self._watched.get(file) is not serve:
                self._asyncio.add_reader(file, self._turn)
        self._watched = files
