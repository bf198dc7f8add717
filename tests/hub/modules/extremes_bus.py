"""A bus without sockets: it hands extreme messages to a module's real handlers.

What the module publishes, answers and asks is encoded and read again: our own modules say nothing
that is out of its range.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections import Counter, defaultdict
from collections.abc import Callable
from random import Random
from types import SimpleNamespace
from typing import Any

from hub.errors import CodecError, HubError, QueryTimeoutError
from hub.gcm.catalog import BY_NAME
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from tests.support import extremes

OWN = 1


def _unheard(*_: Any, **__: Any) -> None:
    """Who comes and goes is not told here."""


class ExtremesBus:
    """What a module sees of a `Client`, as far as modules use it."""

    name = "module"
    number = OWN
    connected = True
    closed_by = ""

    def __init__(self, clock: Callable[[], float], random: Random) -> None:
        self.faults = SimpleNamespace(counts=Counter())
        self.directory = SimpleNamespace(watch=_unheard, follow=_unheard)
        self.handlers: defaultdict[str, list[Callable[[Any], None]]] = defaultdict(list)
        self.timers: list[Callable[[], None]] = []
        self.published: Counter[str] = Counter()
        self.clock = clock
        self._random = random
        self._sequence = itertools.count(1)
        self._answers: dict[str, Any] = {}

    def define(self, *_: Any) -> None: ...

    def subscribe(self, definition: Any, handler: Callable[..., None], **_: Any) -> None:
        def take(value: Any) -> None:
            age = self._random.choice((0.0, 0.01, 5.0))
            publisher = self._random.choice((OWN, 2, 3, 2**32 - 1))
            how = MessageInfo(publisher, next(self._sequence), 0, age, self.clock() - age)
            handler(value, how)

        self.handlers[definition.name].append(take)

    def unsubscribe(self, *_: Any) -> None: ...

    def respond(self, request: Any, response: Any, handler: Callable[[Any], Any]) -> None:
        def take(value: Any) -> None:
            with contextlib.suppress(HubError):  # who asked is told why
                self.check(response, handler(value))

        self.handlers[request.name].append(take)

    def respond_later(self, request: Any, response: Any, handler: Callable[..., None]) -> None:
        def take(value: Any) -> None:
            reply = SimpleNamespace(
                asker=self._random.choice((2, 3)),
                answer=lambda answer, **_: self.check(response, answer),
                fail=lambda _: None,
            )
            with contextlib.suppress(HubError):
                handler(value, reply)

        self.handlers[request.name].append(take)

    def every(self, _: float, work: Callable[[], None]) -> None:
        self.timers.append(work)

    def when_slept(self, work: Callable[[float], None]) -> None:
        """This machine never sleeps."""

    def alarm(self, work: Callable[[], None]) -> SimpleNamespace:
        self.timers.append(work)
        return SimpleNamespace(due=math.inf)

    def post(self, work: Callable[[], None]) -> None:
        work()

    def has_subscribers(self, _: Any) -> bool:
        return True

    def publish(self, definition: Any, value: Any, **_: Any) -> None:
        self.check(definition, value)
        self.published[definition.name] += 1

    def query_notify(self, request: Any, value: Any, response: Any, **ways: Any) -> None:
        self.check(request, value)
        known = self._answers.setdefault(response.name, extremes.taken(response, self._random))
        if self._random.random() < 0.2:
            ways["failed"](QueryTimeoutError("nobody"))
            return
        now = self.clock()
        ways["answered"](next(known), MessageInfo(2, next(self._sequence), 0, 0.0, now))

    def check(self, definition: MessageDefinition[Any], value: Any) -> None:
        """Whether what the module says is within its ranges."""
        notes: list[str] = []
        try:
            definition.decode(b"".join(definition.encode(value)), notes.append)
        except HubError as error:
            notes.append(str(error))
        assert not notes, value

    def feed(self, name: str, count: int) -> int:
        """Hand so many extreme messages to the handlers; how many got through the bounds."""
        definition, through = BY_NAME[name], 0
        for number, payload in enumerate(extremes.payloads(definition, self._random)):
            if number == count:
                return through
            try:
                value = definition.decode(payload)
            except CodecError:
                continue
            through += 1
            for handler in self.handlers[name]:
                handler(value)
            if number % 5 == 0:
                self.tick()
        return through

    def tick(self) -> None:
        """Have all timers come due."""
        for work in self.timers:
            work()
