"""The best velocity that the robot can reach and that leads into no obstacle; pure.

The dynamic window approach (Fox, Burgard and Thrun 1997). The window holds the velocities that the
robot can reach soon. A velocity is admissible if the robot can stop on its arc before it meets an
obstacle. Two methods choose among these: one for an operator's command, one for a goal.

A round body is a disc, which meets nothing by turning on the spot. Any other body is the convex
hull of its footprint. A body that also moves sideways is looked at in a frame whose x axis is the
direction of its command. A goal is approached ahead. A long body that has no room to turn to it
backs towards it, until there is room.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.outline import corners, hull
from hub.modules.navigation.arcs import free_ways
from hub.modules.navigation.sweeps import Sweep
from hub.pose import Number, Pose
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
_BACKING = 0.2
"""Largest velocity back towards a goal [m/s]: many bodies see less behind than ahead."""
_LONG_S = 100.0
"""A free time of this length is as good as any longer one [s]."""
_SPINS = np.linspace(0.125, 1.0, 8)
"""Shares of a turn rate that are tried on the spot."""
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
        sway_limit: Largest velocity sideways [m/s].
        outline: What of it moves along arcs; None: the circle.
        step: Highest step that it drives over, up or down [m].
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
    sway_limit: float = 0.0
    outline: Sweep | None = None
    step: float = 0.05

    @property
    def fastest(self) -> float:
        """Largest linear velocity in any direction [m/s]."""
        return math.hypot(self.linear_limit, self.sway_limit)

    def share(self, linear: Number, angular: Number) -> tuple[Number, Number]:
        """Velocities as shares of the largest ones; 0 of one that the body cannot have."""
        return linear * _inverse(self.fastest), angular * _inverse(self.angular_limit)

    @property
    def inner_radius(self) -> float:
        """Of the largest circle around the origin within the outline [m]."""
        if self.outline is None:
            return self.radius
        return -float(self.outline.distances(np.zeros(1), np.zeros(1))[0])

    def stopping(self, speed: Number) -> Number:
        """Distance in which it stops from a velocity [m/s], with the reaction time [m]."""
        return speed * self.reaction + speed * speed / (2.0 * self.linear_braking)


def _inverse(limit: float) -> float:
    return 1.0 / limit if limit > 0.0 else 0.0


def body_of(robot: RobotDescription) -> BodyLimits:
    """The limits of a robot's body, from its description."""
    return BodyLimits(
        radius=robot.radius,
        margin=robot.margin,
        linear_limit=robot.linear_limit,
        angular_limit=robot.angular_limit,
        linear_braking=robot.linear_acceleration,
        angular_braking=robot.angular_acceleration,
        sway_limit=robot.sway_limit,
        outline=Sweep(hull(corners(robot.body))) if robot.footprint else None,
        step=robot.step,
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
        self,
        now: tuple[float, float],
        wanted: tuple[float, float],
        points: tuple[Floats, Floats],
        *,
        axis: float = 0.0,
        aside: float = 0.0,
    ) -> tuple[float, float]:
        """The admissible velocity that is nearest to the commanded one.

        It is never faster than the command and never of the other sign.

        Args:
            now: The present velocity along the axis, and turn rate [m/s, rad/s].
            wanted: The velocity that the operator commands [m/s, rad/s].
            points: Obstacles in `base_link` [m], x and y of shape (n,) each.
            axis: Direction of the linear velocity in `base_link` [rad].
            aside: The present velocity across the axis [m/s].
        """
        body = self.body
        if wanted[0] < 0.0 and body.outline is not None:
            back, turn = self.towards(
                (-now[0], now[1]),
                (-wanted[0], wanted[1]),
                points,
                axis=axis + math.pi,
                aside=-aside,
            )
            return -back, turn
        goal = _limited(wanted[0], body.fastest), _limited(wanted[1], body.angular_limit)
        if not len(points[0]):
            return goal
        scene = self._scene(now, points, axis, aside)
        if goal[0] == 0.0:
            return 0.0, self._spin(goal[1], scene)
        fastest = self._reachable(now[0], goal[0])
        if self._judged(np.array([fastest]), np.array([goal[1]]), scene)[1][0]:
            return fastest, goal[1]
        linear, angular = self._samples(fastest, now[1], goal[1])
        gone, turned = body.share(goal[0] - linear, goal[1] - angular)
        cost = np.add(gone * gone, _TURN_WEIGHT * turned * turned, out=self._cost)
        cost[~self._judged(linear, angular, scene)[1]] = np.inf
        best = int(cost.argmin())
        chosen = float(linear[best])
        least = _SET_OFF if abs(now[0]) < _CREEP else _CREEP
        if not math.isfinite(cost[best]) or abs(chosen) < min(least, abs(goal[0])):
            return 0.0, self._spin(goal[1], scene)
        return chosen, float(angular[best])

    def to_goal(
        self,
        now: tuple[float, float],
        carrot: tuple[float, float],
        fastest: float,
        points: tuple[Floats, Floats],
        *,
        way_back: tuple[float, float] | None = None,
    ) -> tuple[float, float]:
        """The admissible velocity with the best score for a place.

        Args:
            now: The present velocity [m/s, rad/s].
            carrot: The point to head for, in `base_link` [m].
            fastest: Largest forward velocity [m/s].
            points: Obstacles in `base_link` [m], x and y of shape (n,) each.
            way_back: The point to back to where it has no room to turn, in `base_link` [m]; None:
                it must not back.
        """
        bearing = math.atan2(carrot[1], carrot[0])
        scene = self._scene(now, points, 0.0, 0.0)
        if abs(bearing) > _TURN_FIRST or (now[0] < _CREEP and abs(bearing) > _TURN_FIRST / 2.0):
            for angle in (bearing, bearing - math.copysign(math.tau, bearing)):
                if self._has_room(angle, scene):
                    return 0.0, self._spin(self._turn_rate(angle), scene)
            if way_back is not None and abs(bearing) > math.pi - _TURN_FIRST:
                behind = self._scene((-now[0], now[1]), points, math.pi, 0.0)
                there = -way_back[0], -way_back[1]
                back = self._best((-now[0], now[1]), there, _BACKING, behind)
                if back[0]:
                    return -back[0], back[1]
            best = 0.0, 0.0
        else:
            best = self._best(now, carrot, fastest, scene)
        return best if best[0] else (0.0, self._spin(self._turn_rate(bearing), scene))

    def _best(
        self, now: tuple[float, float], carrot: tuple[float, float], fastest: float, scene: _Scene
    ) -> tuple[float, float]:
        """The velocity along the scene's axis with the best score; 0: none leads on."""
        top = self._reachable(now[0], min(fastest, self.body.linear_limit))
        linear, angular = self._samples(top, now[1], 0.0)
        spare, admissible = self._judged(linear, angular, scene)
        score = self._score(linear, angular, np.minimum(spare, _FAR), carrot)
        score[~admissible] = -np.inf
        best = int(score.argmax())
        if linear[best] < _CREEP or not admissible[best]:
            return 0.0, 0.0
        return float(linear[best]), float(angular[best])

    def turn(self, now: tuple[float, float], angle: float, points: tuple[Floats, Floats]) -> float:
        """The admissible turn rate that turns by an angle without overshoot [rad/s]."""
        return self._spin(self._turn_rate(angle), self._scene(now, points, 0.0, 0.0))

    def _turn_rate(self, angle: float) -> float:
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
            + weights.speed * self.body.share(linear, angular)[0]
        )
        table = score.reshape(LINEAR_SAMPLES, -1)[:, :ANGULAR_SAMPLES]
        table[:, 1:-1] = (table[:, :-2] + table[:, 1:-1] + table[:, 2:]) / 3.0
        return score

    def _scene(
        self, now: tuple[float, float], points: tuple[Floats, Floats], axis: float, aside: float
    ) -> _Scene:
        """The surroundings in the frame of a motion, with what the present motion may add."""
        body = self.body
        x, y = Pose(theta=axis).inward(*points) if axis else points
        outline = body.outline and body.outline.along(axis)
        if outline is None:
            nearest = float(np.sqrt((x * x + y * y).min())) - body.radius if len(x) else math.inf
        else:
            nearest = float(outline.distances(x, y).min()) if len(x) else math.inf
        return _Scene(
            x=x,
            y=y,
            outline=outline,
            # A robot that is nearer to an obstacle than the margin must be able to pass it.
            side=max(0.0, min(body.side_margin, nearest - 0.003)),
            drift=aside * aside / (2.0 * body.linear_braking),
            turning=now[1],
        )

    def _judged(
        self, linear: Floats, angular: Floats, scene: _Scene
    ) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """How far the robot can go beyond its stopping distance, and whether it can stop.

        It holds a velocity until the next choice, and stops after it. On an arc both velocities
        fall to 0 in the same time, so the robot stays on it.

        Args:
            linear: Velocities along the axis [m/s], shape (m,).
            angular: Turn rates [rad/s], shape (m,).
            scene: The surroundings.

        Returns:
            Lengths [m] and flags, shape (m,) each.
        """
        body, speed = self.body, np.abs(linear)
        if scene.outline is None:
            # Turn rates need no limit of their own: a round body meets nothing by turning.
            ahead, side = self._margins(speed, scene)
            radius = body.radius + ahead
            half_width = np.minimum(body.radius + side, radius)
            ways = free_ways(linear, angular, scene.x, scene.y, radius, half_width)
            stopping = body.stopping(speed)
            return ways - stopping, stopping <= ways
        times = self._free_times(scene.outline, speed, angular, scene)
        braking = np.maximum(speed / body.linear_braking, np.abs(angular) / body.angular_braking)
        stopping = body.reaction + 0.5 * braking
        return np.minimum(times - stopping, _LONG_S) * speed, stopping <= times

    def _margins(self, speed: Floats, scene: _Scene) -> tuple[Floats, Floats]:
        """Distances to keep ahead and beside, without a turn [m], shape (m,) each."""
        body = self.body
        ahead = body.margin + body.margin_s * speed + scene.drift
        return ahead, scene.side + 0.5 * body.margin_s * speed + scene.drift

    def _free_times(self, outline: Sweep, speed: Floats, angular: Floats, scene: _Scene) -> Floats:
        """The time until the outline meets something at each velocity [s], shape (m,)."""
        body, rim = self.body, outline.radius
        ahead, side = self._margins(speed, scene)
        # Until the turn rate has changed the heading differs, and the ends are elsewhere.
        swing = rim * np.square(scene.turning - angular) / (2.0 * body.angular_braking)
        side += 0.5 * body.margin_s * rim * np.abs(angular) + swing
        ahead = np.maximum(ahead + swing, side)
        return outline.free_times(speed, angular, scene.x, scene.y, ahead, side)

    def _has_room(self, angle: float, scene: _Scene) -> bool:
        """Whether the body can turn by an angle on the spot [rad]."""
        if scene.outline is None or not angle:
            return True
        rates = self._turn_rate(angle) * _SPINS
        times = self._free_times(scene.outline, np.zeros(len(rates)), rates, scene)
        return bool((times >= np.abs(angle / rates)).any())

    def _spin(self, rate: float, scene: _Scene) -> float:
        """The largest admissible share of a turn rate on the spot [rad/s]."""
        if scene.outline is None or rate == 0.0:
            return rate
        rates = rate * _SPINS
        admissible = self._judged(np.zeros(len(rates)), rates, scene)[1]
        return float(_SPINS[admissible].max(initial=0.0)) * rate

    def _reachable(self, now: float, goal: float) -> float:
        """The largest velocity towards the goal within the window [m/s].

        It is enough to set off, also for a slow body that does not measure small velocities.
        """
        gain = self.body.linear_braking / 2.0 * WINDOW_S
        start = abs(now) if now * goal > 0.0 else 0.0
        return math.copysign(min(max(start + gain, _SET_OFF), abs(goal)), goal)

    def _samples(self, fastest: float, turning: float, wanted: float) -> tuple[Floats, Floats]:
        """Velocities from 0 to the fastest, each with all turn rates; both shape (m,)."""
        limit = self.body.angular_limit
        gain = self.body.angular_braking * WINDOW_S
        low, high = _limited(turning - gain, limit), _limited(turning + gain, limit)
        self._linear[:] = (fastest * self._steps)[:, None]
        self._angular[:, :-1] = low + (high - low) * self._spread
        self._angular[:, -1] = max(low, min(high, wanted))
        return self._linear.reshape(-1), self._angular.reshape(-1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Scene:
    """The surroundings of the robot in the frame of its motion.

    Attributes:
        x: Obstacles [m], shape (n,).
        y: The same.
        outline: The body; None: the circle.
        side: Distance to keep beside the body [m].
        drift: How far it goes on across its new direction [m].
        turning: The present turn rate [rad/s].
    """

    x: Floats
    y: Floats
    outline: Sweep | None
    side: float
    drift: float
    turning: float


def _limited(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
