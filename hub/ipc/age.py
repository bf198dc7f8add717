"""How old a message is, without trusting that two clocks show the same time."""

from __future__ import annotations

_MAX_PUBLISHERS = 256
_FORGET_S_PER_S = 1e-4
"""How fast an old fastest way is forgotten, for clocks that drift apart [s/s]."""


class AgeEstimator:
    """Ages relative to the fastest way yet seen from each publisher.

    Clocks of two machines differ by an unknown offset; the smallest difference between receiving
    and sending is that offset plus the shortest way, and what comes later than that is older. A
    message that was queued somewhere shows its age; the time of the shortest way itself does not.
    """

    def __init__(self) -> None:
        self._fastest: dict[int, tuple[float, float]] = {}

    def age(self, publisher: int, stamp: float, now: float) -> float:
        """Time since `stamp` on the publisher's clock [s], as seen at `now` on ours [s]."""
        difference = now - stamp
        fastest, seen = self._fastest.get(publisher, (difference, now))
        fastest = min(difference, fastest + (now - seen) * _FORGET_S_PER_S)
        if publisher not in self._fastest and len(self._fastest) >= _MAX_PUBLISHERS:
            self._fastest.clear()
        self._fastest[publisher] = (fastest, now)
        return difference - fastest

    def forget(self) -> None:
        """Start again: the publishers' numbers mean others now."""
        self._fastest.clear()
