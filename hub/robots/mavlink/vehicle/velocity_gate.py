"""Lets velocities through to a vehicle that is driven, from a neutral one on; pure.

| event | velocity | the next ones |
| --- | --- | --- |
| it is shut | 0 | are 0 until a neutral one comes |
| a neutral one while it is driven | 0 | are let through |
| another one while it is driven | it, within the limits | |
| one while it is not driven | 0 | |
"""

from __future__ import annotations

import math

from hub.robots.mavlink.profiles.profile import NEUTRAL, Setpoint


class VelocityGate:
    """The velocity of one vehicle.

    Attributes:
        velocity: What it is asked to follow.
        shut: Whether velocities wait for a neutral one.
    """

    def __init__(self, limits: Setpoint) -> None:
        """Take the largest velocities."""
        self._limits = limits
        self.velocity = NEUTRAL
        self.shut = True

    def close(self) -> None:
        """From now on velocities wait for a neutral one."""
        self.velocity, self.shut = NEUTRAL, True

    def take(self, wanted: Setpoint, *, driven: bool) -> bool:
        """Take a velocity; whether it is a new one.

        Args:
            wanted: The velocity; a part that is no number counts as 0, and is not neutral.
            driven: Whether the vehicle is driven now.
        """
        limited = Setpoint(
            ahead=_limited(wanted.ahead, self._limits.ahead),
            left=_limited(wanted.left, self._limits.left),
            up=_limited(wanted.up, self._limits.up),
            turn=_limited(wanted.turn, self._limits.turn),
        )
        if wanted.neutral and driven:
            self.shut = False
        if self.shut or not driven:
            limited = NEUTRAL
        before, self.velocity = self.velocity, limited
        return limited != before


def _limited(value: float, limit: float) -> float:
    """A velocity within its limit; one that is no number is 0."""
    return max(-limit, min(limit, value)) if math.isfinite(value) else 0.0
