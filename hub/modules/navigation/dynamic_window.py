"""The best velocity that the robot can reach and that leads into no obstacle; pure.

The dynamic window approach (Fox, Burgard and Thrun 1997). The window holds the velocities that the
robot can reach soon. A velocity is admissible if the robot can stop on its arc before it meets an
obstacle. Two methods choose among these: one for an operator's command, one for a goal.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.modules.navigation.arcs import free_ways
from hub.robots.description import RobotDescription
from hub.values import dataclass

Floats = npt.NDArray[np.float64]

LINEAR_SAMPLES = 8
ANGULAR_SAMPLES = 31
WINDOW_S = 0.25
"""The window holds velocities that the robot reaches in this time [s], as Fox, Burgard and
Thrun."""

_CREEP = 0.02
"""Least velocity towards an obstacle ahead [m/s]."""
_SET_OFF = 0.06
"""Least velocity from standing [m/s]; below it, noise of sensors makes the robot jerk."""
_TURN_WEIGHT = 6.0
"""Weight of a change of the turn rate against one of the forward velocity, both of their limits."""
_FAR = 1.5
"""Free arcs longer than this [m] count as equal."""
_AHEAD_S = 0.6
"""Time for which a velocity is simulated to see where it leads [s]."""
_TURN_FIRST = 1.2
"""The robot turns on the spot to a goal at a larger bearing than this [rad]."""
_LEAST_TURN = 0.15
"""Least turn rate on the spot [rad/s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyLimits:
    """The limits of a robot's body.

    Attributes:
        radius: Of the circle in which all of it lies [m].
        margin: Distance that it keeps from obstacles ahead, at rest [m].
        margin_s: Additional distance for its speed [m per m/s].
        side_margin: Distance that it keeps from obstacles beside it [m].
        linear_limit: Largest forward velocity [m/s].
        angular_limit: Largest turn rate [rad/s].
        linear_braking: Guaranteed deceleration [m/s^2].
        angular_braking: Guaranteed angular deceleration [rad/s^2].
        reaction: Time until a choice takes effect, and until the next one does [s].
    """

    radius: float
    margin: float
    margin_s: float = 0.1
    side_margin: float = 0.015
    linear_limit: float
    angular_limit: float
    linear_braking: float
    angular_braking: float
    reaction: float = 0.12


def body_of(robot: RobotDescription) -> BodyLimits:
    """The limits of a robot's body, from its description."""
    return BodyLimits(
        radius=robot.radius,
        margin=robot.margin,
        linear_limit=robot.linear_limit,
        angular_limit=robot.angular_limit,
        linear_braking=robot.linear_acceleration,
        angular_braking=robot.angular_acceleration,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Weights:
    """Weights of the terms of the score; the sum need not be 1.

    Attributes:
        heading: Of the heading towards the goal.
        way: Of the length of the free arc.
        speed: Of the speed.
    """

    heading: float = 1.0
    way: float = 0.3
    speed: float = 0.4


class DynamicWindow:
    """Chooses velocities [m/s, rad/s] for one robot."""

    def __init__(self, body: BodyLimits, weights: Weights | None = None) -> None:
        self.body = body
        self._weights = weights or Weights()
        self._steps = np.linspace(0.0, 1.0, LINEAR_SAMPLES)
        self._spread = np.linspace(0.0, 1.0, ANGULAR_SAMPLES)
        count = LINEAR_SAMPLES * (ANGULAR_SAMPLES + 1)
        self._linear = np.empty((LINEAR_SAMPLES, ANGULAR_SAMPLES + 1))
        self._angular = np.empty_like(self._linear)
        self._cost = np.empty(count)

    def towards(
        self, now: tuple[float, float], wanted: tuple[float, float], points: tuple[Floats, Floats]
    ) -> tuple[float, float]:
        """The admissible velocity that is nearest to the commanded one.

        It is never faster than the command and never of the other sign. Turning on the spot is
        always admissible: a round body meets nothing by it.

        Args:
            now: The present velocity [m/s, rad/s].
            wanted: The velocity that the operator commands [m/s, rad/s].
            points: Obstacles in `base_link` [m], x and y of shape (n,) each.
        """
        body = self.body
        goal = _limited(wanted[0], body.linear_limit), _limited(wanted[1], body.angular_limit)
        if goal[0] == 0.0:
            return goal
        fastest = self._reachable(now[0], goal[0])
        if self.admissible(np.array([fastest]), np.array([goal[1]]), points)[0]:
            return fastest, goal[1]
        linear, angular = self._samples(fastest, now[1], goal[1])
        gone = np.abs((goal[0] - linear) / body.linear_limit)
        turned = (goal[1] - angular) / body.angular_limit
        cost = np.add(gone * gone, _TURN_WEIGHT * turned * turned, out=self._cost)
        cost[~self.admissible(linear, angular, points)] = np.inf
        best = int(cost.argmin())
        chosen = float(linear[best])
        least = _SET_OFF if abs(now[0]) < _CREEP else _CREEP
        if not math.isfinite(cost[best]) or abs(chosen) < min(least, abs(goal[0])):
            return 0.0, goal[1]
        return chosen, float(angular[best])

    def to_goal(
        self,
        now: tuple[float, float],
        carrot: tuple[float, float],
        fastest: float,
        points: tuple[Floats, Floats],
    ) -> tuple[float, float]:
        """The admissible velocity with the best score for a place.

        Args:
            now: The present velocity [m/s, rad/s].
            carrot: The point to head for, in `base_link` [m].
            fastest: Largest forward velocity [m/s].
            points: Obstacles in `base_link` [m], x and y of shape (n,) each.
        """
        bearing = math.atan2(carrot[1], carrot[0])
        if abs(bearing) > _TURN_FIRST or (now[0] < _CREEP and abs(bearing) > _TURN_FIRST / 2.0):
            return 0.0, self.turn(bearing)
        top = self._reachable(now[0], min(fastest, self.body.linear_limit))
        linear, angular = self._samples(top, now[1], 0.0)
        ways = self._ways(linear, angular, points)
        stopping = self._stopping(linear)
        score = self._score(linear, angular, np.minimum(ways - stopping, _FAR), carrot)
        score[stopping > ways] = -np.inf
        best = int(score.argmax())
        if linear[best] < _CREEP:
            return 0.0, self.turn(bearing)
        return float(linear[best]), float(angular[best])

    def turn(self, angle: float) -> float:
        """The turn rate that turns by an angle without overshoot [rad/s]."""
        body = self.body
        left = max(abs(angle) - body.reaction * body.angular_limit * 0.5, 0.05)
        rate = min(body.angular_limit, math.sqrt(body.angular_braking * left), 2.5 * abs(angle))
        return math.copysign(max(rate, _LEAST_TURN), angle) if angle else 0.0

    def _score(
        self, linear: Floats, angular: Floats, ways: Floats, carrot: tuple[float, float]
    ) -> Floats:
        """The score of each velocity, smoothed over the turn rates; shape (m,)."""
        turned = angular * _AHEAD_S
        half = 0.5 * turned
        chord = linear * _AHEAD_S * np.sinc(half / math.pi)
        to_x, to_y = carrot[0] - chord * np.cos(half), carrot[1] - chord * np.sin(half)
        off = np.abs(np.arctan2(to_y, to_x) - turned)
        off = np.minimum(off, 2.0 * math.pi - off)
        weights = self._weights
        score: Floats = (
            weights.heading * (1.0 - off / math.pi)
            + weights.way * ways / _FAR
            + weights.speed * linear / self.body.linear_limit
        )
        table = score.reshape(LINEAR_SAMPLES, -1)[:, :ANGULAR_SAMPLES]
        table[:, 1:-1] = (table[:, :-2] + table[:, 1:-1] + table[:, 2:]) / 3.0
        return score

    def admissible(
        self, linear: Floats, angular: Floats, points: tuple[Floats, Floats]
    ) -> npt.NDArray[np.bool_]:
        """Whether the robot can hold each velocity until the next choice, and stop after it.

        Args:
            linear: Forward velocities [m/s], shape (m,).
            angular: Turn rates [rad/s], shape (m,).
            points: Obstacles in `base_link` [m], x and y of shape (n,) each.
        """
        ways = self._ways(linear, angular, points)
        return self._stopping(linear) <= ways

    def _ways(self, linear: Floats, angular: Floats, points: tuple[Floats, Floats]) -> Floats:
        body = self.body
        x, y = points
        nearest = float(np.sqrt((x * x + y * y).min())) if len(x) else math.inf
        # A robot that is nearer to an obstacle than the margin must be able to pass it.
        side = max(body.radius, min(body.radius + body.side_margin, nearest - 0.003))
        speed = np.abs(linear)
        radius = body.radius + body.margin + body.margin_s * speed
        half_width = np.minimum(side + 0.5 * body.margin_s * speed, radius)
        return free_ways(linear, angular, x, y, radius, half_width)

    def _stopping(self, linear: Floats) -> Floats:
        """Stopping distance of each velocity, with the reaction time [m], shape (m,).

        On an arc both velocities fall to 0 in the same time, so the robot stays on it. Turn
        rates need no limit of their own, because a round body meets nothing by turning.
        """
        speed = np.abs(linear)
        return speed * self.body.reaction + speed * speed / (2.0 * self.body.linear_braking)

    def _reachable(self, now: float, goal: float) -> float:
        """The largest velocity towards the goal within the window [m/s]."""
        gain = self.body.linear_braking / 2.0 * WINDOW_S
        start = abs(now) if now * goal > 0.0 else 0.0
        return math.copysign(min(start + gain, abs(goal)), goal)

    def _samples(self, fastest: float, turning: float, wanted: float) -> tuple[Floats, Floats]:
        """Velocities from 0 to the fastest, each with all turn rates; both shape (m,)."""
        limit = self.body.angular_limit
        gain = self.body.angular_braking * WINDOW_S
        low, high = max(-limit, turning - gain), min(limit, turning + gain)
        self._linear[:] = (fastest * self._steps)[:, None]
        self._angular[:, :-1] = low + (high - low) * self._spread
        self._angular[:, -1] = max(low, min(high, wanted))
        return self._linear.reshape(-1), self._angular.reshape(-1)


def _limited(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
