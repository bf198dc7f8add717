"""The switch of assistance, which slows the operator before obstacles; pure.

| state | event | next state |
| --- | --- | --- |
| ON | switched off | OFF |
| OFF | switched on, or no command to move for 10 s | ON |
"""

from __future__ import annotations

from hub.gcm.navigation import Assistance

LAPSE_S = 10.0
"""Assistance is on again after this time without a command to move [s]."""


class AssistanceSwitch:
    """Keeps the state; every method gets the present monotonic time [s]."""

    def __init__(self) -> None:
        self._off_until = float("-inf")

    def switch(self, assistance: Assistance, now: float) -> None:
        """Switch assistance."""
        self._off_until = now + LAPSE_S if assistance is Assistance.OFF else float("-inf")

    def moved(self, now: float) -> None:
        """An operator drives: if assistance is off, it stays off."""
        if self.state(now) is Assistance.OFF:
            self._off_until = now + LAPSE_S

    def state(self, now: float) -> Assistance:
        """Whether assistance is on now."""
        return Assistance.OFF if now < self._off_until else Assistance.ON
