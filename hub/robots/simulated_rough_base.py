"""The simulated base on rough ground as a body of the driver: wheels, or tracks with flippers."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.beams import beams_of
from hub.gcm.body import Freedom, RobotBody
from hub.gcm.geometry import Twist
from hub.gcm.navigation import GroundTruth
from hub.gcm.ranges import LaserScan, scan_of
from hub.pose import Pose, wrapped
from hub.robots.interfaces import Sensors
from hub.robots.simulated_base import STEPS_PER_SCAN
from hub.robots.simulated_floats import origin_of
from hub.sim.arena import Arena
from hub.sim.battery import Battery
from hub.sim.ground.chassis import Chassis
from hub.sim.range_sensors import RangeSensors
from hub.sim.rough_base import STEP, RoughBase


class RoughBody:
    """A base that climbs, slips and tips; implements `Body`.

    Its range sensors lean with it and meet the ground. For walls they look along the level.
    """

    def __init__(self, arena: Arena, body: RobotBody, chassis: Chassis, *, seed: int = 0) -> None:
        """Stand at the start of the arena.

        Args:
            arena: Its arena.
            body: Its described velocities, range sensors and bumpers.
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
        )
        _, sensor_seed = np.random.SeedSequence(seed).spawn(2)
        self._groups = body.ranges
        self._sensors = RangeSensors(arena.footprints, beams_of(body), sensor_seed, arena.ground)
        self._battery = Battery()
        self._origin = origin_of(arena, self._base.pose)
        self._scanned = -STEPS_PER_SCAN
        self._scans: tuple[LaserScan, ...] = ()

    def command(self, twist: Twist) -> None:
        """Set the velocity; NaN counts as 0."""
        self._base.command(twist.linear.x, twist.angular.z)

    def advance(self, seconds: float) -> None:
        """Advance the simulated time."""
        before = self._base.steps
        self._base.advance(seconds)
        passed = (self._base.steps - before) * STEP
        wheels = self._base.wheel_linear, self._base.wheel_angular
        self._battery = self._battery.after(passed, *wheels)

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
        )
