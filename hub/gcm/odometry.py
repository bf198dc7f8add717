"""The message of dead reckoning, nav_msgs/Odometry, field for field."""

from __future__ import annotations

from hub.gcm.fields import Name
from hub.gcm.geometry import PoseWithCovariance, TwistWithCovariance
from hub.gcm.standard import BASE_LINK, ODOM, Header
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Odometry:
    """nav_msgs/Odometry: a dead-reckoned pose, and a velocity.

    Attributes:
        header: When they were measured, and the frame of the pose.
        child_frame_id: The frame whose pose it is, and in which the velocity is.
        pose: The pose.
        twist: The measured velocity.
    """

    ros_type = "nav_msgs/msg/Odometry"

    header: Header = Header(frame_id=ODOM)
    child_frame_id: Name = BASE_LINK
    pose: PoseWithCovariance = PoseWithCovariance()
    twist: TwistWithCovariance = TwistWithCovariance()
