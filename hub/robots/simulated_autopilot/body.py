"""The body of a robot whose vehicle is a simulated autopilot in an arena: its true pose is known.

Its simulated cameras need the pose, which a real vehicle does not have.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from hub.gcm.navigation import GroundTruth
from hub.robots.description import Base, RobotDescription
from hub.robots.mavlink.body import MavlinkBody
from hub.robots.simulated_floats import DIVES_AT, FLIES_AT, start_of
from hub.sim.arena import load_arena
from hub.sim.spatial_pose import SpatialPose


class SimulatedAutopilotBody(MavlinkBody):
    """A `MavlinkBody` whose place in an arena is that of the simulated autopilot."""

    def __init__(
        self, robot: RobotDescription, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Open the link, and find the start in the arena.

        Args:
            robot: The robot file.
            clock: The monotonic clock [s].

        Raises:
            VehicleAddressError: The robot file has no address of a vehicle.
            KeyFileError: Its signing key cannot be used.
            ArenaError: There is no such arena.
        """
        super().__init__(robot, clock)
        self._now = clock
        arena = load_arena(robot.arena)
        surface = arena.water.surface if arena.water is not None else 0.0
        start = arena.start
        match robot.base:
            case Base.BLIMP:
                self._start = start_of(arena, "blimp", FLIES_AT)
            case Base.ROV:
                self._start = start_of(arena, "rov", surface - DIVES_AT)
            case _:
                self._start = SpatialPose(x=start.x, y=start.y, z=0.0, yaw=start.theta)
        self._surface = surface if robot.base is Base.ROV else 0.0

    def ground_truth(self) -> GroundTruth:
        """Its pose in the arena's frame; the start until the vehicle reports its place."""
        read, start, velocity = self.vehicle.telemetry, self._start, self.vehicle.telemetry.velocity
        known = not math.isnan(read.x + read.y + read.yaw)
        wanted = self.vehicle.velocity
        return GroundTruth(
            time=self._now(),
            x=start.x + read.x if known else start.x,
            y=start.y + read.y if known else start.y,
            z=self._surface + read.z if known else start.z,
            theta=read.yaw if known else start.yaw,
            roll=read.roll if known else 0.0,
            pitch=read.pitch if known else 0.0,
            linear=velocity.linear.x if known else 0.0,
            sway=velocity.linear.y if known else 0.0,
            heave=velocity.linear.z if known else 0.0,
            angular=velocity.angular.z,
            commanded_linear=wanted.ahead,
            commanded_angular=wanted.turn,
            contacts=0,
            touching=0,
        )
