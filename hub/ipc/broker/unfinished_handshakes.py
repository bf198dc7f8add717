"""Counts the handshakes that end early, from ZeroMQ's events of one socket; pure.

ZeroMQ reports no failure where a peer uses another protocol, such as HTTP: it only reports that
the connection ended. Its reports of successes and failures do not name the connection.

| event | action |
| --- | --- |
| accepted | one more handshake is under way |
| succeeded, failed | one less |
| a young connection ends while handshakes are under way | one less, which ended early |
| any other end | none |
"""

from __future__ import annotations

from collections.abc import Callable

LONGEST_S = 4.0
"""Longest handshake, with a margin: sockets end one after 3 s [s]."""


class UnfinishedHandshakes:
    """The handshakes under way at one socket."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._accepted: dict[int, float] = {}
        self._under_way = 0

    def accepted(self, descriptor: int) -> None:
        """A connection begins."""
        self._accepted[descriptor] = self._clock()
        self._under_way += 1

    def decided(self) -> None:
        """A handshake succeeded or failed."""
        self._under_way = max(0, self._under_way - 1)

    def ended_early(self, descriptor: int) -> bool:
        """A connection ends; whether its handshake was not over."""
        began = self._accepted.pop(descriptor, -LONGEST_S)
        early = self._under_way > 0 and self._clock() - began < LONGEST_S
        self._under_way -= early
        return early
