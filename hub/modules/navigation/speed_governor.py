"""Which velocity the wheels get, given the commands that came and the time; pure.

The robot follows fresh commands only. When they stop coming while it moves, or somebody stops it,
it stands until a neutral command has come: nobody drives off with a stick that was left deflected.
"""

from __future__ import annotations

import math

from hub.gcm.navigation import MotionState

SILENCE_S = 0.3
"""Time without a fresh command after which the robot is stopped [s]."""
DRIVER_SILENCE_S = 1.0
"""Time without a report after which the driver counts as gone [s]."""

_NEUTRAL_FIRST = (MotionState.WAITING, MotionState.SILENCE, MotionState.STOPPED)


class SpeedGovernor:
    """Decides on the velocity; every method gets the present monotonic time [s].

    Attributes:
        refused: Commands that were not followed: not finite, or not from neutral.
    """

    def __init__(
        self,
        linear_limit: float,
        angular_limit: float,
        now: float,
        *,
        silence_s: float = SILENCE_S,
    ) -> None:
        self._linear_limit = linear_limit
        self._angular_limit = angular_limit
        self._silence_s = silence_s
        self._state = MotionState.WAITING
        self._velocity = (0.0, 0.0)
        self._fresh_until = now
        self._driver_until = now
        self.refused = 0

    def command(self, linear: float, angular: float, measured: float, now: float) -> None:
        """The operator wants a velocity [m/s, rad/s], given at `measured`."""
        if not (math.isfinite(linear) and math.isfinite(angular)):
            self.refused += 1
            return
        if measured + self._silence_s <= now:
            self.refused += 1
            return
        neutral = linear == 0.0 and angular == 0.0
        self._expire(now)
        if self._state in _NEUTRAL_FIRST and not neutral:
            self.refused += 1
            return
        self._state = MotionState.STANDING if neutral else MotionState.MOVING
        self._velocity = (
            max(-self._linear_limit, min(self._linear_limit, linear)),
            max(-self._angular_limit, min(self._angular_limit, angular)),
        )
        self._fresh_until = measured + self._silence_s

    def stop(self) -> None:
        """Somebody wants the robot to stop."""
        self._state = MotionState.STOPPED
        self._velocity = (0.0, 0.0)

    def driver_reported(self, now: float) -> None:
        """The driver lives."""
        self._driver_until = now + DRIVER_SILENCE_S

    def velocity(self, now: float) -> tuple[float, float]:
        """What the wheels get now [m/s, rad/s]."""
        self._expire(now)
        return self._velocity

    def state(self, now: float) -> MotionState:
        """What is done with commands now."""
        self._expire(now)
        return MotionState.NO_DRIVER if now >= self._driver_until else self._state

    def _expire(self, now: float) -> None:
        if now >= self._driver_until and self._state is MotionState.MOVING:
            # A driver that comes back must not find the robot told to move.
            self.stop()
        if now >= self._fresh_until and self._state is MotionState.MOVING:
            self._state = MotionState.SILENCE
            self._velocity = (0.0, 0.0)
