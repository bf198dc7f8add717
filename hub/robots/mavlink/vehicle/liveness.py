"""Whether a vehicle is there and answers: heartbeats, and echoes of TIMESYNC; pure.

A heartbeat says that the vehicle sends. Only an echo says that it receives.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

HEARTBEAT_LOST_S: Final = 2.5
"""Silence after which a vehicle is gone: two heartbeats and a half [s]."""
ECHO_EVERY_S: Final = 0.2
ECHO_LOST_S: Final = 1.0
"""Time without an echo after which the vehicle does not receive [s]."""
_FIRST_ECHO_S: Final = 3.0
"""Longest time until the first echo [s]."""
_AWAITED_S: Final = 0.1
_KEPT: Final = 20


class Liveness:
    """The heartbeats and echoes of one vehicle; times are monotonic [s].

    Attributes:
        heard: Time of the last heartbeat.
        answered: Time of the last echo.
        round_trip: Of the last echo [s]; NaN: none came.
    """

    def __init__(self) -> None:
        self.heard = self.answered = -math.inf
        self.round_trip = math.nan
        self._since = math.inf
        self._sent: deque[int] = deque(maxlen=_KEPT)
        self._next_echo = -math.inf

    def heartbeat(self, now: float) -> None:
        """Take a heartbeat."""
        self.heard = now
        self._since = min(self._since, now)

    def echo_due(self, now: float) -> int:
        """The stamp of an echo to send now [ns]; 0: none."""
        if now < self._next_echo:
            return 0
        self._next_echo = now + ECHO_EVERY_S
        self._sent.append(int(now * 1e9))
        return self._sent[-1]

    def echo(self, stamp: int, now: float) -> None:
        """Take an echo; a stamp that was not sent changes nothing."""
        if stamp in self._sent:
            self.answered = now
            self.round_trip = max(0.0, now - stamp / 1e9)

    def awaits(self, now: float) -> bool:
        """Whether an echo is on its way; a late one is no longer waited for."""
        return bool(self._sent) and self._sent[-1] / 1e9 > max(self.answered, now - _AWAITED_S)

    def gone(self, now: float) -> str:
        """Why the vehicle is gone; empty: it is there, and answers."""
        if now - self.heard > HEARTBEAT_LOST_S:
            return f"no heartbeat for {now - self.heard:.0f} s"
        if now - max(self.answered, self._since + _FIRST_ECHO_S - ECHO_LOST_S) > ECHO_LOST_S:
            return "it does not answer, so it may not receive commands"
        return ""
