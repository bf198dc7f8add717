"""A bus without sockets, on which time passes only when a test says so."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from hub.ipc.message_info import MessageInfo
from hub.ipc.transport.timers import Timer, Timers


class TimedBus:
    """What a module sees of a `Client`.

    Attributes:
        now: The time [s]; `time.monotonic` returns it too.
        published: What the module published: time [s], name and value.
        watched: Whether its messages have subscribers.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        self.published: list[tuple[float, str, Any]] = []
        self.watched = False
        self.faults = SimpleNamespace(counts=Counter())
        self.directory = SimpleNamespace(follow=self._follow, watch=lambda *_: None)
        self.loop = SimpleNamespace(watch=lambda *_: None, unwatch=lambda _: None)
        self._timers = Timers()
        self._handlers: dict[str, Callable[..., None]] = {}
        self._late: dict[str, Callable[..., None]] = {}
        self._numbers: dict[str, int] = {}
        self._wakers: list[Callable[[float], None]] = []
        self.alarm = self._timers.alarm
        monkeypatch.setattr(time, "monotonic", lambda: self.now)

    def number(self, name: str) -> int:
        """The number of another module."""
        return self._numbers.setdefault(name, len(self._numbers) + 2)

    def send(
        self, definition: Any, value: object, sender: str, age: float = 0.0, *, late: bool = False
    ) -> None:
        """A message of another module comes now.

        Args:
            definition: Which message.
            value: Its value.
            sender: The module.
            age: How long it was on its way [s].
            late: Whether the client finds that this is longer than its lifespan.
        """
        reception = MessageInfo(self.number(sender), 1, 0, age, self.now - age)
        (self._late if late else self._handlers)[definition.name](value, reception)

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        end = self.now + seconds
        while (due := self._timers.due(math.inf)) <= end:
            self.now = max(self.now, due)
            self._timers.run(self.now)
        self.now = end

    def wait_with_faults(self, seconds: float) -> int:
        """Let time pass as `run_module` does: after a fault the loop goes on; returns how many."""
        end, faults = self.now + seconds, 0
        while self.now < end:
            try:
                self.wait(end - self.now)
            except Exception:  # noqa: BLE001 - any, as in the module
                faults += 1
        return faults

    def define(self, *_: object) -> None: ...

    def when_slept(self, work: Callable[[float], None]) -> None:
        self._wakers.append(work)

    def sleep(self, seconds: float) -> None:
        """Let the robot's computer sleep: its clock stands still."""
        for work in self._wakers:
            work(seconds)

    def every(self, period: float, work: Callable[[], None]) -> Timer:
        return self._timers.add(self.now, period, work)

    def query_notify(self, *_: object, **__: object) -> None:
        """Nobody answers."""

    def has_subscribers(self, _: object) -> bool:
        return self.watched

    def publish(self, definition: Any, value: object, **_: object) -> None:
        self.published.append((self.now, definition.name, value))

    def subscribe(
        self,
        definition: Any,
        handler: Callable[..., None],
        *,
        late: Callable[..., None] | None = None,
        **_: object,
    ) -> None:
        self._handlers[definition.name] = handler
        if late is not None:
            self._late[definition.name] = late

    def _follow(self, name: str, connected: Callable[[int], None]) -> None:
        connected(self.number(name))
