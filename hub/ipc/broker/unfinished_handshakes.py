"""Counts the handshakes that end early, from ZeroMQ's events of one socket; pure.

ZeroMQ reports no failure where a peer uses another protocol, such as HTTP: it only reports that
the connection ended. Its reports of successes and failures do not name the connection.

| event | action |
| --- | --- |
| accepted | one more handshake is under way, on a young connection |
| succeeded, failed | one less is under way |
| a connection ends, or is no longer young | it is none of the young |
| more are under way than there are young connections | the rest ended early |
"""

from __future__ import annotations

from collections.abc import Callable

LONGEST_S = 4.0
"""Longest handshake, with a margin: sockets end one after 3 s [s]."""


class UnfinishedHandshakes:
    """The handshakes under way at one socket."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._young: dict[int, float] = {}
        self._under_way = 0

    def accepted(self, descriptor: int) -> None:
        """A connection begins, and with it a handshake."""
        self._young[descriptor] = self._clock()
        self._under_way += 1

    def decided(self) -> None:
        """A handshake succeeded or failed."""
        self._under_way = max(0, self._under_way - 1)

    def ended(self, descriptor: int) -> int:
        """A connection ends; the number of handshakes that are known now to have ended early."""
        self._young.pop(descriptor, None)
        oldest = self._clock() - LONGEST_S
        self._young = {each: at for each, at in self._young.items() if at >= oldest}
        early = max(0, self._under_way - len(self._young))
        self._under_way -= early
        return early
