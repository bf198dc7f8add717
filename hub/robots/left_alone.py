"""What a robot does that has lost its operator; pure."""

from __future__ import annotations

import enum
import math

SURFACE_AFTER_S = 10.0
"""A robot that surfaces keeps still for so long before [s]."""


class LeftAlone(enum.Enum):
    """What to do where nobody has control any more, as robot files name it.

    Attributes:
        STAND: Wheels stand; whatever floats keeps neutral.
        HOLD_HEIGHT: What flies stays as high as it is.
        SURFACE: What dives keeps neutral for a while, and then comes up.
    """

    STAND = "stand"
    HOLD_HEIGHT = "hold height"
    SURFACE = "surface"


class OperatorWatch:
    """Knows since when a robot has had no operator; every method gets the monotonic time [s].

    A robot that nobody has operated yet has lost nobody. While a task of its own goes on, a robot
    without an operator does not count as left alone: that begins when the task has ended.
    """

    def __init__(self, wanted: LeftAlone, surface_after_s: float = SURFACE_AFTER_S) -> None:
        self._wanted = wanted
        self._surface_after_s = surface_after_s
        self._owner = 0
        self._since = math.inf

    def controlled_by(self, owner: int, now: float) -> None:
        """Who has control, by number; 0: nobody."""
        if owner:
            self._since = math.inf
        elif self._owner:
            self._since = now
        self._owner = owner

    def moved(self, now: float) -> None:
        """Somebody moves it all the same."""
        if self._since < math.inf:
            self._since = now

    def action(self, now: float) -> LeftAlone | None:
        """What to do now; None: it is not left alone."""
        if self._since == math.inf:
            return None
        if self._wanted is LeftAlone.SURFACE and now - self._since < self._surface_after_s:
            return LeftAlone.STAND
        return self._wanted
