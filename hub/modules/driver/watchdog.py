"""The last stop: the driver halts by itself when navigation falls silent; pure."""

from __future__ import annotations

SILENCE_S = 0.3
"""Time without a fresh drive command after which the wheels are told to stop [s]."""


class CommandWatchdog:
    """Knows whether a drive command may be followed.

    After a silence, and at the start, the wheels stand until a neutral command has come.
    """

    def __init__(self, silence_s: float = SILENCE_S) -> None:
        self._silence_s = silence_s
        self._deadline = float("-inf")

    def allows(self, measured: float, now: float, *, neutral: bool) -> bool:
        """Whether a command that was given at `measured` may be followed at `now` [s]."""
        late = measured + self._silence_s <= now
        if late or (self.expired(now) and not neutral):
            return False
        self._deadline = measured + self._silence_s
        return True

    def expired(self, now: float) -> bool:
        """Whether there has been no fresh command for too long at `now` [s]."""
        return now >= self._deadline
