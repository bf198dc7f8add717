"""The newest ranges of a robot around its body."""

from __future__ import annotations

import math

import pytest

from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.ranges import RANGES, RangeReadings
from rune_tui.model.robot_ranges import RobotRanges, lack_of_ranges, ranges_of
from rune_tui.model.robot_state import LinkPhase, LinkState, Received, RobotState
from tests.console.states import ranges_around
from tests.support.car import CAR, car_readings, laser_of


def robot(**messages: object) -> RobotState:
    link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
    known = {
        name: Received(value=value, measured=0.0, number=1) for name, value in messages.items()
    }
    return RobotState(name="robot", link=link, messages=known)


def nearest(ranges: RobotRanges) -> tuple[float, float]:
    """Room [m] and bearing [deg] of the nearest obstacle."""
    number = ranges.nearest
    assert number is not None
    return float(ranges.room[number]), math.degrees(ranges.bearing(number))


def test_room_is_counted_from_the_footprint_wherever_the_sensor_is() -> None:
    ahead, bearing = nearest(ranges_around(CAR, car_readings(laser=laser_of(l0=0.7))))
    assert (ahead, bearing) == pytest.approx((0.5, 0.0), abs=1e-6)
    beside, bearing = nearest(ranges_around(CAR, car_readings(laser=laser_of(l90=0.7))))
    assert beside == pytest.approx(0.4)
    assert bearing == pytest.approx(math.degrees(math.atan2(0.7, 0.4)))
    right, bearing = nearest(ranges_around(CAR, car_readings(side=0.25)))
    assert right == pytest.approx(0.25)
    assert bearing == pytest.approx(math.degrees(math.atan2(-0.55, -0.2)))


def test_the_nearest_is_that_with_least_room_not_that_with_the_least_range() -> None:
    ranges = ranges_around(CAR, car_readings(laser=laser_of(l0=0.6), side=0.45))
    assert nearest(ranges)[0] == pytest.approx(0.4)
    assert nearest(ranges)[1] == pytest.approx(0.0, abs=1e-6)


def test_what_is_nearer_than_a_sensor_can_measure_leaves_no_room() -> None:
    ranges = ranges_around(CAR, car_readings(laser=laser_of(l90=-math.inf), side=0.25))
    assert nearest(ranges)[0] == 0.0
    assert math.isfinite(ranges.ranges[ranges.nearest or 0])


def test_a_beam_that_looks_down_finds_no_obstacle() -> None:
    assert ranges_around(CAR, car_readings(down=0.05)).nearest is None


def test_neighbours_close_together_are_a_scan_and_others_are_not() -> None:
    of = ranges_around(CAR, car_readings()).of
    assert of.scans == (slice(0, 360),)
    assert of.wide.nonzero()[0].tolist() == [360]
    assert of.half[0] == pytest.approx(math.radians(0.5))
    assert of.half[360] == pytest.approx(math.radians(15.0))


def test_what_is_missing_is_said_in_words() -> None:
    body, readings = {ROBOT_DESCRIPTION.name: CAR}, {RANGES.name: car_readings()}
    bare = RobotBody(name="bare", kind="k", radius=0.2)
    assert lack_of_ranges(robot()) == "no ranges from robot yet"
    assert lack_of_ranges(robot(**body)) == "no ranges from car yet"
    assert lack_of_ranges(robot(**readings)) == "no description of robot yet"
    assert lack_of_ranges(robot(**body, **readings)) == ""
    assert lack_of_ranges(robot(**{ROBOT_DESCRIPTION.name: bare})) == ""
    for each in (robot(), robot(**body), robot(**readings)):
        assert ranges_of(each) is None


def test_a_body_without_range_sensors_has_no_nearest_obstacle() -> None:
    bare = RobotBody(name="bare", kind="k", radius=0.2)
    assert ranges_around(bare, RangeReadings(scans=())).nearest is None


def test_they_are_computed_once_for_each_message() -> None:
    one = robot(**{ROBOT_DESCRIPTION.name: CAR, RANGES.name: car_readings()})
    other = robot(**{ROBOT_DESCRIPTION.name: CAR, RANGES.name: car_readings()})
    assert ranges_of(one) is ranges_of(one)
    assert ranges_of(one) is not ranges_of(other)
