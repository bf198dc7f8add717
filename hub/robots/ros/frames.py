"""Where a robot with ROS is by its tree of frames, tf; pure."""

from __future__ import annotations

import math
from typing import Final

from hub.gcm.fields import FARTHEST_M
from hub.gcm.geometry import Twist, Vector3
from hub.pose import Pose
from hub.robots.ros.odometry import RosPlace
from hub.robots.ros_table import RosTable
from hub.ros.frame_tree import FrameTree, plain_frame
from hub.ros.values import RosValue

STATIC_FRAMES: Final = "/tf_static"
"""The topic of frames that never move."""
_SPEED_S: Final = 0.1
"""Time over which velocities are measured [s]."""
_SLOWEST_S: Final = 1.0


class RosFrames:
    """The frames of one robot.

    Attributes:
        place: Where the base is in the frame of dead reckoning; None: the frames do not say it.
    """

    def __init__(self, table: RosTable) -> None:
        self.place: RosPlace | None = None
        self._table = table
        self._tree = FrameTree()
        self._from: tuple[Pose, float] | None = None
        self._velocity = Twist()

    def take(self, value: RosValue, measured: float) -> bool:
        """Take a tf2_msgs/TFMessage; returns whether the base has a new place [s, monotonic]."""
        self._tree.take(value)
        moved = [
            each.get("header.stamp")
            for each in value.get("transforms")
            if plain_frame(each.get("header.frame_id")) == self._table.odom_frame
        ]
        pose = self._pose(self._table.base_frame, self._table.odom_frame) if moved else None
        if pose is None:
            return False
        stamp = int(moved[0].get("sec")) + int(moved[0].get("nanosec")) * 1e-9
        self._measure(pose, measured)
        self.place = RosPlace(pose=pose, velocity=self._velocity, stamp=stamp, measured=measured)
        return True

    @property
    def odom_in_map(self) -> Pose | None:
        """The frame of dead reckoning in that of the robot's own map; None: not known."""
        return self._pose(self._table.odom_frame, self._table.map_frame)

    def _pose(self, frame: str, within: str) -> Pose | None:
        found = self._tree.place(frame, within)
        if found is None:
            return None
        x, y, theta = *(float(each) for each in found.origin[:2]), found.roll_pitch_yaw[2]
        near = all(abs(each) <= FARTHEST_M for each in (x, y, theta))
        return Pose(x=x, y=y, theta=theta) if near else None

    def _measure(self, pose: Pose, now: float) -> None:
        """Measure the velocity by two places."""
        before, at = self._from or (pose, -math.inf)
        seconds = now - at
        if seconds < _SPEED_S:
            return
        self._from = pose, now
        way = pose.seen_from(before)
        self._velocity = Twist()
        if seconds <= _SLOWEST_S:
            x, y, turn = (_limited(each / seconds) for each in (way.x, way.y, way.theta))
            self._velocity = Twist(linear=Vector3(x=x, y=y), angular=Vector3(z=turn))


def _limited(speed: float) -> float:
    return max(-100.0, min(100.0, speed))
