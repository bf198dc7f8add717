"""A wheeled or tracked base on rough ground: it climbs, slips, slides, hangs and tips."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hub.gcm.body import Bumper
from hub.pose import Pose
from hub.sim.arena import Arena
from hub.sim.contact import Impact
from hub.sim.ground.chassis import Chassis
from hub.sim.ground.footing import TIPPED, Footing, Stance
from hub.sim.ground.map_builder import level_ground
from hub.sim.ground.toppling import fallen, way_of_fall
from hub.sim.kinematics import ANGULAR, LINEAR, approach, limited, moved
from hub.sim.odometry import WheelOdometry
from hub.sim.spatial_pose import SpatialPose
from hub.sim.steps import GRAVITY, WholeSteps
from hub.sim.storeys import Storeys

STEP = 0.01
"""Length of a step of the simulation [s]."""
ROLLING = 0.03
"""Rolling resistance as a share of the weight."""
HANGING = 0.05
"""With less of the weight on driven wheels the body hangs on its belly [share]."""
_STIFFNESS = 20.0
"""The body follows the ground critically damped at this frequency [rad/s]."""
_NO_SLIP = 0.5
"""Up to this share of the grip wheels do not slip."""
_MOST_SLIP = 0.3
"""Slip at the limit of the grip, as a share of the wheels' speed."""
_FASTEST_SLIDE = 3.0
"""Largest speed of a slide [m/s]."""
_FASTEST_LIFT = 1.0
"""Largest speed at which the ground lifts a body that does not lean as it should yet [m/s]."""
_PROBE = 0.02
"""How far ahead the fall of the ground is sought where a body may slide [m]."""
_ROUNDING = 1e-9
_AT_REST = 1e-9
"""A body that moves slower than this stands until the next command [m/s or rad/s]."""


