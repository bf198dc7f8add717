"""Moves a simulated vehicle as a body of the simulator, in an arena.

| MAVLink | arena |
| --- | --- |
| north, east from the start | y, x from the start |
| down | minus the height; of a Sub, the depth below the surface |
| yaw, clockwise from north | theta = pi/2 - yaw |
"""

from __future__ import annotations

import math
from typing import Final

from hub.gcm.geometry import Twist, Vector3
from hub.robots.interfaces import Body, BodyArms
from hub.robots.simulated_autopilot.motion import Demand, DemandKind, SimulatedState

_FULL_THRUST: Final = 1.04
"""Speed of a Sub with its full thrust, against quadratic drag [m/s]."""
_SHARES: Final = frozenset({DemandKind.THRUST, DemandKind.OPEN, DemandKind.RISE})


class ArenaMotion:
    """Follows demands with a simulated body."""

    def __init__(self, body: Body, surface: float = 0.0) -> None:
        """Take a body at its start.

        Args:
            body: A simulated body, which knows its true pose.
            surface: Height from which `down` counts, in the arena's frame [m].
        """
        self.state = SimulatedState()
        self._body, self._surface = body, surface
        self._armed = True
        truth = body.ground_truth()
        self._start = (truth.x, truth.y) if truth is not None else (0.0, 0.0)
        self._read()

    def step(self, demand: Demand, seconds: float) -> None:
        """Move for a time [s]."""
        armed = demand.kind is not DemandKind.OFF
        if armed is not self._armed and isinstance(self._body, BodyArms):
            self._body.arm(armed=armed)
        self._armed = armed
        if armed:
            ahead, right = demand.ahead, demand.right
            if demand.kind in _SHARES:
                ahead, right = _speed(ahead), _speed(right)
            self._body.command(
                Twist(
                    linear=Vector3(x=ahead, y=-right, z=-demand.down),
                    angular=Vector3(z=-demand.turn),
                )
            )
        else:
            self._body.command(Twist())
        self._body.advance(seconds)
        self._read()

    def _read(self) -> None:
        truth, state = self._body.ground_truth(), self.state
        if truth is None:
            return
        state.east, state.north = truth.x - self._start[0], truth.y - self._start[1]
        state.down = self._surface - truth.z
        state.roll, state.pitch = truth.roll, -truth.pitch
        state.yaw = math.remainder(math.pi / 2.0 - truth.theta, math.tau)
        state.ahead, state.right = truth.linear, -truth.sway
        state.sinking, state.turn = -truth.heave, -truth.angular


def _speed(share: float) -> float:
    """The speed of a share of the thrust [m/s]."""
    return math.copysign(_FULL_THRUST * math.sqrt(abs(share)), share)
