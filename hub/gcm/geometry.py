"""Types of geometry_msgs, field for field."""

from __future__ import annotations

import math
from dataclasses import field
from typing import Annotated, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from hub.gcm import orientation
from hub.gcm.fields import Metres
from hub.gcm.standard import BASE_LINK, Header
from hub.ipc.formats.ranges import Range
from hub.ipc.formats.wire_types import Fixed
from hub.values import dataclass

Axis: TypeAlias = Annotated[float, Range(-100.0, 100.0, unit="m/s or rad/s")]
"""A velocity along or about one axis [m/s or rad/s]."""
UnitPart: TypeAlias = Annotated[float, Range(-1.001, 1.001)]
"""A part of a unit quaternion, with rounding errors."""
AnyNumber: TypeAlias = Annotated[
    npt.NDArray[np.float64], Range(-math.inf, math.inf, nan=True, infinite=True)
]
Covariance36: TypeAlias = Annotated[AnyNumber, Fixed(36)]

COVARIANCE_NOT_KNOWN: Final = np.zeros(36)
"""Covariances that are not known, as ROS has them; shape (36,)."""
COVARIANCE_NOT_KNOWN.flags.writeable = False


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
        linear, angular = self.linear, self.angular
        moves = linear.x or linear.y or linear.z or angular.x or angular.y or angular.z
        return not moves


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Point3D:
    """geometry_msgs/Point.

    Attributes:
        x: Along x of its frame [m].
        y: Along y [m].
        z: Along z [m].
    """

    ros_type = "geometry_msgs/msg/Point"

    x: Metres = 0.0
    y: Metres = 0.0
    z: Metres = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Quaternion:
    """geometry_msgs/Quaternion: an orientation; `hub.gcm.orientation` says its sense.

    Attributes:
        x: First imaginary part.
        y: Second imaginary part.
        z: Third imaginary part.
        w: Real part.
    """

    ros_type = "geometry_msgs/msg/Quaternion"

    x: UnitPart = 0.0
    y: UnitPart = 0.0
    z: UnitPart = 0.0
    w: UnitPart = 1.0

    @classmethod
    def of(cls, roll: float, pitch: float, yaw: float) -> Quaternion:
        """The orientation with these angles [rad]."""
        w, x, y, z = orientation.quaternion(roll, pitch, yaw)
        return cls(x=x, y=y, z=z, w=w)

    @property
    def roll_pitch_yaw(self) -> orientation.Angles:
        """Its angles [rad]."""
        return orientation.roll_pitch_yaw(self.w, self.x, self.y, self.z)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose3D:
    """geometry_msgs/Pose.

    Attributes:
        position: Its place.
        orientation: Of its axes.
    """

    ros_type = "geometry_msgs/msg/Pose"

    position: Point3D = Point3D()
    orientation: Quaternion = Quaternion()


def _not_known() -> npt.NDArray[np.float64]:
    return COVARIANCE_NOT_KNOWN


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PoseWithCovariance:
    """geometry_msgs/PoseWithCovariance.

    Attributes:
        pose: The pose.
        covariance: Of x, y, z [m], and the rotations about x, y and z [rad], row by row, shape
            (36,); all 0: not known.
    """

    ros_type = "geometry_msgs/msg/PoseWithCovariance"

    pose: Pose3D = Pose3D()
    covariance: Covariance36 = field(default_factory=_not_known)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TwistWithCovariance:
    """geometry_msgs/TwistWithCovariance.

    Attributes:
        twist: The velocity.
        covariance: Of the linear velocities [m/s] and the angular ones [rad/s], row by row, shape
            (36,); all 0: not known.
    """

    ros_type = "geometry_msgs/msg/TwistWithCovariance"

    twist: Twist = Twist()
    covariance: Covariance36 = field(default_factory=_not_known)
