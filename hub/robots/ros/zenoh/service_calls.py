"""Calls of services, as queries; an answer, or the reason why there is none, always comes."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable

from hub.robots.ros.line import TakeAnswer
from hub.ros.rmw_zenoh import GID_BYTES, Endpoint, MessageOrigin
from hub.zenoh.session import ZenohSession


class ServiceCalls:
    """The open calls of a line."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake = wake
        self._open: dict[int, tuple[TakeAnswer, str, float]] = {}
        self._came: deque[tuple[int, bytes | None]] = deque()
        self._gid = os.urandom(GID_BYTES)
        self._last = 0

    def refuse(self, answered: TakeAnswer, why: str) -> None:
        """Answer a call that cannot be made."""
        self._last += 1
        self._open[self._last] = (answered, why, -float("inf"))
        self._wake()

    def call(
        self, session: ZenohSession, domain: int, end: Endpoint, payload: bytes,
        answered: TakeAnswer, timeout: float, now: float,
    ) -> None:  # fmt: skip
        """Call a service."""
        self._last += 1
        number = self._last
        why = f"{end.name} did not answer within {timeout:g} s"
        self._open[number] = (answered, why, now + timeout)
        origin = MessageOrigin(sequence=number, stamp_ns=time.time_ns(), gid=self._gid)

        def came(answer: bytes | None) -> None:
            self._came.append((number, answer))
            self._wake()

        session.ask(end.key(domain), payload, origin.pack(), timeout, came)

    def advance(self, now: float) -> None:
        """Hand over answers, and end what took too long."""
        while self._came:
            number, answer = self._came.popleft()
            call = self._open.pop(number, None)
            if call is not None:
                answered, why, _ = call
                answered(answer, "" if answer is not None else why)
        for number in [each for each, call in self._open.items() if call[2] <= now]:
            answered, why, _ = self._open.pop(number)
            answered(None, why)
