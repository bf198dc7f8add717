"""The simulated base on rough ground as a body of the driver: wheels, or tracks with flippers."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hub.gcm.beams import beams_of
from hub.gcm.body import USUAL_HEIGHT, Freedom, RobotBody, SenseKind
from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.gcm.geometry import Twist
from hub.gcm.joints import JointState
from hub.gcm.navigation import GroundTruth
from hub.gcm.outline import corners
from hub.gcm.ranges import LaserScan, scan_of
from hub.pose import Pose, wrapped
from hub.robots.interfaces import Sensors
from hub.robots.simulated_base import STEPS_PER_SCAN
from hub.sim.arena import Arena
from hub.sim.battery import Battery
from hub.sim.ground.chassis import Chassis
from hub.sim.range_sensors import RangeSensors
from hub.sim.rough_base import STEP, RoughBase
from hub.sim.senses import VictimSenses
from hub.sim.solids import solids_of

_SLIDES = 0.05
"""A slide that the operator should know of [m/s]."""
_SLIPS = 0.1
"""A slip that the operator should know of."""


class RoughBody:
    """A base that climbs, slips and tips; implements `Body` and `BodyJoints`.

    Its range sensors lean with it and meet the ground. For walls, sonars look along the level.
    """

    def __init__(self, arena: Arena, body: RobotBody, chassis: Chassis, *, seed: int = 0) -> None:
        """Stand at the start of the arena.

        Args:
            arena: Its arena.
            body: Its described outline, velocities, range sensors, bumpers and pairs of flippers,
                the front pair first.
            chassis: What touches the ground.
            seed: Of all noise.
        """
        limits = {motion.freedom: motion.limit for motion in body.motions}
        self._base = RoughBase(
            arena,
            chassis,
            seed=seed,
            linear_limit=limits.get(Freedom.SURGE, 0.0),
            angular_limit=limits.get(Freedom.YAW, 0.0),
            bumpers=body.bumpers,
            outline=corners(body),
        )
        _, sensor_seed = np.random.SeedSequence(seed).spawn(2)
        self._joints = body.joints
        self._rates = {joint.name: 0.0 for joint in body.joints}
        self._groups = body.ranges
        self._sensors = RangeSensors(
            arena.footprints, beams_of(body), sensor_seed, arena.ground, solids_of(arena)
        )
        self._height = body.height if math.isfinite(body.height) else USUAL_HEIGHT
        self._senses = {sense.kind for sense in body.senses}
        self._air = VictimSenses(arena)
        self._heard: dict[SenseKind, float] = {}
        self._battery = Battery()
        self._origin = arena.place_number(self._base.pose)
        self._scanned = -STEPS_PER_SCAN
        self._scans: tuple[LaserScan, ...] = ()

    def command(self, twist: Twist) -> None:
        """Set the velocity; NaN counts as 0."""
        self._base.command(twist.linear.x, twist.angular.z)

    def turn_joint(self, name: str, rate: float) -> None:
        """Turn a pair of flippers at a rate [rad/s]; 0 stops it."""
        if name in self._rates:
            self._rates[name] = rate

    def advance(self, seconds: float) -> None:
        """Advance the simulated time."""
        before = self._base.steps
        self._turn_flippers(seconds)
        self._base.advance(seconds)
        passed = (self._base.steps - before) * STEP
        wheels = self._base.wheel_linear, self._base.wheel_angular
        self._battery = self._battery.after(passed, *wheels)

    def _turn_flippers(self, seconds: float) -> None:
        """Set the angles that the flippers reach in a time [s]; NaN leaves a pair alone."""
        if not any(self._rates.values()):
            return
        angles = [math.nan] * len(self._base.flippers)
        for place, (joint, angle) in enumerate(
            zip(self._joints, self._base.flippers, strict=False)
        ):
            if rate := self._rates[joint.name]:
                turned = angle + rate * seconds
                angles[place] = max(joint.lowest, min(joint.highest, turned))
        self._base.command_flippers(*angles)

    def _flippers(self) -> tuple[JointState, ...]:
        return tuple(
            JointState(name=joint.name, position=angle, velocity=self._rates[joint.name])
            for joint, angle in zip(self._joints, self._base.flippers, strict=False)
        )

    def _problems(self) -> Iterator[DiagnosticStatus]:
        """What a perfect sensor of slip finds."""
        base = self._base
        if base.tipped:
            return  # the tilt says it
        if base.high_centred:
            yield _warning("stuck", "stuck: it hangs on its belly")
        elif base.stuck:
            yield _warning("stuck", "stuck: its wheels or tracks spin on the spot")
        elif base.slide_speed > _SLIDES:
            yield _warning("slip", f"slides down the slope at {base.slide_speed:.1f} m/s")
        elif base.slip > _SLIPS:
            yield _warning("slip", f"wheels slip: {base.slip:.0%} of the way is lost")

    def _sense(self) -> dict[SenseKind, float]:
        """What its sensors of the air measure, on top of its body."""
        if not self._senses:
            return {}
        pose = self._base.pose
        sound, co2 = self._air.at(pose.x, pose.y, pose.z + self._height)
        measured = {SenseKind.SOUND: sound, SenseKind.CO2: co2}
        return {kind: value for kind, value in measured.items() if kind in self._senses}

    def sensors(self, stamp: float) -> Sensors:
        """The present measurements; the tilt is that of a perfect sensor."""
        base = self._base
        if base.steps - self._scanned >= STEPS_PER_SCAN:
            self._scanned = base.steps
            level = Pose(x=base.pose.x, y=base.pose.y, theta=wrapped(base.pose.yaw))
            self._scans = tuple(
                scan_of(group, self._sensors.measure(group.name, level, base.pose), stamp)
                for group in self._groups
            )
            self._heard = self._sense()
        odometry = base.odometry
        return Sensors(
            x=odometry.x,
            y=odometry.y,
            theta=odometry.theta,
            velocity=Twist.planar(base.wheel_linear, base.wheel_angular),
            commanded=Twist.planar(*base.commanded),
            scans=self._scans,
            bumpers=base.bumpers,
            battery_voltage=self._battery.voltage,
            battery_fraction=self._battery.fraction,
            roll=math.remainder(base.pose.roll, math.tau),
            pitch=max(-math.pi / 2, min(math.pi / 2, base.pose.pitch)),
            origin=self._origin,
            sound=self._heard.get(SenseKind.SOUND, math.nan),
            co2=self._heard.get(SenseKind.CO2, math.nan),
            diagnostics=tuple(self._problems()),
            joints=self._flippers(),
        )

    def ground_truth(self) -> GroundTruth:
        """Its true pose in the arena's frame."""
        base = self._base
        return GroundTruth(
            time=base.steps * STEP,
            x=base.pose.x,
            y=base.pose.y,
            theta=wrapped(base.pose.yaw),
            linear=base.linear,
            angular=base.angular,
            commanded_linear=base.commanded[0],
            commanded_angular=base.commanded[1],
            contacts=base.contacts,
            touching=int(base.touches),
            z=base.pose.z,
            roll=math.remainder(base.pose.roll, math.tau),
            pitch=base.pose.pitch,
            heave=base.climb,
            contact_angle=base.impact.bearing,
            impact_speed=base.impact.approach / STEP,
        )


def _warning(name: str, message: str) -> DiagnosticStatus:
    return DiagnosticStatus(level=Severity.WARN, name=name, message=message)
