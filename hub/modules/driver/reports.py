"""The messages of the driver from what a body measures; pure."""

from __future__ import annotations

import dataclasses
import math

from hub.gcm.battery import BatteryState
from hub.gcm.diagnostics import Diagnostics
from hub.gcm.environment import Environment
from hub.gcm.flight import Altitude, FluidPressure
from hub.gcm.geometry import (
    Point3D,
    Pose3D,
    PoseWithCovariance,
    Quaternion,
    TwistWithCovariance,
)
from hub.gcm.imu import Imu
from hub.gcm.joints import JointStates
from hub.gcm.navigation import DriveState
from hub.gcm.odometry import Odometry
from hub.gcm.standard import BASE_LINK, ODOM, Header, Time
from hub.gcm.vehicle import Arming, VehicleState
from hub.modules.driver.problems import problems
from hub.robots.interfaces import Sensors

_SLOW = 0.05
"""Speeds below this need fewer reports [m/s or rad/s]."""


def drive_state(sensors: Sensors, stamp: float, reckoning: int = 0) -> DriveState:
    """The state of the base.

    Args:
        sensors: The measurements.
        stamp: Their time [s since the epoch].
        reckoning: Number of the dead reckoning, if the body gives it none.
    """
    roll, pitch = (
        angle if math.isfinite(angle) else 0.0 for angle in (sensors.roll, sensors.pitch)
    )
    yaw = sensors.theta if math.isfinite(sensors.theta) else math.nan  # receivers refuse NaN
    pose = Pose3D(
        position=Point3D(x=sensors.x, y=sensors.y, z=sensors.z),
        orientation=Quaternion.of(roll, pitch, yaw),
    )
    return DriveState(
        odometry=Odometry(
            header=Header(stamp=Time.of(stamp), frame_id=ODOM),
            pose=PoseWithCovariance(pose=pose),
            twist=TwistWithCovariance(twist=sensors.velocity),
        ),
        commanded=sensors.commanded,
        bumpers=sensors.bumpers,
        reckoning=sensors.reckoning or reckoning,
        origin=sensors.origin,
    )


def battery(sensors: Sensors, stamp: float) -> BatteryState | None:
    """The battery; None: the body does not measure it."""
    if sensors.battery is not None:
        return dataclasses.replace(sensors.battery, header=Header(stamp=Time.of(stamp)))
    if math.isnan(sensors.battery_voltage) and math.isnan(sensors.battery_fraction):
        return None
    return BatteryState(
        header=Header(stamp=Time.of(stamp)),
        voltage=sensors.battery_voltage,
        percentage=sensors.battery_fraction,
    )


def imu(sensors: Sensors, stamp: float) -> Imu | None:
    """Tilt, heading, turn rates and acceleration; None: the body measures none of them."""
    header = Header(stamp=Time.of(stamp), frame_id=BASE_LINK)
    if sensors.imu is not None:
        return dataclasses.replace(sensors.imu, header=header)
    tilts = not (math.isnan(sensors.roll) or math.isnan(sensors.pitch))
    if not tilts and sensors.turning is None and sensors.acceleration is None:
        return None
    return Imu.of(
        header,
        roll=sensors.roll,
        pitch=sensors.pitch,
        heading=sensors.heading,
        turning=sensors.turning,
        acceleration=sensors.acceleration,
    )


def fluid_pressure(sensors: Sensors, stamp: float) -> FluidPressure | None:
    """The pressure around the body; None: it does not measure it."""
    if math.isnan(sensors.pressure):
        return None
    header = Header(stamp=Time.of(stamp), frame_id=BASE_LINK)
    return FluidPressure(header=header, fluid_pressure=sensors.pressure)


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


def environment(sensors: Sensors, stamp: float) -> Environment | None:
    """The air around the robot; None: the body measures nothing of it."""
    if math.isnan(sensors.sound) and math.isnan(sensors.co2):
        return None
    return Environment(stamp=stamp, sound=sensors.sound, co2=sensors.co2)


def vehicle(sensors: Sensors, stamp: float) -> VehicleState:
    """What the body does besides its motion."""
    state = sensors.vehicle
    activity = state.activity or ("stands" if stands(sensors) else "drives")
    if state.arming is Arming.DISARMED:
        activity = "disarmed"
    return dataclasses.replace(state, stamp=stamp, activity=activity)


def change_of(state: VehicleState) -> tuple[object, ...]:
    """What counts as a change of this state; targets and errors always differ a little."""
    phases = tuple(hold.phase for hold in state.holds)
    return state.activity, state.arming, phases, state.lights


def joints(sensors: Sensors, stamp: float) -> JointStates:
    """The joints."""
    return JointStates.of(sensors.joints, Header(stamp=Time.of(stamp)))


def diagnostics(sensors: Sensors, stamp: float) -> Diagnostics:
    """What is wrong with the body now."""
    return Diagnostics(header=Header(stamp=Time.of(stamp)), status=tuple(problems(sensors)))


def rests(sensors: Sensors) -> bool:
    """Whether the body has no order to move and moves too slowly to be reported often.

    A body that flies or dives never stands: air and water carry it while it holds.
    """
    linear, angular = sensors.velocity.linear, sensors.velocity.angular
    speeds = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    slow = all(abs(speed) < _SLOW for speed in speeds)
    return slow and sensors.commanded.neutral and not sensors.bumpers


def stands(sensors: Sensors) -> bool:
    """Whether the body stands, touches nothing, and has no order to move."""
    return sensors.velocity.neutral and sensors.commanded.neutral and not sensors.bumpers
