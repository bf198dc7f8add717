"""The last stop: the driver halts the wheels when navigation falls silent; pure.

| state | event | action | next state |
| --- | --- | --- | --- |
| EXPIRED | fresh neutral command | follow | ALIVE |
| EXPIRED | other command | refuse | EXPIRED |
| ALIVE | fresh command | follow | ALIVE |
| ALIVE | late command: older than 0.3 s | refuse | ALIVE |
| ALIVE | no fresh command for 0.3 s | wheels stop | EXPIRED |
| any | `expire()` | none | EXPIRED |

It starts EXPIRED.
"""

from __future__ import annotations

SILENCE_S = 0.3
"""Time without a fresh drive command after which the wheels stop [s]."""


class CommandWatchdog:
    """Decides whether the driver follows a drive command.

    Attributes:
        deadline: The wheels must stand from this time on [s].
    """

    deadline: float

    def __init__(self, silence_s: float = SILENCE_S) -> None:
        self._silence_s = silence_s
        self.expire()

    def allows(self, measured: float, now: float, *, neutral: bool) -> bool:
        """Whether the driver follows a command that was given at `measured`, at `now` [s]."""
        late = measured + self._silence_s <= now
        if late or (self.expired(now) and not neutral):
            return False
        self.deadline = measured + self._silence_s
        return True

    def expire(self) -> None:
        """Forget the commands so far: the next one must be neutral."""
        self.deadline = float("-inf")

    def expired(self, now: float) -> bool:
        """Whether no command is fresh at `now` [s], so that the wheels must stand."""
        return now >= self.deadline
