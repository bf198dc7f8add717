"""The loop of a module: one thread that serves its connections, timers, files and posted work.

Usually a client has a loop of its own. Clients of several centrals in one program share a loop,
like CMU IPC's contexts: each handler belongs to one client, and so to one context.

A ZeroMQ socket signals an event once, by a file descriptor; any later call on the socket may clear
the signal. So the next turn checks each touched socket, and a socket is read until it is empty. In
return the loop waits on plain descriptors, at a fraction of the cost of polling every socket.
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
from hub.machine_sleep import MachineSleep

Serve = Callable[[], bool]
"""Reads a socket; whether there may be more."""

_STALL_S = 0.3
"""Pause after which the messages in the sockets count as old [s]."""


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
    """A part of a program that works in every turn of a loop."""

    @property
    def pending(self) -> bool:
        """Whether work waits that no socket shows."""

    def due(self, otherwise: float) -> float:
        """Time of its next turn without input [s]."""

    def turn(self) -> None:
        """Do the work that is due; all sockets are read."""

    def stalled(self, time: float, slept: float) -> None:
        """The loop paused for `time` [s] more than it intended; nothing is read yet.

        For `slept` [s] of that the machine slept, and its clock stood still.
        """


class Loop:
    """Serves sockets, files and timers; one thread owns it and calls all methods but `post`.

    Attributes:
        clock: Monotonic time [s].
    """

    def __init__(
        self, *, clock: Callable[[], float] = time.monotonic, sleep: MachineSleep | None = None
    ) -> None:
        self.clock = clock
        self._sleep = sleep or MachineSleep()
        self._sleep.look()
        self._wakers: list[Callable[[float], None]] = []
        self._poller = _poller()
        self._served: dict[int, Serve] = {}
        self._ready: set[int] = set()
        self._participants: list[Participant] = []
        self._timers = Timers()
        self._posted = CallQueue()
        self._last_turn = math.inf
        self.watch(self._posted.file, self._posted.drain)

    def join(self, participant: Participant) -> None:
        """Add a participant."""
        self._participants.append(participant)

    def leave(self, participant: Participant) -> None:
        """Remove a participant."""
        self._participants.remove(participant)

    def register(self, socket: zmq.Socket[Any], serve: Serve) -> int:
        """Call `serve` when the socket may have input; returns the number for `touch`."""
        file = int(socket.fd)
        self._poller.register(file, _READ)
        self._served[file] = serve
        self._ready.add(file)
        return file

    def unregister(self, file: int) -> None:
        """Stop serving the socket of this number; call this before its close."""
        self._poller.unregister(file)
        del self._served[file]
        self._ready.discard(file)

    def settle(self, file: int) -> None:
        """Note that a touched socket was empty."""
        self._ready.discard(file)

    def touch(self, file: int) -> None:
        """Note a call on the socket of this number."""
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
        """Call `work` every `period` [s], `count` times; late calls are skipped."""
        return self._timers.add(self.clock(), period, work, count=count)

    def after(self, delay: float, work: Callable[[], None]) -> Timer:
        """Call `work` once, in `delay` [s]."""
        return self._timers.add(self.clock(), delay, work, count=1)

    def alarm(self, work: Callable[[], None]) -> Timer:
        """Call `work` once at each time that the caller sets as the timer's `due` [s]."""
        return self._timers.alarm(work)

    def when_slept(self, work: Callable[[float], None]) -> None:
        """Call `work` with the time [s] after each sleep of this machine, before input is read."""
        self._wakers.append(work)

    def post(self, work: Callable[[], None]) -> None:
        """Let the loop call `work`; the only method that any thread may call."""
        self._posted.add(work)

    def listen(self, timeout: float) -> None:
        """Wait for up to `timeout` [s], and serve the input."""
        wait = self.idle_for(timeout)
        # Rounded up: waking before the time would cost a useless turn.
        self.serve(math.ceil(wait * 1e3) / 1e3 if wait > 0.0 else 0.0)

    def idle_for(self, longest: float) -> float:
        """Time until the next work without input, up to `longest` [s]."""
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
        """Do one turn: wait for up to `wait` [s], read the input, do the work that is due.

        Args:
            wait: Longest wait for input [s].
            waited: Intended wait of the caller before this turn [s].
        """
        ready = self._ready
        for file, _ in self._poller.poll(wait):
            ready.add(file)
        slept = self._sleep.look()
        now = self.clock()
        stall_time, self._last_turn = now - self._last_turn - wait - waited, now
        if slept > 0.0:
            for work in self._wakers:
                work(slept)
        if slept > 0.0 or stall_time > _STALL_S:
            for participant in tuple(self._participants):
                participant.stalled(stall_time + slept, slept)
        self._posted.run()
        if ready:
            self._read(ready)
        for participant in tuple(self._participants):
            participant.turn()
        self._timers.run(self.clock())

    def _read(self, ready: set[int]) -> None:
        """Serve the sockets in `ready`, in the order of their registration."""
        again: list[int] = []
        try:
            while ready:  # a handler may add to it, even by a turn of its own
                file = (
                    ready.pop() if len(ready) == 1 else next(f for f in self._served if f in ready)
                )
                ready.discard(file)
                if file in again:  # touched by its own service: its turn is last
                    continue
                again.append(file)
                if not self._served[file]():
                    again.remove(file)
        finally:  # after a handler that raised, the rest remains
            ready.update(file for file in again if file in self._served)

    @property
    def stall_time(self) -> float:
        """Time since the loop last checked for messages [s]."""
        return max(0.0, self.clock() - self._last_turn)

    def files(self) -> dict[int, Serve]:
        """The watched descriptors, for a program with another loop around this one.

        A descriptor with another server than before was closed, and its number belongs to another
        file: the program has to register it again.
        """
        return dict(self._served)

    def close(self) -> None:
        """Free the loop, without doing posted work."""
        self._poller.close()
        self._posted.close()
