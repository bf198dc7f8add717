"""The cable between an underwater robot and its operator."""

from __future__ import annotations

import math

from hub.pose import wrapped
from hub.sim.afloat.attitude import Vector
from hub.sim.afloat.fluid import SEA_WATER_DENSITY
from hub.values import dataclass

DIAMETER = 0.0075
"""[m], von Benzon et al. 2022."""
DRAG_COEFFICIENT = 1.2
"""Of a cylinder across the flow, von Benzon et al. 2022."""
MOVING_SHARE = 1.0 / 3.0
"""Share of the paid-out length that the robot drags across the water; our choice."""
STIFFNESS = 400.0
"""Of the cable when it is all out [N/m]; our choice."""
DAMPING = 60.0
"""Of the cable while it stretches [N s/m]; our choice."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TetherSpec:
    """A cable.

    Attributes:
        length: All of it [m].
        anchor: Where it begins, in the world [m].
    """

    length: float
    anchor: Vector


class Tether:
    """The cable while the robot moves.

    Attributes:
        paid_out: Length between anchor and robot [m].
        turns: Turns of the robot that twist it, counter-clockwise positive.
    """

    def __init__(self, spec: TetherSpec, position: Vector, yaw: float) -> None:
        self._spec = spec
        self._yaw = yaw
        self.turns = 0.0
        self.paid_out = min(spec.length, math.dist(position, spec.anchor))

    @property
    def length(self) -> float:
        """All of it [m]."""
        return self._spec.length

    @property
    def used(self) -> float:
        """Share of the cable that is out, 0 to 1."""
        return self.paid_out / self._spec.length

    def follow(self, yaw: float) -> None:
        """Count a turn to a new heading [rad]."""
        self.turns += wrapped(yaw - self._yaw) / math.tau
        self._yaw = yaw

    def pull(self, position: Vector, velocity: Vector, flow: Vector) -> Vector:
        """Force on the robot in the world [N]: drag, and a stop when all of it is out.

        Args:
            position: Of the robot [m].
            velocity: Of the robot in the world [m/s].
            flow: Velocity of the water [m/s].
        """
        x, y, z = (at - start for at, start in zip(position, self._spec.anchor, strict=True))
        vx, vy, vz = velocity
        rx, ry, rz = vx - flow[0], vy - flow[1], vz - flow[2]
        away = math.sqrt(x * x + y * y + z * z)
        self.paid_out = min(away, self._spec.length)
        drag = drag_factor(self.paid_out) * math.sqrt(rx * rx + ry * ry + rz * rz)
        beyond = away - self._spec.length
        if beyond <= 0.0:
            return -drag * rx, -drag * ry, -drag * rz
        stretching = max(0.0, (vx * x + vy * y + vz * z) / away)
        tension = (STIFFNESS * beyond + DAMPING * stretching) / away
        return -drag * rx - tension * x, -drag * ry - tension * y, -drag * rz - tension * z


def drag_factor(paid_out: float) -> float:
    """Drag per squared speed of a paid-out length [N s^2/m^2]."""
    area = DIAMETER * paid_out * MOVING_SHARE
    return 0.5 * SEA_WATER_DENSITY * DRAG_COEFFICIENT * area
