"""The message of tilt, heading and turn rates, sensor_msgs/Imu, field for field."""

from __future__ import annotations

import math
from dataclasses import field
from typing import Annotated, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from hub.gcm.geometry import AnyNumber, Quaternion, Vector3
from hub.gcm.orientation import Angles
from hub.gcm.standard import BASE_LINK, Header
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Range
from hub.ipc.formats.wire_types import Fixed
from hub.values import dataclass

Covariance9: TypeAlias = Annotated[AnyNumber, Fixed(9)]
"""Of three numbers, row by row; all 0: not known; -1 first: the numbers are not measured."""

_Part: TypeAlias = Annotated[float, Range(-1e5, 1e5, unit="m/s^2")]
_IN_BASE: Final = Header(frame_id=BASE_LINK)
_NO_HEADING: Final = 1e6
"""Variance of a heading that is not measured [rad^2]."""


def _covariance(first: float, last: float = 0.0) -> npt.NDArray[np.float64]:
    made = np.zeros(9)
    made[0], made[8] = first, last
    made.flags.writeable = False
    return made


_MEASURED: Final = _covariance(0.0)
_NOT_MEASURED: Final = _covariance(-1.0)
_TILT_MEASURED: Final = _covariance(0.0, _NO_HEADING)


def _not_measured() -> npt.NDArray[np.float64]:
    return _NOT_MEASURED


@dataclass(frozen=True, slots=True, kw_only=True)
class Acceleration:
    """geometry_msgs/Vector3.

    Attributes:
        x: Along x [m/s^2].
        y: Along y [m/s^2].
        z: Along z [m/s^2].
    """

    ros_type = "geometry_msgs/msg/Vector3"

    x: _Part = 0.0
    y: _Part = 0.0
    z: _Part = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Imu:
    """sensor_msgs/Imu, in the frame `base_link`.

    Of a covariance the first number is -1 where the robot does not measure the quantity. The last
    one of the orientation is at least 1e6 where it measures the tilt and no heading.

    Attributes:
        header: When it was measured, and the frame.
        orientation: The rotation from `map` to `base_link`; of a robot with ROS, from the world of
            its own IMU.
        orientation_covariance: About x, y and z [rad^2], shape (9,).
        angular_velocity: Turn rates about x, y and z [rad/s].
        angular_velocity_covariance: [rad^2/s^2], shape (9,).
        linear_acceleration: With gravity: a robot that stands level measures +9.81 along z.
        linear_acceleration_covariance: [m^2/s^4], shape (9,).
    """

    ros_type = "sensor_msgs/msg/Imu"

    header: Header = _IN_BASE
    orientation: Quaternion = Quaternion()
    orientation_covariance: Covariance9 = field(default_factory=_not_measured)
    angular_velocity: Vector3 = Vector3()
    angular_velocity_covariance: Covariance9 = field(default_factory=_not_measured)
    linear_acceleration: Acceleration = Acceleration()
    linear_acceleration_covariance: Covariance9 = field(default_factory=_not_measured)

    @classmethod
    def of(
        cls,
        header: Header = _IN_BASE,
        *,
        roll: float = math.nan,
        pitch: float = math.nan,
        heading: float = math.nan,
        turning: Vector3 | None = None,
        acceleration: Acceleration | None = None,
    ) -> Imu:
        """The message of what is measured: angles [rad], NaN: not measured; None: not measured.

        A heading without roll and pitch is left out.
        """
        orientation, accuracy = Quaternion(), _NOT_MEASURED
        if math.isfinite(roll) and math.isfinite(pitch):
            heads = math.isfinite(heading)
            orientation = Quaternion.of(roll, pitch, heading if heads else 0.0)
            accuracy = _MEASURED if heads else _TILT_MEASURED
        return cls(
            header=header,
            orientation=orientation,
            orientation_covariance=accuracy,
            angular_velocity=turning or Vector3(),
            angular_velocity_covariance=_NOT_MEASURED if turning is None else _MEASURED,
            linear_acceleration=acceleration or Acceleration(),
            linear_acceleration_covariance=_NOT_MEASURED if acceleration is None else _MEASURED,
        )

    @property
    def roll_pitch_yaw(self) -> Angles:
        """Roll, pitch and heading [rad]; NaN: not measured."""
        if not self.orientation_covariance[0] >= 0.0:
            return math.nan, math.nan, math.nan
        roll, pitch, heading = self.orientation.roll_pitch_yaw
        return roll, pitch, heading if self.orientation_covariance[8] < _NO_HEADING else math.nan


IMU = MessageDefinition(name="GCM_Imu", type=Imu, rate_hz=20.0)

MESSAGES = (IMU,)
