"""A robot's places: how old they are, and whether its dead reckoning goes on."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.errors import RosMessageError
from hub.pose import Pose
from hub.robots.ros.odometry import (
    FRESH_S,
    RosOdometry,
    RosPlace,
    odometry_fault,
    place_of_odometry,
)
from hub.robots.ros.reckoning_file import ReckoningFile
from hub.ros.values import NamedValue

DAY = 86400.0


def place(x=0.0, theta=0.0, measured=100.0, clock=0.0):
    """A place at a monotonic time, of a robot whose clock differs."""
    return RosPlace(pose=Pose(x=x, theta=theta), measured=measured, stamp=measured + clock)


def message(x=1.0, y=2.0, w=1.0, speed=0.0):
    vector = {"x": 0.0, "y": 0.0, "z": 0.0}
    return NamedValue(
        "nav_msgs/msg/Odometry",
        {
            "header": {"stamp": {"sec": 5, "nanosec": 250_000_000}},
            "pose": {
                "pose": {
                    "position": {"x": x, "y": y, "z": 0.5},
                    "orientation": {"x": 0.0, "y": 0.0, "z": w, "w": w},
                }
            },
            "twist": {"twist": {"linear": vector | {"x": speed}, "angular": vector}},
        },
    )


def test_a_place_has_the_heading_of_its_quaternion_and_the_velocity_of_the_base():
    found = place_of_odometry(message(w=math.sqrt(0.5), speed=0.3), 7.0)
    assert found.pose == Pose(x=1.0, y=2.0, theta=pytest.approx(math.pi / 2))
    assert (found.z, found.velocity.linear.x, found.stamp) == (0.5, 0.3, 5.25)
    assert found.measured == 7.0


@pytest.mark.parametrize(
    "wrong", [{"w": 0.0}, {"w": math.nan}, {"x": math.nan}, {"y": math.inf}, {"x": 1e9}]
)
def test_a_place_that_makes_no_sense_is_refused(wrong):
    with pytest.raises(RosMessageError):
        place_of_odometry(message(**wrong), 7.0)


def test_a_velocity_that_is_no_number_is_not_zero():
    with pytest.raises(RosMessageError, match="velocity"):
        place_of_odometry(message(speed=math.nan), 7.0)
    assert "velocity" in odometry_fault(message(speed=math.nan))
    assert "orientation" in odometry_fault(message(w=0.0))
    assert odometry_fault(message()) == ""
    assert place_of_odometry(message(speed=1e9), 7.0).velocity.linear.x == 100.0


def test_a_place_is_known_for_half_a_second():
    odometry = RosOdometry(0.5, 1.0)
    assert not odometry.fresh(100.0)
    odometry.take(place(measured=100.0), 1)
    assert odometry.fresh(100.0 + FRESH_S - 0.01)
    assert not odometry.fresh(100.0 + FRESH_S)


def test_the_reckoning_goes_on_with_the_clock_of_the_robot_a_day_off_or_set():
    odometry = RosOdometry(0.5, 1.0)
    odometry.take(place(clock=-DAY), 1)
    number = odometry.number
    assert number
    odometry.take(place(x=0.1, measured=100.1, clock=-DAY), 1)
    odometry.take(place(x=0.1, measured=100.2, clock=3.0), 1)
    assert odometry.number == number
    assert odometry.fresh(100.3)


def test_a_jump_or_another_robot_behind_the_same_address_is_another_reckoning():
    odometry = RosOdometry(0.5, 1.0)
    odometry.take(place(x=5.0), 1)
    first = odometry.number
    odometry.take(place(x=0.0, measured=100.1), 1)
    second = odometry.number
    odometry.take(place(x=0.0, theta=2.0, measured=100.2), 1)
    third = odometry.number
    odometry.take(place(x=0.0, theta=2.0, measured=100.3, clock=DAY), 2)
    assert len({first, second, third, odometry.number}) == 4


def test_a_new_connection_to_the_same_robot_keeps_the_reckoning():
    odometry = RosOdometry(0.5, 1.0)
    odometry.take(place(x=5.0, clock=-DAY), 1)
    number = odometry.number
    odometry.take(place(x=5.8, measured=133.0, clock=-DAY + 0.2), 2)
    assert odometry.number == number


def test_a_reckoning_that_began_again_near_its_origin_is_another_one():
    odometry = RosOdometry(0.5, 1.0)
    odometry.take(place(x=0.3), 1)
    number = odometry.number
    odometry.take(place(x=0.25, measured=100.1), 1)
    assert odometry.number == number
    odometry.take(place(x=0.0, measured=130.0), 2)
    assert odometry.number != number


def test_the_next_process_goes_on_with_the_reckoning_where_the_robot_still_is():
    before = RosOdometry(0.5, 1.0)
    before.take(place(x=5.0, clock=DAY), 1)
    after = RosOdometry(0.5, 1.0, before.kept)
    after.take(place(x=5.1, measured=102.0, clock=DAY), 1)
    assert after.number == before.number
    elsewhere = RosOdometry(0.5, 1.0, before.kept)
    elsewhere.take(place(x=0.0, measured=102.0, clock=DAY), 1)
    assert elsewhere.number != before.number


def test_the_file_of_a_reckoning_keeps_it_and_no_other_content_is_taken(tmp_path):
    file = ReckoningFile(tmp_path / "kept")
    assert file.read() is None
    odometry = RosOdometry(0.5, 1.0)
    odometry.take(place(x=5.0, clock=DAY), 1)
    file.save(odometry.kept, 100.0)
    assert ReckoningFile(tmp_path / "kept").read() == odometry.kept
    for wrong in ("", "[]", "[1, 2]", '["a", 0, 0, 0, 0, 0]', "[1, 0, 0, NaN, 0, 0]", "[" * 900):
        (tmp_path / "kept").write_text(wrong)
        assert file.read() is None


@given(st.lists(st.tuples(st.floats(-0.02, 0.02), st.floats(0.001, 0.2)), max_size=30))
@settings(max_examples=100)
def test_a_robot_within_its_limits_never_loses_its_place(steps):
    odometry, x, now = RosOdometry(0.5, 1.0), 0.0, 100.0
    odometry.take(place(), 1)
    number = odometry.number
    for way, seconds in steps:
        x, now = x + way, now + seconds
        odometry.take(place(x=x, measured=now), 1)
    assert odometry.number == number
