"""The driver's messages from what a body measures."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest

from hub.gcm.geometry import Point3D, Pose3D, Twist, Vector3
from hub.gcm.imu import Acceleration
from hub.gcm.standard import Header, Time
from hub.modules.driver.reports import (
    altitude,
    battery,
    drive_state,
    fluid_pressure,
    imu,
    rests,
    stands,
)
from hub.robots.interfaces import Sensors

NOTHING = Sensors()


def test_a_body_that_measures_nothing_has_a_state() -> None:
    state = drive_state(NOTHING, 5.0, reckoning=7)
    assert state.odometry.header == Header(stamp=Time(sec=5), frame_id="odom")
    assert (state.reckoning, state.bumpers) == (7, 0)
    assert state.odometry.pose.pose == Pose3D()
    assert battery(NOTHING, 5.0) is None
    assert imu(NOTHING, 5.0) is None
    assert fluid_pressure(NOTHING, 5.0) is None
    assert altitude(NOTHING, 5.0) is None


def test_a_body_numbers_its_own_dead_reckoning() -> None:
    numbered = dataclasses.replace(NOTHING, reckoning=3)
    assert drive_state(numbered, 5.0, reckoning=7).reckoning == 3


def test_pose_and_velocity_are_reported_in_space() -> None:
    moves = Twist(linear=Vector3(x=0.3, y=-0.1, z=0.2), angular=Vector3(z=0.5))
    place = {"x": 1.0, "y": 2.0, "z": -3.0, "theta": 2.5}
    tilted = dataclasses.replace(NOTHING, roll=0.1, pitch=-0.2, velocity=moves, **place)
    state = drive_state(tilted, 5.0)
    pose = state.odometry.pose.pose
    assert pose.position == Point3D(x=1.0, y=2.0, z=-3.0)
    assert pose.orientation.roll_pitch_yaw == pytest.approx((0.1, -0.2, 2.5))
    assert (state.x, state.y, state.theta) == pytest.approx((1.0, 2.0, 2.5))
    assert (state.velocity, state.linear, state.angular) == (moves, 0.3, 0.5)
    assert (state.odometry.header.frame_id, state.odometry.child_frame_id) == ("odom", "base_link")
    assert not state.odometry.pose.covariance.any()


def test_what_an_imu_does_not_measure_is_marked_as_ros_marks_it() -> None:
    gyro = Vector3(x=0.1, y=0.2, z=0.3)
    turns = imu(dataclasses.replace(NOTHING, turning=gyro), 5.0)
    assert turns is not None
    assert (turns.header.frame_id, turns.angular_velocity) == ("base_link", gyro)
    firsts = (
        turns.orientation_covariance[0],
        turns.angular_velocity_covariance[0],
        turns.linear_acceleration_covariance[0],
    )
    assert firsts == (-1.0, 0.0, -1.0)
    assert all(map(math.isnan, turns.roll_pitch_yaw))
    pushed = Acceleration(z=9.81)
    whole = dataclasses.replace(NOTHING, roll=0.1, pitch=0.2, heading=4.0, acceleration=pushed)
    felt = imu(whole, 5.0)
    assert felt is not None
    assert felt.linear_acceleration == pushed
    assert felt.roll_pitch_yaw == pytest.approx((0.1, 0.2, 4.0 - math.tau))
    assert felt.orientation_covariance.tolist() == [0.0] * 9


def test_pressure_is_reported_where_it_is_measured() -> None:
    state = fluid_pressure(dataclasses.replace(NOTHING, pressure=131000.0), 5.0)
    assert state is not None
    assert (state.fluid_pressure, state.variance) == (131000.0, 0.0)


def test_battery_is_reported_where_it_is_measured() -> None:
    state = battery(dataclasses.replace(NOTHING, battery_voltage=24.5), 5.0)
    assert state is not None
    assert state.voltage == 24.5
    assert math.isnan(state.percentage)
    assert math.isnan(state.current)


def test_tilt_and_height_are_reported_where_they_are_measured() -> None:
    sensors = dataclasses.replace(NOTHING, roll=0.1, pitch=-0.2, depth=3.0, climb=-0.5)
    tilt, height = imu(sensors, 5.0), altitude(sensors, 5.0)
    assert tilt is not None
    assert tilt.roll_pitch_yaw[:2] == pytest.approx((0.1, -0.2))
    assert math.isnan(tilt.roll_pitch_yaw[2])
    assert height is not None
    assert (height.depth, height.climb) == (3.0, -0.5)
    assert math.isnan(height.above_ground)


def test_a_body_stands_only_without_any_motion_order_or_contact() -> None:
    sideways = Twist(linear=Vector3(y=0.1))
    assert stands(NOTHING)
    assert not stands(dataclasses.replace(NOTHING, velocity=sideways))
    assert not stands(dataclasses.replace(NOTHING, commanded=sideways))
    assert not stands(dataclasses.replace(NOTHING, bumpers=1))


@pytest.mark.parametrize(
    ("changes", "quiet"),
    [
        ({}, True),
        ({"velocity": Twist(linear=Vector3(y=0.03), angular=Vector3(z=-0.03))}, True),
        ({"velocity": Twist(linear=Vector3(z=0.06))}, False),
        ({"velocity": Twist(angular=Vector3(z=math.nan))}, False),
        ({"commanded": Twist(linear=Vector3(x=0.01))}, False),
        ({"bumpers": 1}, False),
    ],
)
def test_a_body_that_only_drifts_is_reported_less_often(
    changes: dict[str, Any], *, quiet: bool
) -> None:
    assert rests(dataclasses.replace(NOTHING, **changes)) is quiet
