"""A simulated robot under a pilot, at the rates of the processes, without any process."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hub.gcm.body import USUAL_RADIUS
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.navigation import GroundTruth
from hub.gcm.ranges import RangeReadings
from hub.modules.driver.reports import drive_state, imu
from hub.modules.navigation.dynamic_window import body_of
from hub.modules.navigation.path_follower import PathFollower
from hub.pose import Pose
from hub.robots.description import Base, RobotDescription
from hub.robots.robot_file import find_robot_file, read_description
from hub.robots.simulated_base import SimulatedBase
from hub.robots.simulated_rough_base import RoughBody
from hub.sim.arena import Arena
from hub.sim.ground.chassis import TRACKED

ROBOT = read_description(find_robot_file("magellan"))[0]
TRACKED_ROBOT = read_description(find_robot_file("tracked"))[0]
BODY = body_of(ROBOT)
STEP = 0.01
STEPS_PER_REPORT = 2
STEPS_PER_CHOICE = 5


def random_start(arena: Arena, seed: int, clearance: float = 0.01) -> Pose:
    """A pose in a hall of 10 by 10 m at which the body is this far from everything [m]."""
    random = np.random.default_rng(seed)
    while True:
        x, y, theta = random.uniform((0.0, 0.0, -math.pi), (10.0, 10.0, math.pi)).tolist()
        if arena.footprints.distances(x, y).min() > USUAL_RADIUS + clearance:
            return Pose(x=x, y=y, theta=theta)


class Drive:
    """A robot somewhere in an arena, and its pilot."""

    def __init__(
        self, arena: Arena, start: Pose, seed: int = 1, robot: RobotDescription = ROBOT
    ) -> None:
        there = dataclasses.replace(arena, start=start)
        self.robot: SimulatedBase | RoughBody = (
            RoughBody(there, robot.body, TRACKED, seed=seed)
            if robot.base is Base.TRACKS
            else SimulatedBase(there, robot.body, seed=seed)
        )
        self.pilot = PathFollower(body_of(robot), robot.body)
        self.given = Twist()
        self._steps = 0

    @property
    def now(self) -> float:
        return self._steps * STEP

    @property
    def truth(self) -> GroundTruth:
        return self.robot.ground_truth()

    def push(self, linear: float, angular: float, seconds: float, sway: float = 0.0) -> None:
        """Hold the stick for a while, or until something is touched or it has long stood."""
        stood = 0.0
        for _ in range(round(seconds / STEP)):
            if self._report():
                wanted = Twist(linear=Vector3(x=linear, y=sway), angular=Vector3(z=angular))
                self.given = self.pilot.assisted(wanted, self.now)
                self.robot.command(self.given)
            self._advance()
            stood = stood + STEP if self.given.neutral else 0.0
            if self.truth.contacts or stood > 2.0:
                return

    def carry_out(self, seconds: float) -> None:
        """Let the pilot's task go on until it ends, for so long at most."""
        for _ in range(round(seconds / STEP)):
            if self._report():
                self.given = Twist.planar(*self.pilot.steered(self.now) or (0.0, 0.0))
                self.robot.command(self.given)
            self._advance()
            if not self.pilot.task.active:
                return

    def _report(self) -> bool:
        """Report if it is time; whether it is also time for a choice."""
        if self._steps % STEPS_PER_REPORT == 0 or self._steps == 0:
            sensors = self.robot.sensors(self.now)
            self.pilot.reported(drive_state(sensors, self.now), self.now, self.now)
            lean = imu(sensors, self.now)
            if lean is not None:
                self.pilot.tilted(lean, self.now)
            self.pilot.scanned(RangeReadings(scans=sensors.scans), self.now, self.now)
        return self._steps % STEPS_PER_CHOICE == 0

    def _advance(self) -> None:
        self.robot.advance(STEP)
        self._steps += 1
