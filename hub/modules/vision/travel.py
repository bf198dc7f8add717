"""How far the robot and a camera's head have moved, so that pictures must have changed; pure."""

from __future__ import annotations

import math
from typing import Final

from hub.gcm.navigation import RobotState
from hub.gcm.vision import CameraState

_SLOWEST: Final = 0.02
"""Speeds below this are noise [m/s, rad/s]."""
_LONGEST_S: Final = 0.5
"""Longest time between two states for which a speed counts [s]."""


class Travel:
    """The way and the turns of a robot until now.

    Attributes:
        total: Their sum [m], with 1 rad as 1 m.
    """

    def __init__(self) -> None:
        self.total = 0.0
        self._at = -math.inf

    def moved(self, state: RobotState, measured: float) -> None:
        """Take a state, measured at a monotonic time [s]."""
        seconds, self._at = measured - self._at, max(measured, self._at)
        if not 0.0 < seconds <= _LONGEST_S:
            return
        way = math.hypot(state.linear, state.sway, state.heave)
        for speed in (way, abs(state.angular)):
            if speed >= _SLOWEST:
                self.total += speed * seconds


class HeadTravel:
    """The turns of a camera's head until now.

    Attributes:
        total: Their sum [rad], with its whole zoom as 1 rad.
    """

    def __init__(self) -> None:
        self.total = 0.0
        self._last: tuple[float, float, float] | None = None

    def moved(self, state: CameraState) -> None:
        """Add the turn since the last state; the first one adds nothing."""
        now = state.pan, state.tilt, state.zoom
        if self._last is not None:
            steps = (abs(one - other) for one, other in zip(now, self._last, strict=True))
            self.total += sum(step for step in steps if math.isfinite(step))
        self._last = now
