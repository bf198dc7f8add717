"""Where the robot of a recording is, and how fast it moves."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hub.errors import RosMessageError
from hub.gcm.navigation import MotionState, NavigationStatus, RobotState, Task
from hub.gcm.standard import BASE_LINK
from hub.recording.ros.topic_roles import RosRole
from hub.recording.ros.topic_values import ShownMessage, TopicValues, whole
from hub.ros import messages
from hub.ros.frame_tree import HERE, FramePlace, FrameTree, plain_frame, pose_of
from hub.ros.values import RosValue

_FIXED: Final = ("map", "odom", "world", "earth")
"""Names of frames that do not move with the robot, the best first (REP 105)."""
_BASES: Final = (BASE_LINK, "base_footprint", "base", "base_frame", "body")
_SILENT_NS: Final = 2_000_000_000
"""A command that is older does not count [ns]."""


def base_frame(values: TopicValues, frames: FrameTree) -> str:
    """Name of the frame of the body."""
    for known in values.all_shown(whole, RosRole.ODOMETRY):
        child = plain_frame(str(known.value.get("child_frame_id")))
        if child:
            return child
    return next((each for each in _BASES if each in frames.names), BASE_LINK)


def fixed_frame(values: TopicValues, frames: FrameTree, map_frame: str) -> str:
    """Name of the frame of the map, or else of the dead reckoning; empty: there is none.

    Args:
        values: The newest messages.
        frames: The frames.
        map_frame: The frame of the map; empty: there is no map.
    """
    base = base_frame(values, frames)
    known = (name for name in _FIXED if frames.place(base, name) is not None)
    return map_frame or next(known, "")


def mount(values: TopicValues, frames: FrameTree, value: RosValue) -> FramePlace:
    """The pose of the frame of a message in the body; unknown: that of the body."""
    frame = str(value.get("header.frame_id"))
    return frames.place(frame, base_frame(values, frames)) or HERE


def robot_state(
    values: TopicValues, frames: FrameTree, fixed: str, battery: ShownMessage | None
) -> ShownMessage | None:
    """Where the robot is in the fixed frame, how fast it moves, its charge; None: not known.

    What is not known of it is NaN.
    """
    odometry = values.first(whole, RosRole.ODOMETRY)
    place, stamp = _place(values, frames, odometry, fixed)
    (forward_wanted, turn_wanted), commanded = _command(values)
    forward = left = up = turning = math.nan
    if odometry is not None:
        forward, left, up, turning = messages.planar(odometry.value.get("twist.twist"))
    others = (each.stamp for each in (odometry, battery) if each is not None)
    stamp = max(stamp, commanded, *others)
    if stamp < 0:
        return None
    x = y = theta = math.nan
    if place is not None:
        x, y = (float(each) for each in np.clip(place.origin[:2], -1e6, 1e6))
        theta = place.roll_pitch_yaw[2]
    speeds = (forward, left, up, turning, forward_wanted, turn_wanted)
    moves = any(each and not math.isnan(each) for each in speeds)
    state = RobotState(
        stamp=min(1e10, stamp * 1e-9),
        x=x,
        y=y,
        theta=theta,
        linear=forward,
        angular=turning,
        commanded_linear=forward_wanted,
        commanded_angular=turn_wanted,
        bumpers=0,
        battery_voltage=battery.value.voltage if battery is not None else math.nan,
        battery_fraction=battery.value.percentage if battery is not None else math.nan,
        sway=left,
        heave=up,
        motion=MotionState.MOVING if moves else MotionState.STANDING,
        refused=0,
    )
    return ShownMessage(value=state, stamp=stamp)


def path_ahead(value: RosValue, frames: FrameTree, fixed: str) -> NavigationStatus:
    """A nav_msgs/Path as the task to follow it."""
    moved = frames.place(str(value.get("header.frame_id")), fixed) or HERE
    points = messages.path_points(value, moved)
    places = np.array([(each.x, each.y) for each in points]).reshape(-1, 2)
    steps = np.diff(places, axis=0)
    return NavigationStatus(
        number=1,
        task=Task.GOING if points else Task.NONE,
        sender=0,
        driver=0,
        points_left=min(1, len(points)),
        distance_left=float(np.hypot(steps[:, 0], steps[:, 1]).sum()),
        why="",
        path=points,
        x=points[-1].x if points else math.nan,
        y=points[-1].y if points else math.nan,
    )


def _place(
    values: TopicValues, frames: FrameTree, odometry: ShownMessage | None, fixed: str
) -> tuple[FramePlace | None, int]:
    """The pose of the robot, None: it is not known; and when it was logged [ns], or -1."""
    newest = [
        values.newest[each.channel].stamp
        for each in values.of_role(RosRole.FRAMES)
        if each.channel in values.newest
    ]
    place = frames.place(base_frame(values, frames), fixed) if fixed else None
    if place is not None and newest:
        return place, max(newest)
    posed = values.first(_posed, RosRole.POSE, RosRole.POSE_WITH_ERROR)
    if posed is not None:
        return posed.value, posed.stamp
    if odometry is None:
        return None, -1
    try:
        reckoned = pose_of(odometry.value.get("pose.pose"))
    except RosMessageError:
        return None, odometry.stamp
    outer = frames.place(str(odometry.value.get("header.frame_id")), fixed) if fixed else None
    return reckoned.after(outer or HERE), odometry.stamp


def _posed(value: RosValue) -> FramePlace:
    inner = value.get("pose")
    return pose_of(inner.get("pose") if inner.field("pose") is not None else inner)


def _command(values: TopicValues) -> tuple[tuple[float, float], int]:
    """The commanded velocity [m/s, rad/s], and when it was logged [ns]; -1: none counts."""
    now = max((each.stamp for each in values.newest.values()), default=0)
    for found in values.all_shown(_commanded, RosRole.COMMAND, RosRole.COMMAND_STAMPED):
        if now - found.stamp < _SILENT_NS:
            return found.value, found.stamp
    return (0.0, 0.0), -1


def _commanded(value: RosValue) -> tuple[float, float]:
    twist = value.field("twist")
    forward, _, _, turning = messages.planar(value if twist is None else twist)
    return forward, turning
