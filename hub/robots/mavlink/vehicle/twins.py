"""Whether a vehicle started again, or two of them answer with one number; pure.

Two vehicles with one number are not driven. The time since the start is that of ATTITUDE, and that
of TIMESYNC; each is compared with itself.

| time since the start, from a message to the next | meaning |
| --- | --- |
| goes back by more than 1 s | a start |
| stays behind the clock by 2 s and 2 % after a silence of 1.5 s | a start meanwhile |
| runs ahead of the clock by 10 s | another vehicle |

| sign of two vehicles | message |
| --- | --- |
| the time since its start goes back three times within 5 s | ATTITUDE, TIMESYNC |
| another board answers | AUTOPILOT_VERSION |
| another kind of vehicle | HEARTBEAT |

A sign counts for 10 s.
"""

from __future__ import annotations

import enum
import math
from collections import deque
from typing import Final

_COUNTS_S: Final = 10.0
_BACK_MS: Final = 1000
"""A start shows as a time so far back; frames may come in another order [ms]."""
_AHEAD_MS: Final = 10_000
"""A time that runs ahead of the clock by this is of another vehicle [ms]."""
_BEHIND_MS: Final = 2000
_DRIFT: Final = 0.02
"""Share of a silence by which clocks may differ after it."""
_SILENCE_S: Final = 1.5
_TIMES: Final = 3
_WITHIN_S: Final = 5.0


class Start(enum.Enum):
    """What the time since a vehicle's start says.

    Attributes:
        SAME: It has not started again.
        BOOTED: It has.
        ANOTHER: Another vehicle sends with its number.
    """

    SAME = enum.auto()
    BOOTED = enum.auto()
    ANOTHER = enum.auto()


class TwinWatch:
    """The signs of a second vehicle with the number of one; times are monotonic [s]."""

    def __init__(self) -> None:
        self._seen_at = -math.inf
        self._backs: deque[float] = deque(maxlen=_TIMES)
        self._board: object = None
        self._clocks: dict[str, tuple[int, float]] = {}

    def sign(self, now: float) -> None:
        """Take a sign of a second vehicle."""
        self._seen_at = now

    def seen(self, now: float) -> bool:
        """Whether there are two."""
        return now - self._seen_at < _COUNTS_S

    def start(self, clock: str, boot_ms: int, now: float) -> Start:
        """Take the time since the start.

        Args:
            clock: Name of the message that has it.
            boot_ms: Time since the start [ms].
            now: When it came.
        """
        before_ms, before = self._clocks.get(clock, (0, now))
        self._clocks[clock] = boot_ms, now
        behind_ms = 1e3 * (now - before) - (boot_ms - before_ms)
        if boot_ms + _BACK_MS < before_ms:
            self._backs.append(now)
            if len(self._backs) == _TIMES and now - self._backs[0] < _WITHIN_S:
                self.sign(now)
            return Start.BOOTED
        if before_ms <= 0:
            return Start.SAME
        silence = now - before
        if silence > _SILENCE_S and behind_ms > _BEHIND_MS + 1e3 * _DRIFT * silence:
            return Start.BOOTED
        return Start.ANOTHER if -behind_ms > _AHEAD_MS else Start.SAME

    def forget(self) -> None:
        """It started again: earlier times since a start do not count."""
        self._clocks.clear()

    def board(self, number: object, now: float) -> None:
        """Take the number of the board that answers; one that is false is not known."""
        if number and self._board not in (None, number):
            self.sign(now)
        self._board = number or self._board

    def gone(self) -> None:
        """The vehicle is gone: the next one may be another."""
        self._board = None
