"""The messages of navigation about the robot and its task; pure."""

from __future__ import annotations

import math

from hub.gcm.battery import BatteryState
from hub.gcm.geometry import Quaternion
from hub.gcm.navigation import DriveState, NavigationStatus, Point, RobotState
from hub.gcm.standard import BASE_LINK, MAP, ODOM, Header
from hub.gcm.transforms import Transform, Transforms, TransformStamped, Translation
from hub.modules.navigation.path_follower import PathFollower
from hub.modules.navigation.speed_governor import SpeedGovernor
from hub.modules.navigation.task import NavigationTask
from hub.pose import Pose


def robot_state(
    drive: DriveState,
    battery: BatteryState,
    pilot: PathFollower,
    governor: SpeedGovernor,
    refused: int,
    frame: int,
    now: float,
) -> RobotState:
    """The state of the robot, from reports of its hardware."""
    spread = pilot.spread
    pose = pilot.correction.pose(drive.x, drive.y, drive.theta)
    moves, commanded = drive.velocity, drive.commanded
    return RobotState(
        stamp=drive.odometry.header.stamp.seconds,
        x=pose.x,
        y=pose.y,
        theta=pose.theta,
        linear=moves.linear.x,
        angular=moves.angular.z,
        commanded_linear=commanded.linear.x,
        commanded_angular=commanded.angular.z,
        bumpers=drive.bumpers,
        battery_voltage=battery.voltage,
        battery_fraction=battery.percentage,
        sway=moves.linear.y,
        heave=moves.linear.z,
        motion=governor.state(now),
        refused=refused,
        assistance=pilot.assistance(now),
        held_back=pilot.held_back,
        frame=frame,
        position_off=spread.way,
        heading_off=min(spread.turn, math.pi),
        stops=governor.stops,
    )


def transforms(drive: DriveState, odom: Pose) -> Transforms:
    """The place of `odom` in `map`, and of `base_link` in `odom`."""
    stamp, pose = drive.odometry.header.stamp, drive.odometry.pose.pose
    place = pose.position
    corrected = Transform(
        translation=Translation(x=odom.x, y=odom.y), rotation=Quaternion.of(0.0, 0.0, odom.theta)
    )
    reckoned = Transform(
        translation=Translation(x=place.x, y=place.y, z=place.z), rotation=pose.orientation
    )
    return Transforms(
        transforms=(
            TransformStamped(
                header=Header(stamp=stamp, frame_id=MAP), child_frame_id=ODOM, transform=corrected
            ),
            TransformStamped(
                header=Header(stamp=stamp, frame_id=ODOM),
                child_frame_id=BASE_LINK,
                transform=reckoned,
            ),
        )
    )


def status(task: NavigationTask, driver: int, now: float) -> NavigationStatus:
    """The state of the task, or how it ended."""
    way = task.route.way if task.route is not None else ()
    x, y = task.place
    return NavigationStatus(
        number=task.number,
        task=task.state,
        sender=task.sender,
        driver=driver,
        points_left=len(task.points),
        distance_left=task.distance_left,
        why=task.why,
        path=tuple(Point(x=x, y=y) for x, y in way),
        cause=task.cause,
        x=x,
        y=y,
        seconds=task.seconds(now),
        ended_s=math.nan if task.active else now - task.ended,
    )
