"""Dead reckoning from wheel encoders, which drifts because wheels slip."""

from __future__ import annotations

import math

import numpy as np

from hub.pose import Pose, wrapped
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class OdometryNoise:
    """Parameters of the odometry motion model (Thrun, Burgard, Fox 2005, table 5.6).

    The values are those of CARMEN for indoor robots; slip is between 1 and 2 %.

    Attributes:
        turn_from_turn: a1, error of a turn for each radian turned [rad/rad].
        turn_from_distance: a2, error of a turn for each metre driven [rad/m].
        distance_from_distance: a3, error of the distance for each metre driven [m/m].
        distance_from_turn: a4, error of the distance for each radian turned [m/rad].
        slip: Least and greatest size of the constant error, as a share.
    """

    turn_from_turn: float = 0.2
    turn_from_distance: float = 0.01
    distance_from_distance: float = 0.2
    distance_from_turn: float = 0.01
    slip: tuple[float, float] = (0.01, 0.02)


CHUNK = 0.1
"""Errors stay the same for this time of motion [s], then new ones are drawn.

A shorter time would average them out: after n chunks a relative error has shrunk by sqrt(n).
"""


class WheelOdometry:
    """The pose by the encoders, in `odom`: the start pose is its origin.

    Attributes:
        pose: The dead-reckoned pose.
    """

    def __init__(self, seed: np.random.SeedSequence, noise: OdometryNoise | None = None) -> None:
        self._noise = noise or OdometryNoise()
        self._random = np.random.default_rng(seed)
        low, high = self._noise.slip
        sizes = self._random.uniform(low, high, 2)
        signs = self._random.choice((-1.0, 1.0), 2)
        self._way_slip, self._turn_slip = (1.0 + sizes * signs).tolist()
        self._errors = (0.0, 0.0, 0.0)
        self._chunk_left = 0.0
        self.pose = Pose(x=0.0, y=0.0, theta=0.0)

    def moved(self, ahead: float, turn: float, seconds: float, sideways: float = 0.0) -> None:
        """Add a motion of the wheels in some time [s]: ahead and to the left [m], turn [rad]."""
        if ahead == 0.0 and turn == 0.0 and sideways == 0.0:
            return
        distance = math.copysign(math.hypot(ahead, sideways), ahead) if sideways else ahead
        direction = math.atan2(sideways, ahead) if ahead >= 0.0 else math.atan2(-sideways, -ahead)
        if self._chunk_left <= 0.0:
            first, way, second = self._random.standard_normal(3).tolist()
            self._errors = (first, way, second)
            self._chunk_left += CHUNK
        self._chunk_left -= seconds
        first, way, second = self._errors
        noise = self._noise
        half = abs(turn) / 2.0
        turn_spread = noise.turn_from_turn * half + noise.turn_from_distance * abs(distance)
        way_spread = noise.distance_from_distance * abs(distance) + noise.distance_from_turn * abs(
            turn
        )
        first_turn = turn / 2.0 * self._turn_slip + turn_spread * first
        second_turn = turn / 2.0 * self._turn_slip + turn_spread * second
        driven = distance * self._way_slip + way_spread * way
        heading = self.pose.theta + first_turn
        self.pose = Pose(
            x=self.pose.x + driven * math.cos(heading + direction),
            y=self.pose.y + driven * math.sin(heading + direction),
            theta=wrapped(heading + second_turn),
        )
