"""The times to stand that the console, the doctor and the alarms say; pure."""

from __future__ import annotations

import math

from hub.robots.description import RobotDescription
from hub.robots.mavlink.profiles.profile import Parameters, VehicleProfile


def stop_times(
    profile: VehicleProfile, parameters: Parameters, robot: RobotDescription, *, receiver: bool
) -> tuple[float, float]:
    """Times from the limits of the robot file: after a zero, and after the link is cut [s].

    Args:
        profile: The vehicle's kind.
        parameters: Those that were read.
        robot: Its robot file.
        receiver: Whether it has a radio receiver.
    """
    speed = math.hypot(robot.linear_limit, robot.sway_limit)
    return profile.stops(parameters, speed, receiver=receiver)
