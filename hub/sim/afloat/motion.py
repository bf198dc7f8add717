"""Velocities in space, and those that a body can be commanded to."""

from __future__ import annotations

from hub.sim.kinematics import limited
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyVelocity:
    """Velocities along and about the axes of a body, or their limits.

    Attributes:
        surge: Ahead [m/s].
        sway: To the left [m/s].
        heave: Up [m/s].
        roll: About x [rad/s].
        pitch: About y [rad/s].
        yaw: About z, counter-clockwise [rad/s].
    """

    surge: float = 0.0
    sway: float = 0.0
    heave: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0

    def within(self, limits: BodyVelocity) -> BodyVelocity:
        """The same within plus and minus the limits; NaN counts as 0."""
        return BodyVelocity(
            surge=limited(self.surge, limits.surge),
            sway=limited(self.sway, limits.sway),
            heave=limited(self.heave, limits.heave),
            roll=limited(self.roll, limits.roll),
            pitch=limited(self.pitch, limits.pitch),
            yaw=limited(self.yaw, limits.yaw),
        )


NEUTRAL = BodyVelocity()
