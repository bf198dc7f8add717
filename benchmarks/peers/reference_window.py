"""The dynamic window as PythonRobotics publishes it, written from its description.

PythonRobotics cannot be had from the package index. This window follows the same velocities: those
within one time step of the present one, in steps of 0.01 m/s and 0.1 degrees/s, for 3 s. It has the
same costs: heading (gain 0.15), speed (1) and nearest obstacle (1). It has the same accelerations,
and turns in the same way out of a place where it is stuck. Size and speed of the robot are those of
the worlds.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from benchmarks.barn import BODY, Velocity, World
from hub.pose import Pose

Floats = npt.NDArray[np.float64]

LINEAR_ACCELERATION = 0.2
ANGULAR_ACCELERATION = math.radians(40.0)
ANGULAR_LIMIT = math.radians(40.0)
STEP = 0.1
AHEAD = 3.0
LINEAR_RESOLUTION = 0.01
ANGULAR_RESOLUTION = math.radians(0.1)
GOAL_GAIN, SPEED_GAIN, OBSTACLE_GAIN = 0.15, 1.0, 1.0
STUCK = 0.001


class ReferenceWindow:
    """Chooses every 0.1 s."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._times = np.arange(1, round(AHEAD / STEP) + 1) * STEP
        self._held: Velocity = (0.0, 0.0)
        self._calls = 0

    def __call__(self, pose: Pose, velocity: Velocity, seen: Floats) -> Velocity:
        """The next velocity; the one before it at every other call."""
        del velocity  # only what it commanded counts, as in the original
        self._calls += 1
        if self._calls % 2 == 1:
            self._held = self._choose(pose, self._held, seen)
        return self._held

    def _choose(self, pose: Pose, velocity: Velocity, seen: Floats) -> Velocity:
        reach = LINEAR_ACCELERATION * STEP
        linear = np.arange(
            max(-BODY.linear_limit, velocity[0] - reach),
            min(BODY.linear_limit, velocity[0] + reach) + 1e-9,
            LINEAR_RESOLUTION,
        )
        reach = ANGULAR_ACCELERATION * STEP
        angular = np.arange(
            max(-ANGULAR_LIMIT, velocity[1] - reach),
            min(ANGULAR_LIMIT, velocity[1] + reach) + 1e-9,
            ANGULAR_RESOLUTION,
        )
        v, w = (part.reshape(-1, 1) for part in np.meshgrid(linear, angular))
        turned = pose.theta + w * self._times
        x = pose.x + np.cumsum(v * np.cos(turned) * STEP, axis=1)
        y = pose.y + np.cumsum(v * np.sin(turned) * STEP, axis=1)
        goal_x, goal_y = self._world.goal
        off = np.arctan2(goal_y - y[:, -1], goal_x - x[:, -1]) - turned[:, -1]
        cost = GOAL_GAIN * np.abs(np.arctan2(np.sin(off), np.cos(off)))
        cost += SPEED_GAIN * (BODY.linear_limit - v[:, 0])
        cost += OBSTACLE_GAIN * self._obstacle_cost(x, y, seen)
        best = int(cost.argmin())
        chosen = float(v[best, 0]), float(w[best, 0])
        if not math.isfinite(cost[best]):
            chosen = (0.0, 0.0)
        if abs(chosen[0]) < STUCK and abs(velocity[0]) < STUCK:
            return chosen[0], -ANGULAR_ACCELERATION
        return chosen

    def _obstacle_cost(self, x: Floats, y: Floats, seen: Floats) -> Floats | float:
        if not len(seen):
            return 0.0
        square = np.full(len(x), np.inf)
        for centre_x, centre_y in seen:
            away = (x - centre_x) ** 2 + (y - centre_y) ** 2
            np.minimum(square, away.min(axis=1), out=square)
        near = np.sqrt(square) - self._world.radius
        with np.errstate(divide="ignore"):
            return np.where(near <= BODY.radius, np.inf, 1.0 / near)
