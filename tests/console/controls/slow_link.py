"""A way that takes its time, is cut or loses all; on a clock that is passed in."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any


@dataclass
class Link:
    """From one to another.

    Attributes:
        delay: Each way [s].
        cut: Whether what is sent waits.
        gone: Whether what is sent is lost.
        number: The sender's at central.
    """

    delay: float
    number: int
    cut: bool = False
    gone: bool = False

    def __post_init__(self) -> None:
        self._way: list[tuple[float, float, Any]] = []

    def send(self, value: object, now: float) -> None:
        if not self.gone:
            self._way.append((now + self.delay, now, value))

    def arrived(self, now: float) -> Iterable[tuple[float, Any]]:
        """What has come by now, with when it was sent [s]."""
        if self.cut or not self._way or self._way[0][0] > now:
            return ()
        come = [(sent, value) for at, sent, value in self._way if at <= now]
        self._way = [each for each in self._way if each[0] > now]
        return come
