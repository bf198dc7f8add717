"""Whether the operator is held back before obstacles, and how long that may be off; pure."""

from __future__ import annotations

from hub.gcm.navigation import Assistance

LAPSE_S = 10.0
"""Without a command to move for this long [s] assistance comes back by itself."""


class AssistanceSwitch:
    """Remembers what was switched; every method gets the present monotonic time [s]."""

    def __init__(self) -> None:
        self._off_until = float("-inf")

    def switch(self, assistance: Assistance, now: float) -> None:
        """Somebody switches."""
        self._off_until = now + LAPSE_S if assistance is Assistance.OFF else float("-inf")

    def moved(self, now: float) -> None:
        """Somebody drives: while assistance is off, that keeps it off."""
        if self.state(now) is Assistance.OFF:
            self._off_until = now + LAPSE_S

    def state(self, now: float) -> Assistance:
        """Whether the operator is held back now."""
        return Assistance.OFF if now < self._off_until else Assistance.ON
