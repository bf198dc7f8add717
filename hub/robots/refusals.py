"""Since when a machine refuses connections, as its system does where no program listens; pure.

| event | action |
| --- | --- |
| a refused attempt | count it |
| as many of them in a row as the machine has addresses | it refuses, since the first of them |
| an attempt with another outcome | the next refusal is the first one |
"""

from __future__ import annotations

import math
from typing import Final

REFUSED_S: Final = 1.5
"""Time after which a question to a machine that refuses ends [s]; its program may just start."""


class Refusals:
    """The attempts to connect to one machine."""

    def __init__(self) -> None:
        self._row = 0
        self._first = math.inf
        self._addresses = 1

    @property
    def since(self) -> float:
        """Since when it refuses [s, monotonic]; infinite: it does not."""
        return self._first if self._row >= self._addresses else math.inf

    def attempt(self, now: float, *, refused: bool, addresses: int = 1) -> None:
        """Note an attempt.

        Args:
            now: When it ended [s, monotonic].
            refused: Whether the system there refused it.
            addresses: Addresses of the machine; each attempt is at another one.
        """
        if not refused:
            self._row, self._first = 0, math.inf
            return
        self._first = min(self._first, now)
        self._row += 1
        self._addresses = addresses
