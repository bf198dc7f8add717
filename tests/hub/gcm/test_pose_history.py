"""The robot's pose at the time of a measurement."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.pose_history import AHEAD_S, GAP_S, UNKNOWN, PoseHistory
from tests.support.cases import for_each
from tests.support.messages import robot_state


def test_nothing_is_known_before_the_robot_said_where_it_is() -> None:
    history = PoseHistory()
    assert history.at(1.0) is UNKNOWN
    history.add(robot_state(x=3.0), 2.0)
    assert history.at(1.9) is UNKNOWN
    assert history.at(2.0).x == 3.0


def test_between_two_poses_the_place_is_between_them() -> None:
    history = PoseHistory()
    history.add(robot_state(x=1.0, y=0.0, theta=3.0), 10.0)
    history.add(robot_state(x=2.0, y=4.0, theta=-3.0), 10.5)
    place = history.at(10.25)
    assert (place.x, place.y) == pytest.approx((1.5, 2.0))
    # From 3 to -3 rad the short way leads over pi.
    assert abs(place.theta) == pytest.approx(math.pi)


def test_after_the_newest_pose_the_robot_goes_on_as_it_did() -> None:
    history = PoseHistory()
    history.add(robot_state(x=1.0, theta=math.pi / 2, linear=0.5), 10.0)
    place = history.at(10.2)
    assert (place.x, place.y, place.theta) == pytest.approx((1.0, 0.1, math.pi / 2))
    history.add(robot_state(theta=0.1, angular=1.0), 10.3)
    assert history.at(10.4).theta == pytest.approx(0.2)


def test_what_navigation_has_not_told_for_long_is_not_known() -> None:
    history = PoseHistory()
    history.add(robot_state(), 10.0)
    assert history.at(10.0 + AHEAD_S) is not UNKNOWN
    assert history.at(10.01 + AHEAD_S) is UNKNOWN
    history.add(robot_state(), 10.0 + 2 * GAP_S)
    assert history.at(10.0 + GAP_S) is UNKNOWN


@for_each("field", ["x", "y", "theta", "linear", "angular"])
def test_what_is_not_finite_is_ignored(field: str) -> None:
    history = PoseHistory()
    history.add(robot_state(x=1.0), 10.0)
    history.add(robot_state(**{field: math.nan}), 10.1)
    history.add(robot_state(**{field: math.inf}), 10.1)
    assert history.at(10.2).x == 1.0


def test_what_comes_out_of_order_is_ignored() -> None:
    history = PoseHistory()
    history.add(robot_state(x=1.0), 10.0)
    history.add(robot_state(x=9.0), 9.9)
    assert history.at(9.95) is UNKNOWN
    assert history.at(10.0).x == 1.0


@given(times=st.lists(st.floats(0.0, 100.0), max_size=40), asked=st.floats(-1.0, 101.0))
def test_a_known_place_is_always_finite(times: list[float], asked: float) -> None:
    history = PoseHistory()
    for number, time in enumerate(times):
        history.add(robot_state(x=number, theta=number, linear=1.0, angular=3.0), time)
    place = history.at(asked)
    assert place is UNKNOWN or all(map(math.isfinite, (place.x, place.y, place.theta)))
    if place is not UNKNOWN:
        assert -math.pi < place.theta <= math.pi
