"""Whether two vehicles answer with one number: then neither may be driven; pure.

| sign | message |
| --- | --- |
| the time since its start goes back three times within 5 s | ATTITUDE |
| another board answers | AUTOPILOT_VERSION |
| another kind of vehicle | HEARTBEAT |

A sign counts for 10 s.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

_COUNTS_S: Final = 10.0
_BACK_MS: Final = 1000
"""A start shows as a time so far back; frames may come in another order [ms]."""
_AHEAD_MS: Final = 10_000
"""A time that runs ahead of the clock by this is of another vehicle [ms]."""
_TIMES: Final = 3
_WITHIN_S: Final = 5.0


class TwinWatch:
    """The signs of a second vehicle with the number of one; times are monotonic [s]."""

    def __init__(self) -> None:
        self._seen_at = -math.inf
        self._backs: deque[float] = deque(maxlen=_TIMES)
        self._board: object = None

    def sign(self, now: float) -> None:
        """Take a sign of a second vehicle."""
        self._seen_at = now

    def seen(self, now: float) -> bool:
        """Whether there are two."""
        return now - self._seen_at < _COUNTS_S

    def starts_again(self, boot_ms: int, before_ms: int, before: float, now: float) -> bool:
        """Take the time since the start; whether it is of another start, or another vehicle.

        Args:
            boot_ms: Time since the start [ms].
            before_ms: The time before it [ms]; 0: none came.
            before: When that came.
            now: When this came.
        """
        if boot_ms + _BACK_MS < before_ms:
            self._backs.append(now)
            if len(self._backs) == _TIMES and now - self._backs[0] < _WITHIN_S:
                self.sign(now)
            return True
        return before_ms > 0 and boot_ms - before_ms > 1e3 * (now - before) + _AHEAD_MS

    def board(self, number: object, now: float) -> None:
        """Take the number of the board that answers; one that is false is not known."""
        if number and self._board not in (None, number):
            self.sign(now)
        self._board = number or self._board

    def gone(self) -> None:
        """The vehicle is gone: the next one may be another."""
        self._board = None
