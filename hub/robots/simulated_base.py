"""A simulated base on wheels, of any body: what its robot file describes."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.beams import beams_of
from hub.gcm.body import Freedom, Motion, RobotBody
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.navigation import GroundTruth
from hub.gcm.outline import corners
from hub.gcm.ranges import LaserScan, scan_of
from hub.pose import Pose
from hub.robots.interfaces import Sensors
from hub.sim.arena import Arena
from hub.sim.battery import Battery
from hub.sim.contact import ContactBody
from hub.sim.kinematics import Accelerations, approach, limited, moved
from hub.sim.odometry import WheelOdometry
from hub.sim.range_sensors import RangeSensors
from hub.sim.solids import solids_of
from hub.sim.steps import WholeSteps

STEP = 0.01
"""Length of a step of the simulation [s]."""
STEPS_PER_SCAN = 10
"""All range sensors measure together at 10 Hz."""


class SimulatedBase:
    """Wheels, range sensors, bumpers and battery of any body in an arena; implements `Body`.

    The same seed and the same calls give the same values to the last bit. Reading a state changes
    nothing. Sensors scan at 10 Hz of simulated time; between two scans they report the last ranges.
    """

    def __init__(self, arena: Arena, body: RobotBody, *, seed: int = 0) -> None:
        """Stand at the start of the arena.

        Args:
            arena: Its arena.
            body: Its outline (the convex hull counts), velocities, range sensors and bumpers.
            seed: Of all noise.
        """
        odometry_seed, sensor_seed = np.random.SeedSequence(seed).spawn(2)
        self._limits = {motion.freedom: motion.limit for motion in body.motions}
        self._changes = {motion.freedom: _changes(motion) for motion in body.motions}
        self._body = ContactBody(arena.footprints, body.radius, body.bumpers, corners(body))
        self._odometry = WheelOdometry(odometry_seed)
        self._groups = body.ranges
        beams = beams_of(body)
        solids = solids_of(arena) if beams.elevation.any() else None
        self._sensors = RangeSensors(arena.footprints, beams, sensor_seed, solids=solids)
        self._battery = Battery()
        self._commanded = (0.0, 0.0, 0.0)
        self._linear = 0.0
        self._sway = 0.0
        self._angular = 0.0
        self._steps = 0
        self._time = WholeSteps(STEP)
        self._measured: dict[str, npt.NDArray[np.float32]] = {}
        self._scans: tuple[LaserScan, ...] = ()
        self._is_new = False
        # Compute the contacts of the body at the start.
        start = moved(arena.start, 0.0, 0.0)  # its heading is in (-pi, pi]
        self._pose = self._body.move(start, start)
        self._origin = arena.place_number(arena.start)
        self._scan()

    def command(self, twist: Twist) -> None:
        """Set the velocity; NaN counts as 0, and what the body cannot do is left out."""
        wanted = (
            (Freedom.SURGE, twist.linear.x),
            (Freedom.SWAY, twist.linear.y),
            (Freedom.YAW, twist.angular.z),
        )
        surge, sway, yaw = (
            limited(velocity, self._limits.get(freedom, 0.0)) for freedom, velocity in wanted
        )
        self._commanded = (surge, sway, yaw)

    def advance(self, seconds: float) -> None:
        """Advance the simulated time in whole steps; the rest counts in the next call."""
        for _ in range(self._time.due(seconds)):
            self._step()

    def sensors(self, stamp: float) -> Sensors:
        """The present measurements of encoders, range sensors, bumpers and battery."""
        if self._is_new:
            self._is_new = False
            self._scans = tuple(
                scan_of(group, self._measured[group.name], stamp) for group in self._groups
            )
        pose = self._odometry.pose
        surge, sway, yaw = self._commanded
        return Sensors(
            x=pose.x,
            y=pose.y,
            theta=pose.theta,
            velocity=_twist(self._linear, self._sway, self._angular),
            commanded=_twist(surge, sway, yaw),
            scans=self._scans,
            bumpers=self._body.bumpers(self._pose),
            battery_voltage=self._battery.voltage,
            battery_fraction=self._battery.fraction,
            origin=self._origin,
        )

    def ground_truth(self) -> GroundTruth:
        """Its true pose in the arena's frame."""
        return GroundTruth(
            time=self._steps * STEP,
            x=self._pose.x,
            y=self._pose.y,
            theta=self._pose.theta,
            linear=self._linear,
            angular=self._angular,
            commanded_linear=self._commanded[0],
            commanded_angular=self._commanded[2],
            contacts=self._body.contacts,
            touching=int(bool(self._body.touched)),
            sway=self._sway,
            contact_angle=self._body.impact.bearing,
            impact_speed=self._body.impact.approach / STEP,
        )

    def _step(self) -> None:
        surge, sway, yaw = self._commanded
        linear = self._approach(Freedom.SURGE, self._linear, surge)
        sideways = self._approach(Freedom.SWAY, self._sway, sway)
        angular = self._approach(Freedom.YAW, self._angular, yaw)
        if linear or sideways or angular:
            linear, sideways, angular = self._move(linear, sideways, angular)
        self._linear, self._sway, self._angular = linear, sideways, angular
        self._battery = self._battery.after(STEP, math.hypot(linear, sideways), angular)
        self._steps += 1
        if self._steps % STEPS_PER_SCAN == 0:
            self._scan()

    def _approach(self, freedom: Freedom, velocity: float, commanded: float) -> float:
        """The velocity after a step; it stays 0 in a freedom that the body does not have."""
        changes = self._changes.get(freedom)
        return approach(velocity, commanded, changes, STEP) if changes else 0.0

    def _move(self, linear: float, sideways: float, angular: float) -> tuple[float, float, float]:
        """Move for a step at these velocities; returns the part of them that contact allows."""
        before = self._pose
        wanted = moved(before, linear * STEP, angular * STEP, sideways * STEP)
        self._pose = self._body.move(before, wanted)
        if self._body.touched:
            if self._pose.theta == before.theta:
                angular = 0.0
            heading = before.theta + angular * STEP / 2
            linear = self._held_back(linear, before, heading)
            sideways = self._held_back(sideways, before, heading + math.pi / 2)
        self._odometry.moved(linear * STEP, angular * STEP, STEP, sideways * STEP)
        return linear, sideways, angular

    def _held_back(self, velocity: float, before: Pose, heading: float) -> float:
        """Velocity against an obstacle: wheels grip the floor, motors stall."""
        away_x, away_y = self._pose.x - before.x, self._pose.y - before.y
        along = away_x * math.cos(heading) + away_y * math.sin(heading)
        return max(min(along / STEP, max(velocity, 0.0)), min(velocity, 0.0))

    def _scan(self) -> None:
        self._measured = {
            group.name: self._sensors.measure(group.name, self._pose) for group in self._groups
        }
        self._is_new = True


def _changes(motion: Motion) -> Accelerations:
    """The body brakes as described, and speeds up half as hard."""
    return Accelerations(speeding_up=motion.acceleration / 2.0, braking=motion.acceleration)


def _twist(surge: float, sway: float, yaw: float) -> Twist:
    return Twist(linear=Vector3(x=surge, y=sway), angular=Vector3(z=yaw))
