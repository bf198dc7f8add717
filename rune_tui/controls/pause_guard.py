"""Keys that were typed while the console could not see them; pure.

A console that was stopped, or whose machine slept, finds old key presses waiting when it goes on.
Nobody knows when they were typed, so they must not drive.
"""

from __future__ import annotations

STALL_S = 0.3
"""A pause between two ticks that is longer than this was no ordinary one [s]."""
DEAF_S = 0.2
"""How long after such a pause keys are taken for old ones [s]."""


class StallGuard:
    """Notices pauses of the console itself."""

    def __init__(self, *, stall_s: float = STALL_S, deaf_s: float = DEAF_S) -> None:
        self._stall_s = stall_s
        self._deaf_s = deaf_s
        self._seen: float | None = None
        self._deaf_until = float("-inf")

    def stalled(self, now: float) -> bool:
        """To be called at every tick and every key: whether the console has just been away."""
        away = self._seen is not None and now - self._seen > self._stall_s
        self._seen = now
        if away:
            self._deaf_until = now + self._deaf_s
        return away

    def deaf(self, now: float) -> bool:
        """Whether a key that comes at `now` may have been typed while the console was away."""
        return now < self._deaf_until
