"""The ranges of an autopilot as groups of a robot file."""

import math

import pytest

from hub.gcm.body import RangeGroup, RangeKind
from hub.gcm.ranges import scan_of
from hub.robots.mavlink import ranges
from hub.robots.mavlink.vehicle.telemetry import Telemetry
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser

NOW = 10.0
AHEAD = RangeGroup(name="sonar", kind=RangeKind.SONAR, opening=0.4, farthest=5.0)
RING = RangeGroup(
    name="ring",
    kind=RangeKind.SONAR,
    beams=8,
    first=-math.pi,
    step=math.pi / 4,
    farthest=20.0,
)


def telemetry(name, /, **fields):
    read = Telemetry()
    (frame,) = FrameParser().feed(FramePacker(1, 1).pack(name, **fields))
    read.take(frame, NOW)
    return read


def ranges_of(group, read, now):
    return scan_of(group, ranges.ranges_of(group, read, now), 0.0).ranges


def around(distances, **fields):
    """OBSTACLE_DISTANCE of 72 sectors of 5 degrees."""
    given = {"increment": 5, "min_distance": 20, "max_distance": 1000, "frame": 12}
    return telemetry("OBSTACLE_DISTANCE", distances=tuple(distances), **(given | fields))


def test_a_sensor_ahead_fills_the_beams_that_look_ahead():
    read = telemetry("DISTANCE_SENSOR", current_distance=321, orientation=0)
    assert ranges_of(AHEAD, read, NOW) == pytest.approx([3.21])
    ring = ranges_of(RING, read, NOW)
    assert ring[4] == pytest.approx(3.21)
    assert all(math.isnan(ring[place]) for place in range(8) if place != 4)


def test_one_below_is_the_height_above_ground_and_no_range_ahead():
    read = telemetry("DISTANCE_SENSOR", current_distance=321, orientation=25)
    assert read.below == 3.21
    assert math.isnan(ranges_of(AHEAD, read, NOW)[0])


def test_old_ranges_are_none_and_far_ones_are_nothing_in_reach():
    read = telemetry("DISTANCE_SENSOR", current_distance=900, orientation=0)
    assert ranges_of(AHEAD, read, NOW + 0.9) == pytest.approx([math.inf])
    assert math.isnan(ranges_of(AHEAD, read, NOW + 1.1)[0])


def test_what_is_nearer_than_a_sensor_can_measure_is_an_obstacle():
    limits = {"min_distance": 20, "max_distance": 500, "orientation": 0}
    group = RangeGroup(name="s", kind=RangeKind.SONAR, opening=0.4, nearest=0.2, farthest=5.0)
    for said, ahead in ((19, 0.2), (0, 0.2), (20, 0.2), (300, 3.0), (501, math.inf)):
        read = telemetry("DISTANCE_SENSOR", current_distance=said, **limits)
        assert ranges_of(group, read, NOW) == pytest.approx([ahead])
        read = telemetry("DISTANCE_SENSOR", current_distance=said, **(limits | {"orientation": 25}))
        assert math.isfinite(read.below) == (20 <= said <= 500)
    invalid = telemetry("DISTANCE_SENSOR", current_distance=100, signal_quality=1, **limits)
    assert math.isnan(ranges_of(group, invalid, NOW)[0])
    for said in (0, 19):
        ring = ranges_of(RING, around([said] * 72), NOW)
        assert (ring < 0.2).all(), "0: it touches the vehicle"


def test_sectors_count_clockwise_from_ahead():
    distances = [500] * 72
    distances[0], distances[18], distances[36], distances[54] = 100, 200, 300, 400
    distances[9], distances[63] = 1001, 65535
    ring = ranges_of(RING, around(distances), NOW)
    back, left, ahead, right = ring[0], ring[6], ring[4], ring[2]
    assert (ahead, right, back, left) == pytest.approx((1.0, 2.0, 3.0, 4.0))
    assert ring[3] == math.inf  # ahead on the right
    assert math.isnan(ring[5])  # ahead on the left


def test_a_narrow_fan_leaves_the_other_directions_unknown():
    read = around([700] * 72, increment=0, increment_f=1.0, angle_offset=-30.0)
    ring = ranges_of(RING, read, NOW)
    assert ring[4] == pytest.approx(7.0)
    assert math.isnan(ring[0])
    assert math.isnan(ring[6])


def test_sectors_from_north_or_without_an_angle_are_not_taken():
    assert around([100] * 72, frame=0).obstacles is None
    assert around([100] * 72, increment=0).obstacles is None
    assert around([100] * 72, increment=0, increment_f=math.nan).obstacles is None