class RoughBase:
    """A base on the ground of an arena; it stops at walls.

    The same seed and the same calls give the same values to the last bit. On level ground it moves
    exactly as the base without a height map does.

    Attributes:
        pose: The true pose.
        tipped: It lies on its side, for good.
        stuck: Its wheels spin on the spot.
        high_centred: Its driven wheels carry less than `HANGING` of the weight.
        linear: True velocity along the heading [m/s].
        angular: True turn rate [rad/s].
        wheel_linear: Velocity by the encoders [m/s].
        wheel_angular: Turn rate by the encoders [rad/s].
        slip: Share of the wheels' speed that is lost, 0 to 1.
        climb: True velocity upwards [m/s].
        slide_speed: Speed of the body down a slope that it cannot hold [m/s].
    """

    def __init__(
        self,
        arena: Arena,
        chassis: Chassis,
        *,
        seed: int = 0,
        linear_limit: float = 0.5,
        angular_limit: float = 1.0,
        flippers: tuple[float, ...] | None = None,
        bumpers: Sequence[Bumper] = (),
        outline: npt.NDArray[np.float64] | None = None,
    ) -> None:
        """Stance at the start of the arena.

        Args:
            arena: Its arena.
            chassis: Its body.
            seed: Of the errors of its odometry.
            linear_limit: Largest velocity [m/s].
            angular_limit: Largest turn rate [rad/s].
            flippers: Angle of each pair at the start [rad]; None: as at home.
            bumpers: Its bumpers.
            outline: Corners of what walls stop [m], shape (n, 2); none: the circle of the chassis.
        """
        odometry_seed, _ = np.random.SeedSequence(seed).spawn(2)
        field = arena.ground or level_ground()
        self.chassis = chassis
        self._limits = linear_limit, angular_limit
        self._odometry = WheelOdometry(odometry_seed)
        self._walls = Storeys(arena, field, chassis, bumpers, outline)
        self._angles = flippers or tuple(pair.home for pair in chassis.flippers)
        self._wanted_angles = self._angles
        self._footing = Footing(field, chassis, self._angles)
        self._field = field
        self._commanded = (0.0, 0.0)
        self._time = WholeSteps(STEP)
        self._rates = (0.0, 0.0, 0.0)
        self.steps = 0
        self.linear = self.angular = self.climb = 0.0
        self.wheel_linear = self.wheel_angular = 0.0
        self.slip = self.slide_speed = 0.0
        self.stuck = self.high_centred = False
        start = moved(arena.start, 0.0, 0.0)  # its heading is in (-pi, pi]
        settled = self._footing.settled(start.x, start.y, start.theta)
        self.tipped = settled is None
        self.pose = settled or SpatialPose(
            x=start.x, y=start.y, z=field.height(start.x, start.y), yaw=start.theta
        )
        self._stance = self._footing.stance(self.pose)
        self._is_at_rest = False

    def command(self, linear: float, angular: float) -> None:
        """Set the velocity: forward [m/s], counter-clockwise [rad/s]; NaN counts as 0."""
        self._commanded = limited(linear, self._limits[0]), limited(angular, self._limits[1])
        self._is_at_rest = False

    def command_flippers(self, *angles: float) -> None:
        """Set the angle above the ground of each pair, front first [rad]; NaN leaves one alone."""
        self._is_at_rest = False
        self._wanted_angles = tuple(
            wanted if math.isnan(angle) else max(pair.limits[0], min(pair.limits[1], angle))
            for pair, wanted, angle in zip(
                self.chassis.flippers, self._wanted_angles, angles, strict=True
            )
        )

    def advance(self, seconds: float) -> None:
        """Advance the simulated time in whole steps; the rest counts in the next call."""
        for _ in range(self._time.due(seconds)):
            self._step()

    @property
    def commanded(self) -> tuple[float, float]:
        """The velocities that it was commanded [m/s, rad/s]."""
        return self._commanded

    @property
    def flippers(self) -> tuple[float, ...]:
        """Present angle of each pair of flippers, front first [rad]."""
        return self._angles

    @property
    def odometry(self) -> Pose:
        """The pose by the encoders; the start is its origin. It is wrong where wheels slip."""
        return self._odometry.pose

    @property
    def contacts(self) -> int:
        """Number of new contacts with obstacles."""
        return self._walls.contacts

    @property
    def impact(self) -> Impact:
        """The last new contact."""
        return self._walls.impact

    @property
    def touches(self) -> bool:
        """Whether it touches an obstacle."""
        return self._walls.touches

    @property
    def bumpers(self) -> int:
        """Bit i is set when something touches bumper i."""
        return self._walls.bumpers(self.pose)

    @property
    def loads(self) -> npt.NDArray[np.float64]:
        """The share of the weight on each contact point; nothing carries a body that tipped."""
        if self.tipped or self._stance is None:
            return np.zeros(len(self.chassis.contact_points(self._angles)))
        return self._footing.loads(self._stance)

    def _step(self) -> None:
        self.steps += 1
        if self._is_at_rest:
            return
        self._turn_flippers()
        linear = approach(self.wheel_linear, self._commanded[0], LINEAR, STEP)
        angular = approach(self.wheel_angular, self._commanded[1], ANGULAR, STEP)
        if self.tipped:
            self._lie(linear, angular)
            return
        here, grade = self._ahead(linear, angular)
        if here is not None and linear and angular and not self._pulls(here, grade):
            # What the sweep of a turn meets need not stop the way ahead.
            here, grade = self._ahead(linear, 0.0)
            turn = 0.0
        else:
            turn = angular
        if here is None or self.pose.lean > TIPPED:
            self.tipped = True
            self._lie(linear, angular)
            return
        self._stance = here
        speed = self._speed(linear, turn, grade, here)
        self._move(linear, angular, speed, 0.0 if self.high_centred or self.stuck else turn, here)
        self._follow(here)

    def _ahead(self, linear: float, angular: float) -> tuple[Stance | None, float]:
        """How the body stands, and how steeply its centre of mass rises on its arc [m/m].

        The arc is as long as the chassis bridges, for the outermost parts in a turn.
        """
        pose = self.pose
        speed = abs(linear) + abs(angular) * self.chassis.reach
        if speed == 0.0:
            return self._footing.stance(pose), 0.0
        seconds = self.chassis.bridge / speed + STEP
        there = moved(pose.plan, linear * seconds, angular * seconds)
        here = self._footing.stance(pose, pose.at(there))
        return here, 0.0 if here is None else here.rise / (speed * seconds)

    def _need(self, here: Stance, grade: float) -> float:
        """The push that a motion needs, as a share of the weight.

        Virtual work: on a metre ahead the centre of mass rises by `grade`. That, the rolling
        resistance and what drags need a push.
        """
        return max(grade + ROLLING + self.chassis.grip * here.drag, 0.0)

    def _pulls(self, here: Stance, grade: float) -> bool:
        """Whether friction on the driven wheels gives the push that a motion needs."""
        return self.chassis.grip * here.push > self._need(here, grade)

    def _turn_flippers(self) -> None:
        if self._angles == self._wanted_angles:
            return
        self._angles = tuple(
            now + max(-pair.speed * STEP, min(pair.speed * STEP, wanted - now))
            for pair, now, wanted in zip(
                self.chassis.flippers, self._angles, self._wanted_angles, strict=True
            )
        )
        self._footing.turn_flippers(self._angles)

    def _speed(self, linear: float, angular: float, grade: float, here: Stance) -> float:
        """Horizontal speed that the wheels give [m/s]."""
        self.high_centred = here.driven_load < HANGING
        self.stuck = bool(linear or angular) and not self._pulls(here, grade)
        if self.stuck:
            self.slip = 1.0
            return 0.0
        if not linear:
            self.slip = 0.0
            return 0.0
        share = self._need(here, grade) / (self.chassis.grip * here.push)
        over = max(0.0, share - _NO_SLIP) / (1.0 - _NO_SLIP)
        self.slip = _MOST_SLIP * over * over
        return linear * (1.0 - self.slip) / math.hypot(1.0, grade)

    def _move(self, linear: float, angular: float, speed: float, turn: float, here: Stance) -> None:
        before = self.pose
        wanted = moved(before.plan, speed * STEP, turn * STEP)
        self.slide_speed = self._slide(here)
        if self.slide_speed > 0.0:
            wanted = _shifted(wanted, here.downhill, self.slide_speed * STEP)
        after = self._walls.move(before, wanted)
        heading = before.yaw + turn * STEP / 2
        forward = (after.x - before.x) * math.cos(heading) + (after.y - before.y) * math.sin(
            heading
        )
        # An outline that cannot be pushed aside does not turn either.
        holds = self._walls.touches and after.theta == before.yaw
        self.linear, self.angular = speed, 0.0 if holds else turn
        if self._walls.touches or (after.x, after.y) != (wanted.x, wanted.y):
            # Wheels that grip the floor stop with the body; their motors stall.
            self.linear = max(min(forward / STEP, max(speed, 0.0)), min(speed, 0.0))
            if speed:
                linear *= self.linear / speed
        self.wheel_linear, self.wheel_angular = linear, angular
        self._odometry.moved(linear * STEP, angular * STEP, STEP)
        self.pose = before.at(after)

    def _slide(self, here: Stance) -> float:
        """Speed down a slope that is steeper than brakes hold [m/s]."""
        hold = self.chassis.grip * here.hold
        if here.steepness <= hold and self.slide_speed == 0.0:
            return 0.0
        probe = _shifted(self.pose.plan, here.downhill, _PROBE)
        below = self._footing.stance(self.pose, self.pose.at(probe))
        fall = 0.0 if below is None else -below.rise / _PROBE
        faster = self.slide_speed + GRAVITY * (fall - hold) * STEP
        return max(0.0, min(_FASTEST_SLIDE, faster))

    def _follow(self, here: Stance) -> None:
        """Let height and lean follow the resting pose: above ground, and not faster than a fall."""
        pose = self.pose
        now, goals = (pose.z, pose.roll, pose.pitch), (here.z, here.roll, here.pitch)
        values, rates = [], []
        for place, goal, rate, least in zip(
            now, goals, self._rates, (-GRAVITY, -math.inf, -math.inf), strict=True
        ):
            push = _STIFFNESS * _STIFFNESS * (goal - place) - 2.0 * _STIFFNESS * rate
            rates.append(rate + max(push, least) * STEP)
            values.append(place + rates[-1] * STEP)
        if values[0] < here.lowest_z:
            lifted = max(values[0], pose.z + _FASTEST_LIFT * STEP)
            values[0], rates[0] = min(here.lowest_z, lifted), max(rates[0], 0.0)
        self.climb = (values[0] - pose.z) / STEP
        self._rates = (rates[0], rates[1], rates[2])
        self._rest(rates[1], rates[2])
        self.pose = SpatialPose(
            x=pose.x, y=pose.y, z=values[0], roll=values[1], pitch=values[2], yaw=pose.yaw
        )

    def _lie(self, linear: float, angular: float) -> None:
        """Fall to the side that is lower, and lie there; the wheels turn in the air."""
        pose, reach = self.pose, self.chassis.reach
        after = self._walls.move(pose, _shifted(pose.plan, way_of_fall(pose, reach, STEP), 1.0))
        ground = self._field.height(after.x, after.y, below=pose.z + _ROUNDING)
        self.pose, self.climb = fallen(pose, after, self._rates[0], ground, reach, STEP)
        turns = (self.pose.roll - pose.roll) / STEP, (self.pose.pitch - pose.pitch) / STEP
        self._rates = (self.climb, 0.0, 0.0)
        self._stance = None
        self.linear = self.angular = 0.0
        self.stuck, self.high_centred, self.slip, self.slide_speed = linear != 0.0, False, 1.0, 0.0
        self.wheel_linear, self.wheel_angular = linear, angular
        self._odometry.moved(linear * STEP, angular * STEP, STEP)
        self._rest(*turns)

    def _rest(self, roll_rate: float, pitch_rate: float) -> None:
        """Stand until the next command, if nothing moves; the rates are in rad/s."""
        speeds = (self.linear, self.climb, self._rates[0], self.wheel_linear, self.slide_speed)
        turns = (self.angular, self.wheel_angular, roll_rate, pitch_rate)
        self._is_at_rest = (
            max(map(abs, (*speeds, *turns))) < _AT_REST
            and self._angles == self._wanted_angles
            and self._commanded == (0.0, 0.0)
        )


def _shifted(pose: Pose, direction: tuple[float, float], way: float) -> Pose:
    """The pose after a way along a direction in the plane [m]; the heading stays."""
    return Pose(x=pose.x + direction[0] * way, y=pose.y + direction[1] * way, theta=pose.theta)
