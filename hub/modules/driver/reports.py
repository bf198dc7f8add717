"""The messages of the driver from what a body measures; pure."""

from __future__ import annotations

import dataclasses
import math

from hub.gcm.diagnostics import Diagnostics
from hub.gcm.flight import Altitude, Attitude
from hub.gcm.joints import JointStates
from hub.gcm.navigation import DriveState
from hub.gcm.standard import Header, Time
from hub.gcm.vehicle import Arming, VehicleState
from hub.modules.driver.problems import problems
from hub.robots.interfaces import Sensors


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
        bumpers=sensors.bumpers,
        battery_voltage=sensors.battery_voltage,
        battery_fraction=sensors.battery_fraction,
        sway=sensors.velocity.linear.y,
        heave=sensors.velocity.linear.z,
        odometry=sensors.odometry or odometry,
        origin=sensors.origin,
    )


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


def stands(sensors: Sensors) -> bool:
    """Whether the body stands, touches nothing, and has no order to move."""
    return sensors.velocity.neutral and sensors.commanded.neutral and not sensors.bumpers
