"""The messages of the driver from what a body measures; pure."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.flight import Altitude, Attitude
from hub.gcm.navigation import SENSOR_COUNT, DriveState
from hub.gcm.ranges import LaserScan
from hub.robots.interfaces import Sensors

_NO_SENSORS = np.full(SENSOR_COUNT, np.nan, np.float32)


def drive_state(sensors: Sensors, stamp: float, odometry: int = 0) -> DriveState:
    """The state of the base.

    Args:
        sensors: The measurements.
        stamp: Their time [s since the epoch].
        odometry: Number of the dead reckoning, if the body gives it none.
    """
    return DriveState(
        stamp=stamp,
        x=sensors.x,
        y=sensors.y,
        theta=sensors.theta,
        linear=sensors.velocity.linear.x,
        angular=sensors.velocity.angular.z,
        commanded_linear=sensors.commanded.linear.x,
        commanded_angular=sensors.commanded.angular.z,
        sonar=_sixteen(sensors.scans, "sonar"),
        infrared=_sixteen(sensors.scans, "infrared"),
        bumpers=sensors.bumpers,
        battery_voltage=sensors.battery_voltage,
        battery_fraction=sensors.battery_fraction,
        odometry=sensors.odometry or odometry,
        origin=sensors.origin,
    )


def _sixteen(scans: tuple[LaserScan, ...], name: str) -> npt.NDArray[np.float32]:
    """The ranges of a ring of sixteen, for receivers that do not take `GCM_Ranges` yet."""
    ranges = next((scan.ranges for scan in scans if scan.header.frame_id == name), _NO_SENSORS)
    return ranges if ranges.shape == _NO_SENSORS.shape else _NO_SENSORS


def attitude(sensors: Sensors, stamp: float) -> Attitude | None:
    """The tilt; None: the body does not measure it."""
    if math.isnan(sensors.roll) or math.isnan(sensors.pitch):
        return None
    return Attitude(
        stamp=stamp,
        roll=sensors.roll,
        pitch=sensors.pitch,
        yaw=math.remainder(sensors.heading, math.tau),
    )


def altitude(sensors: Sensors, stamp: float) -> Altitude | None:
    """Height and depth; None: the body measures neither."""
    if all(map(math.isnan, (sensors.height, sensors.above_ground, sensors.depth))):
        return None
    return Altitude(
        stamp=stamp,
        height=sensors.height,
        above_ground=sensors.above_ground,
        depth=sensors.depth,
        climb=sensors.climb,
    )


def stands(sensors: Sensors) -> bool:
    """Whether the body stands, touches nothing, and has no order to move."""
    return sensors.velocity.neutral and sensors.commanded.neutral and not sensors.bumpers
