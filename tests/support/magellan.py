"""The simulated Magellan of the tests: the body of the shipped kind in any arena."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from hub.gcm.beams import beams_of
from hub.gcm.body import BodyFrame, Freedom, RobotBody
from hub.gcm.frames import in_base
from hub.gcm.geometry import Twist
from hub.gcm.navigation import DriveState
from hub.gcm.ranges import LaserScan
from hub.modules.driver.reports import drive_state
from hub.robots.robot_file import find_robot_file, read_description
from hub.robots.simulated_base import SimulatedBase
from hub.robots.simulated_camera import SimulatedCamera
from hub.sim.arena import Arena, Footprints
from hub.sim.range_sensors import RangeSensors


@functools.cache
def magellan_body() -> RobotBody:
    return read_description(find_robot_file("magellan"))[0].body


def magellan_mount() -> BodyFrame:
    """Where the camera is on the robot."""
    frame = in_base(magellan_body().frames, magellan_body().cameras[0].name)
    assert frame is not None
    return frame


def magellan_camera(
    arena: Arena, *, light: float | None = None, headlight: bool = True, seed: int = 0
) -> SimulatedCamera:
    return SimulatedCamera(
        arena,
        body=magellan_body().cameras[0],
        mount=magellan_mount(),
        light=light,
        headlight=headlight,
        seed=seed,
    )


def magellan_sensors(obstacles: Footprints, seed: int) -> RangeSensors:
    return RangeSensors(obstacles, beams_of(magellan_body()), np.random.SeedSequence(seed))


class SimulatedMagellan(SimulatedBase):
    def __init__(
        self,
        arena: Arena,
        *,
        seed: int = 0,
        linear_limit: float = 0.5,
        angular_limit: float = 1.0,
        body: RobotBody | None = None,
    ) -> None:
        body = body or magellan_body()
        limits = {Freedom.SURGE: linear_limit, Freedom.YAW: angular_limit}
        motions = tuple(
            dataclasses.replace(motion, limit=limits[motion.freedom]) for motion in body.motions
        )
        super().__init__(arena, dataclasses.replace(body, motions=motions), seed=seed)
        self._last: tuple[LaserScan, ...] | None = None

    def set_velocity(self, linear: float, angular: float) -> None:
        self.command(Twist.planar(linear, angular))

    def drive_state(self, stamp: float) -> DriveState:
        return drive_state(self.sensors(stamp), stamp)

    def ranges(self, stamp: float) -> tuple[LaserScan, ...] | None:
        """Its scans; None: they are those of the last call."""
        scans = self.sensors(stamp).scans
        last, self._last = self._last, scans
        return None if scans is last else scans
