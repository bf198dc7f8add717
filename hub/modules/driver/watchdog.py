"""The last stop: the driver halts by itself when navigation falls silent; pure."""

from __future__ import annotations

SILENCE_S = 0.3
"""Time without a fresh drive command after which the wheels are told to stop [s]."""


class CommandWatchdog:
    """Knows whether drive commands still come; expired until the first one."""

    def __init__(self, silence_s: float = SILENCE_S) -> None:
        self._silence_s = silence_s
        self._deadline = float("-inf")

    def fed(self, now: float) -> None:
        """A fresh command was given at `now` [s]."""
        self._deadline = now + self._silence_s

    def expired(self, now: float) -> bool:
        """Whether there has been no fresh command for too long at `now` [s]."""
        return now >= self._deadline
