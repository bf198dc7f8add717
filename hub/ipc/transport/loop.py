"""The loop of a module: one thread that serves its connections, timers, files and posted work.

Usually a client has a loop of its own. A program that talks to several centrals at once gives its
clients one loop in common, CMU IPC's contexts: each handler belongs to its client, so it knows the
context its message came from.

A ZeroMQ socket shows by a file descriptor that something happened, once: a call on the
socket since then may have cleared it. So a socket that was touched is looked at in the next turn
whatever its descriptor says, and a socket is read until it is empty. In return the loop waits on
plain descriptors, which costs a fraction of asking every socket each time.
"""

from __future__ import annotations

import math
import select
import selectors
import time
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import zmq

from hub.ipc.transport.timers import CallQueue, Timer, Timers

Serve = Callable[[], bool]
"""Reads a socket; whether there may be more in it."""

_NEGLECT_S = 0.3
"""After a pause this long, what waits in the sockets counts as old [s]."""


_READ = selectors.EVENT_READ


class _Poller(Protocol):
    def register(self, file: int, events: int, /) -> Any: ...
    def unregister(self, file: int, /) -> Any: ...
    def poll(self, timeout: float, /) -> Sequence[tuple[int, int]]: ...
    def close(self) -> None: ...


class _Selector:
    """Waits on systems without epoll(7)."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        self.register, self.unregister = self._selector.register, self._selector.unregister
        self.close = self._selector.close

    def poll(self, timeout: float) -> list[tuple[int, int]]:
        return [(key.fd, events) for key, events in self._selector.select(timeout)]


def _poller() -> _Poller:
    return select.epoll() if hasattr(select, "epoll") else _Selector()


class Participant(Protocol):
    """What has work to do in every turn of a loop."""

    @property
    def pending(self) -> bool:
        """Whether something waits that no socket shows."""

    def due(self, otherwise: float) -> float:
        """When it wants a turn even if nothing comes [s]."""

    def turn(self) -> None:
        """Everything that came was read: do what is due."""

    def neglected(self, time: float) -> None:
        """The loop did not look for `time` [s] longer than it meant to; nothing is read yet."""


class Loop:
    """Serves whatever is registered; one thread owns it and calls everything but `post`.

    Attributes:
        clock: Monotonic time [s].
    """

    def __init__(self, *, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock = clock
        self._poller = _poller()
        self._served: dict[int, Serve] = {}
        self._ready: set[int] = set()
        self._participants: list[Participant] = []
        self._timers = Timers()
        self._posted = CallQueue()
        self._ended = False
        self._looked = math.inf
        self.watch(self._posted.file, self._posted.drain)

    def join(self, participant: Participant) -> None:
        """Give this one a turn too."""
        self._participants.append(participant)

    def leave(self, participant: Participant) -> None:
        """Give it no more turns."""
        self._participants.remove(participant)

    def register(self, socket: zmq.Socket[Any], serve: Serve) -> int:
        """Call `serve` when something may be in the socket; the number to `touch` it with."""
        file = int(socket.fd)
        self._poller.register(file, _READ)
        self._served[file] = serve
        self._ready.add(file)
        return file

    def unregister(self, file: int) -> None:
        """Serve the socket of this number no longer; to be called before it is closed."""
        self._poller.unregister(file)
        del self._served[file]
        self._ready.discard(file)

    def settle(self, file: int) -> None:
        """The socket of this number was found empty after it was touched."""
        self._ready.discard(file)

    def touch(self, file: int) -> None:
        """The socket of this number was sent on, or changed."""
        self._ready.add(file)

    def watch(self, file: int, work: Callable[[], None]) -> None:
        """Call `work` whenever the file descriptor is readable."""

        def serve() -> bool:
            work()
            return False

        self._poller.register(file, _READ)
        self._served[file] = serve

    def unwatch(self, file: int) -> None:
        """Stop watching a file descriptor."""
        self.unregister(file)

    def every(self, period: float, work: Callable[[], None], *, count: float = math.inf) -> Timer:
        """Call `work` every `period` [s], `count` times; late calls are skipped, not made up."""
        return self._timers.add(self.clock(), period, work, count=count)

    def after(self, delay: float, work: Callable[[], None]) -> Timer:
        """Call `work` once, in `delay` [s]."""
        return self._timers.add(self.clock(), delay, work, count=1)

    def post(self, work: Callable[[], None]) -> None:
        """Have `work` called by the loop; the one method that any thread may call."""
        self._posted.add(work)

    def listen(self, timeout: float) -> None:
        """Wait for up to `timeout` [s] and serve what has come."""
        wait = self.idle_for(timeout)
        # Rounded up: to wake before the time would mean another turn for nothing.
        self.serve(math.ceil(wait * 1e3) / 1e3 if wait > 0.0 else 0.0)

    def dispatch(self) -> None:
        """Serve until `end` is called."""
        self._ended = False
        while not self._ended:
            self.listen(1.0)

    def end(self) -> None:
        """Have `dispatch` return, once what is being served is served."""
        self._ended = True

    def idle_for(self, longest: float) -> float:
        """How long nothing needs to be done unless something comes, up to `longest` [s]."""
        if self._ready or self._posted:
            return 0.0
        end = self.clock() + longest
        wake = self._timers.due(end)
        for participant in self._participants:
            if participant.pending:
                return 0.0
            wake = min(wake, participant.due(end))
        return max(0.0, wake - self.clock())

    def serve(self, wait: float = 0.0, *, waited: float = 0.0) -> None:
        """One turn: wait for up to `wait` [s], read what has come, do what is due.

        Args:
            wait: How long to wait for something to come [s].
            waited: How long the caller has waited for it already, on purpose [s].
        """
        ready = self._ready
        for file, _ in self._poller.poll(wait):
            ready.add(file)
        now = self.clock()
        neglect, self._looked = now - self._looked - wait - waited, now
        if neglect > _NEGLECT_S:
            for participant in tuple(self._participants):
                participant.neglected(neglect)
        self._posted.run()
        if ready:
            self._read(ready)
        for participant in tuple(self._participants):
            participant.turn()
        self._timers.run(self.clock())

    def _read(self, ready: set[int]) -> None:
        """Serve the sockets in `ready` in the order in which they were registered."""
        again: list[int] = []
        try:
            while ready:  # a handler may add to it, also by a turn of its own
                file = (
                    ready.pop() if len(ready) == 1 else next(f for f in self._served if f in ready)
                )
                ready.discard(file)
                if file in again:  # touched as it was served; it has its next turn after all others
                    continue
                again.append(file)
                if not self._served[file]():
                    again.remove(file)
        finally:  # after a handler that raised, the rest is still there
            ready.update(file for file in again if file in self._served)

    @property
    def neglect(self) -> float:
        """How long ago the loop last looked for messages [s]."""
        return max(0.0, self.clock() - self._looked)

    def files(self) -> dict[int, Serve]:
        """The descriptors that are waited on, for a program with another loop around this one.

        A descriptor that is served by something else than before was closed, and its number was
        given to another file: it has to be waited on anew.
        """
        return dict(self._served)

    def close(self) -> None:
        """Free the loop; posted work is forgotten."""
        self._poller.close()
        self._posted.close()
