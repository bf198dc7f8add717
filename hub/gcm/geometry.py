"""Types of geometry_msgs, field for field: velocities in the frame `base_link`."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from hub.gcm.standard import BASE_LINK, Header
from hub.ipc.formats.ranges import Range
from hub.values import dataclass

Axis: TypeAlias = Annotated[float, Range(-100.0, 100.0, unit="m/s or rad/s")]
"""A velocity along or about one axis [m/s or rad/s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Vector3:
    """geometry_msgs/Vector3.

    Attributes:
        x: Along x [m/s or rad/s].
        y: Along y [m/s or rad/s].
        z: Along z [m/s or rad/s].
    """

    ros_type = "geometry_msgs/msg/Vector3"

    x: Axis = 0.0
    y: Axis = 0.0
    z: Axis = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Twist:
    """geometry_msgs/Twist: a velocity in `base_link`.

    Attributes:
        linear: Linear velocity [m/s]; a wheeled base follows x only.
        angular: Angular velocity [rad/s]; a wheeled base follows z only.
    """

    ros_type = "geometry_msgs/msg/Twist"

    linear: Vector3 = Vector3()
    angular: Vector3 = Vector3()

    @classmethod
    def planar(cls, linear: float, angular: float) -> Twist:
        """The velocity of a wheeled base: forward [m/s] and counter-clockwise [rad/s]."""
        return cls(linear=Vector3(x=linear), angular=Vector3(z=angular))

    @property
    def neutral(self) -> bool:
        """Whether all velocities are 0."""
        parts = (self.linear, self.angular)
        return all(part.x == part.y == part.z == 0.0 for part in parts)


@dataclass(frozen=True, slots=True, kw_only=True)
class TwistStamped:
    """geometry_msgs/TwistStamped: a commanded velocity.

    The stamp is for records only and may be 0; the age of a command comes from the bus.

    Attributes:
        header: Its time and frame.
        twist: The velocity.
    """

    ros_type = "geometry_msgs/msg/TwistStamped"

    header: Header = Header(frame_id=BASE_LINK)
    twist: Twist = Twist()

    @classmethod
    def of(cls, twist: Twist) -> TwistStamped:
        """The command of a velocity, without a time."""
        return cls(twist=twist)

    @classmethod
    def planar(cls, linear: float, angular: float) -> TwistStamped:
        """The command of a wheeled base: forward [m/s] and counter-clockwise [rad/s]."""
        return cls(twist=Twist.planar(linear, angular))

    @property
    def neutral(self) -> bool:
        """Whether all velocities are 0."""
        return self.twist.neutral
