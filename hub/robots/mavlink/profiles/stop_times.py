"""The times to stand that the console, the doctor and the alarms say; pure."""

from __future__ import annotations

import math

from hub.robots.description import RobotDescription
from hub.robots.mavlink.profiles.profile import Parameters, VehicleProfile


def stop_times(
    profile: VehicleProfile,
    parameters: Parameters,
    robot: RobotDescription,
    *,
    receiver: bool | None,
) -> tuple[float, float]:
    """Times from the limits of the robot file: after a zero, and after the link is cut [s].

    NaN: not known, since a parameter that decides was not read, or this kind was never measured.

    Args:
        profile: The vehicle's kind.
        parameters: Those that were read.
        robot: Its robot file.
        receiver: Whether it has a radio receiver; None: not known, so the longer times count.
    """
    if profile.unread(parameters):
        return math.nan, math.nan
    speed = math.hypot(robot.linear_limit, robot.sway_limit)
    having = (receiver,) if receiver is not None else (False, True)
    zeros, cuts = zip(
        *(profile.stops(parameters, speed, receiver=each) for each in having), strict=True
    )
    return max(zeros), max(cuts)
