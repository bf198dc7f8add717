"""Which velocities are sent to a robot with ROS, and when; pure.

| state | event | sent | next state |
| --- | --- | --- | --- |
| WAITS | a velocity | nothing | WAITS |
| WAITS | a zero | with `hold` a zero, 20 times per second; else nothing | STANDS |
| STANDS | another velocity | it, at once | MOVES |
| MOVES | another velocity | it, at once | MOVES |
| MOVES | nothing new | the last velocity, 20 times per second | MOVES |
| MOVES | a zero | it, at once and 20 more in a second; with `hold` without end | STANDS |
| any | the line is away, or takes nothing for 0.3 s | nothing | WAITS; if it moved, a zero first |
| STANDS | the line takes nothing | one zero, behind what the line holds | STANDS |
| any | the robot's own navigation drives | nothing | LEFT |
| LEFT | it drives no more | a zero, as after MOVES | STANDS |

Zeros end because zero is not silence: while they come, no other node of the robot can drive.
"""

from __future__ import annotations

import math
from typing import Final

from hub.gcm.geometry import Twist

PERIOD_S: Final = 0.05
"""Time between two velocities [s]."""
ZEROS: Final = 20
"""Zeros after the first one."""
_STANDS: Final = Twist()


class CommandStream:
    """The velocities of one robot; every method gets the monotonic time [s].

    Attributes:
        wanted: The velocity that the robot has to follow.
    """

    def __init__(self, *, hold: bool) -> None:
        """Wait for a zero.

        Args:
            hold: Whether zeros never end.
        """
        self.wanted = _STANDS
        self._hold = hold
        self._ready = False
        self._zeros = 0.0
        self._due = math.inf
        self._left = False

    def command(self, velocity: Twist, now: float) -> None:
        """Follow a velocity from now on; after a start or a loss a zero must come first."""
        self.take_back(now)
        if not self._ready:
            if not velocity.neutral:
                return
            self._ready = True
            if self._hold:
                self._stand(now)
        if velocity == self.wanted:
            return
        self.wanted = velocity
        if velocity.neutral:
            self._stand(now)
        else:
            self._due = now

    def leave(self) -> None:
        """Send nothing: the robot's own navigation drives."""
        self._left, self.wanted = True, _STANDS
        self._due = math.inf

    def take_back(self, now: float) -> None:
        """The robot's own navigation drives no more: the robot stands."""
        if self._left:
            self._left = False
            self._stand(now)

    def interrupt(self, now: float) -> None:
        """The line is away: what waits is dropped, and a zero has to come first."""
        self._ready = False
        if not self.wanted.neutral:
            self.wanted = _STANDS
            self._stand(now)

    def take(self, now: float) -> Twist | None:
        """The velocity that is due now; None: none is."""
        return self.wanted if now >= self._due else None

    def sent(self, now: float) -> None:
        """The velocity that was due has left."""
        self._due = max(self._due + PERIOD_S, now)
        if self.wanted.neutral:
            self._zeros -= 1
            if self._zeros <= 0:
                self._due = math.inf

    def _stand(self, now: float) -> None:
        self._zeros = math.inf if self._hold else ZEROS + 1
        self._due = now
