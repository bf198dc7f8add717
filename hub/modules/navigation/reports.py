"""What navigation says of the robot and of its task, as messages; pure."""

from __future__ import annotations

import math

from hub.gcm.navigation import DriveState, NavigationStatus, Point, RobotState
from hub.modules.navigation.path_follower import PathFollower
from hub.modules.navigation.speed_governor import SpeedGovernor
from hub.modules.navigation.task import NavigationTask


def robot_state(
    drive: DriveState,
    pilot: PathFollower,
    governor: SpeedGovernor,
    refused: int,
    frame: int,
    now: float,
) -> RobotState:
    """What is known of the robot, from what its hardware reports."""
    spread = pilot.spread
    pose = pilot.correction.pose(drive.x, drive.y, drive.theta)
    return RobotState(
        stamp=drive.stamp,
        x=pose.x,
        y=pose.y,
        theta=pose.theta,
        linear=drive.linear,
        angular=drive.angular,
        commanded_linear=drive.commanded_linear,
        commanded_angular=drive.commanded_angular,
        sonar=drive.sonar,
        infrared=drive.infrared,
        bumpers=drive.bumpers,
        battery_voltage=drive.battery_voltage,
        battery_fraction=drive.battery_fraction,
        motion=governor.state(now),
        refused=refused,
        assistance=pilot.assistance(now),
        held_back=pilot.held_back,
        frame=frame,
        position_off=spread.way,
        heading_off=min(spread.turn, math.pi),
        stops=governor.stops,
    )


def status(errand: NavigationTask, driver: int, now: float) -> NavigationStatus:
    """What is done now, or how it ended."""
    way = errand.route.way if errand.route is not None else ()
    x, y = errand.place
    return NavigationStatus(
        number=errand.number,
        task=errand.task,
        sender=errand.sender,
        driver=driver,
        points_left=len(errand.points),
        distance_left=errand.distance_left,
        why=errand.why,
        count=len(way),
        path=tuple(Point(x=x, y=y) for x, y in way),
        cause=errand.cause,
        x=x,
        y=y,
        seconds=errand.seconds(now),
        ended_s=math.nan if errand.active else now - errand.ended,
    )
