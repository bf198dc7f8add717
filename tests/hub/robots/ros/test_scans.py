"""Scans of any layout in the beams that a robot file describes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.errors import RosMessageError
from hub.gcm.body import RangeGroup, RangeKind
from hub.robots.ros.scans import RosRanges
from hub.ros.values import NamedValue


def group(beams=1, first=0.0, step=0.0, opening=0.0, farthest=12.0, nearest=0.0):
    return RangeGroup(
        name="lidar",
        kind=RangeKind.LASER,
        beams=beams,
        first=first,
        step=step,
        opening=opening,
        nearest=nearest,
        farthest=farthest,
    )


def scan(ranges, first=-math.pi, step=None, far=20.0):
    ranges = np.asarray(ranges, np.float32)
    return NamedValue(
        "sensor_msgs/msg/LaserScan",
        {
            "header": {"stamp": {"sec": 1, "nanosec": 0}, "frame_id": "laser"},
            "angle_min": first,
            "angle_increment": step if step is not None else math.tau / len(ranges),
            "range_min": 0.1,
            "range_max": far,
            "ranges": ranges,
        },
    )


def read(described, *values):
    ranges = RosRanges(described)
    for value in values:
        ranges.take(value, 7.0, 1000.0)
    return ranges.scan.ranges


def test_a_scan_in_its_own_layout_is_taken_as_it_is():
    given_ranges = np.linspace(1.0, 5.0, 360, dtype=np.float32)
    described = group(360, -math.pi, math.tau / 360)
    assert read(described, scan(given_ranges)) == pytest.approx(given_ranges)


def test_of_finer_beams_the_nearest_counts():
    ranges = np.full(720, np.inf, np.float32)
    ranges[360 + 3], ranges[360 + 4] = 2.0, 3.0  # 1.5 and 2 degrees to the left
    found = read(group(8, -math.pi, math.tau / 8), scan(ranges))
    assert found[4] == 2.0
    assert all(math.isinf(each) for place, each in enumerate(found) if place != 4)


def test_coarser_beams_fill_those_around_them():
    found = read(group(72, -math.pi, math.tau / 72), scan(np.arange(1.0, 9.0)))
    assert found[36] == 5.0
    assert {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0} == set(found.tolist())


def test_beams_without_a_measurement_are_not_measured():
    found = read(group(8, -math.pi, math.tau / 8), scan([4.0, 4.0, 4.0], -0.4, 0.4))
    assert found[4] == 4.0
    assert math.isnan(found[0])


def test_a_scan_upside_down_turns_the_other_way():
    ranges = np.full(360, np.inf, np.float32)
    ranges[90] = 2.0
    found = read(group(360, math.pi, -math.tau / 360), scan(ranges))
    assert found[(360 - 90) % 360] == 2.0


def test_what_is_farther_than_the_sensor_reaches_is_nothing_and_zero_is_not_measured():
    found = read(group(4, -math.pi, math.tau / 4), scan([15.0, 0.0, 3.0, math.nan]))
    assert math.isinf(found[0])
    assert math.isnan(found[1])
    assert found[2] == 3.0
    assert math.isnan(found[3])


def test_another_layout_is_placed_again():
    described = group(4, -math.pi, math.tau / 4)
    assert read(described, scan([1.0] * 8), scan([2.0] * 4)) == pytest.approx([2.0] * 4)


def test_a_single_range_is_that_of_a_sonar():
    value = NamedValue(
        "sensor_msgs/msg/Range",
        {
            "header": {"stamp": {"sec": 1, "nanosec": 0}, "frame_id": "sonar"},
            "radiation_type": 0,
            "field_of_view": 0.4,
            "min_range": 0.1,
            "max_range": 4.0,
            "range": 1.5,
        },
    )
    assert read(group(opening=0.4), value) == pytest.approx([1.5])


@pytest.mark.parametrize(
    ("said", "ranges"),
    [
        ([-math.inf, 0.3, 0.44, 0.45, 2.0], [0.45, 0.45, 0.45, 0.45, 2.0]),
        ([0.0, -1.0, math.nan, math.inf, 13.0], [math.nan, math.nan, math.nan, math.inf, math.inf]),
    ],
)
def test_what_each_value_of_a_scan_means(said, ranges):
    described = group(5, -0.4, 0.2, nearest=0.45)
    assert read(described, scan(said, -0.4, 0.2)) == pytest.approx(ranges, nan_ok=True)


def test_the_least_range_of_the_robot_file_decides():
    seen = scan([-math.inf, 0.02, 0.07, 2.0], -0.4, 0.2)
    assert read(group(4, -0.4, 0.2, nearest=0.05), seen) == pytest.approx([0.05, 0.05, 0.07, 2.0])
    assert read(group(4, -0.4, 0.2), seen)[0] == pytest.approx(0.001), "0 is not measured"


@pytest.mark.parametrize(
    ("said", "means"), [(-math.inf, 0.1), (0.1, 0.1), (0.05, 0.1), (math.inf, math.inf)]
)
def test_a_range_sensor_with_a_fixed_distance_finds_something_or_nothing(said, means):
    value = NamedValue(
        "sensor_msgs/msg/Range",
        {
            "header": {"stamp": {"sec": 1, "nanosec": 0}, "frame_id": "cliff"},
            "radiation_type": 1,
            "field_of_view": 0.1,
            "min_range": 0.1,
            "max_range": 0.1,
            "range": said,
        },
    )
    found = read(group(opening=0.1, nearest=0.1, farthest=0.1), value)
    assert found == pytest.approx([means])


@pytest.mark.parametrize("far", [0.0, -1.0, 0.05, math.nan])
def test_a_scan_without_a_largest_range_is_refused(far):
    with pytest.raises(RosMessageError):
        read(group(4, -0.4, 0.2, nearest=0.1), scan([1.0, 2.0, 3.0, 4.0], -0.4, 0.2, far=far))


def test_other_messages_are_refused():
    with pytest.raises(RosMessageError, match="PointCloud2"):
        RosRanges(group()).take(NamedValue("sensor_msgs/msg/PointCloud2", {}), 7.0, 1000.0)


@given(
    st.integers(1, 400),
    st.integers(1, 400),
    st.floats(-10.0, 10.0),
    st.floats(-0.5, 0.5).filter(lambda step: abs(step) > 1e-4),
)
@settings(max_examples=100)
def test_each_range_in_a_group_is_one_that_was_measured(beams, count, first, step):
    measured = np.linspace(1.0, 9.0, count, dtype=np.float32)
    found = read(group(beams, -math.pi, math.tau / beams), scan(measured, first, step))
    assert found.shape == (beams,)
    assert set(found[~np.isnan(found)].tolist()) <= set(measured.tolist())
