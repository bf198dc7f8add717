"""Limits on the rate of marks and changes; pure: the time comes with each call."""

from __future__ import annotations

from hub.bucket import Bucket
from hub.errors import MissionError

CHANGES_PER_S = 3.0
"""Changes of one point by all senders [1/s]."""
CHANGES_AT_ONCE = 6.0
"""The same, in one burst."""
COMMANDS_PER_S = 3.0
"""New marks, changes and removals of one sender together [1/s]."""
COMMANDS_AT_ONCE = 20.0
"""The same, in one burst."""
TOGETHER_PER_S = 5.0
"""The same of all senders together [1/s]; a client that connects again is another sender."""
TOGETHER_AT_ONCE = 500.0
"""The same, in one burst."""
OWN_PER_S = 0.1
"""Rate that each sender always has, even if all together send too much [1/s]."""
OWN_AT_ONCE = 3.0
"""The same, in one burst."""
_MOST_KNOWN = 256
"""Points and senders that are remembered, each; the oldest is forgotten first."""


class MarkRates:
    """Counts the changes of each point and the commands of each sender."""

    def __init__(self) -> None:
        self._points: dict[int, Bucket] = {}
        self._senders: dict[int, Bucket] = {}
        self._own: dict[int, Bucket] = {}
        self._together = Bucket(TOGETHER_PER_S, TOGETHER_AT_ONCE)

    def check(self, number: int, sender: int, now: float) -> None:
        """Count a command.

        Args:
            number: Number of the changed point; 0: a new point or a removal.
            sender: Number of the client.
            now: Monotonic time [s].

        Raises:
            MissionError: The rate is too high; the text has the limit.
        """
        bucket = _bucket(self._senders, sender, COMMANDS_PER_S, COMMANDS_AT_ONCE)
        if not bucket.take(1.0, now):
            text = f"one client may mark {COMMANDS_PER_S:.0f} times a second; wait and try again"
            raise MissionError(text)
        own = _bucket(self._own, sender, OWN_PER_S, OWN_AT_ONCE)
        if not self._together.take(1.0, now) and not own.take(1.0, now):
            text = (
                f"all clients together may mark {TOGETHER_PER_S:.0f} times a second;"
                " wait and try again"
            )
            raise MissionError(text)
        if not number:
            return
        if not _bucket(self._points, number, CHANGES_PER_S, CHANGES_AT_ONCE).take(1.0, now):
            text = (
                f"point {number} may be changed {CHANGES_PER_S:.0f} times a second;"
                " wait and try again"
            )
            raise MissionError(text)


def _bucket(known: dict[int, Bucket], key: int, rate: float, most: float) -> Bucket:
    bucket = known.pop(key, None) or Bucket(rate, most)
    known[key] = bucket
    if len(known) > _MOST_KNOWN:
        del known[next(iter(known))]
    return bucket
