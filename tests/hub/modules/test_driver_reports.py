"""The driver's messages from what a body measures."""

from __future__ import annotations

import dataclasses
import math

from hub.gcm.geometry import Twist, Vector3
from hub.modules.driver.reports import altitude, attitude, drive_state, stands
from hub.robots.interfaces import Sensors

NOTHING = Sensors()


def test_a_body_that_measures_nothing_has_a_state() -> None:
    state = drive_state(NOTHING, 5.0, odometry=7)
    assert (state.stamp, state.odometry, state.bumpers) == (5.0, 7, 0)
    assert math.isnan(state.battery_voltage)
    assert attitude(NOTHING, 5.0) is None
    assert altitude(NOTHING, 5.0) is None


def test_a_body_numbers_its_own_dead_reckoning() -> None:
    assert drive_state(dataclasses.replace(NOTHING, odometry=3), 5.0, odometry=7).odometry == 3


def test_tilt_and_height_are_reported_where_they_are_measured() -> None:
    sensors = dataclasses.replace(NOTHING, roll=0.1, pitch=-0.2, depth=3.0, climb=-0.5)
    tilt, height = attitude(sensors, 5.0), altitude(sensors, 5.0)
    assert tilt is not None
    assert (tilt.roll, tilt.pitch) == (0.1, -0.2)
    assert math.isnan(tilt.yaw)
    assert height is not None
    assert (height.depth, height.climb) == (3.0, -0.5)
    assert math.isnan(height.above_ground)


def test_a_body_stands_only_without_any_motion_order_or_contact() -> None:
    sideways = Twist(linear=Vector3(y=0.1))
    assert stands(NOTHING)
    assert not stands(dataclasses.replace(NOTHING, velocity=sideways))
    assert not stands(dataclasses.replace(NOTHING, commanded=sideways))
    assert not stands(dataclasses.replace(NOTHING, bumpers=1))
