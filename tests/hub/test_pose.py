"""Angles and poses in the plane."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hub.pose import Pose, each_wrapped, wrapped

PLACES = st.floats(-100.0, 100.0)
POSES = st.builds(Pose, x=PLACES, y=PLACES, theta=st.floats(-math.pi, math.pi))


@given(angle=st.floats(-1e6, 1e6))
@example(math.pi)
@example(-math.pi)
@example(math.nextafter(math.pi, 4.0))
def test_wrapped_angles_are_the_same_direction_within_one_turn(angle: float) -> None:
    around = wrapped(angle)
    assert -math.pi < around <= math.pi
    assert math.cos(around - angle) == pytest.approx(1.0)


@given(st.lists(st.floats(-100.0, 100.0), min_size=1))
def test_many_angles_are_wrapped_as_one_is(angles: list[float]) -> None:
    differences = each_wrapped(np.array(angles)) - [wrapped(angle) for angle in angles]
    assert np.cos(differences) == pytest.approx(1.0)
    assert abs(each_wrapped(np.array(angles))).max() <= math.pi + 1e-9


def test_a_point_ahead_of_a_pose_lies_where_it_looks() -> None:
    looking_left = Pose(x=1.0, y=2.0, theta=math.pi / 2.0)
    assert looking_left.outward(3.0, 0.5) == pytest.approx((0.5, 5.0))
    assert looking_left.inward(0.5, 5.0) == pytest.approx((3.0, 0.5))


@given(POSES, PLACES, PLACES)
def test_points_lead_out_and_back_one_by_one_and_together(pose: Pose, x: float, y: float) -> None:
    assert pose.inward(*pose.outward(x, y)) == pytest.approx((x, y), abs=1e-9)
    together = pose.outward(np.array([x, 0.0]), np.array([y, 0.0]))
    assert [part[0] for part in together] == pytest.approx(pose.outward(x, y))
    assert [part[1] for part in together] == pytest.approx((pose.x, pose.y))


@given(POSES, POSES)
def test_a_pose_seen_from_another_leads_back_to_it(pose: Pose, other: Pose) -> None:
    again = other.then(pose.seen_from(other))
    assert (again.x, again.y) == pytest.approx((pose.x, pose.y), abs=1e-9)
    assert math.cos(again.theta - pose.theta) == pytest.approx(1.0)
