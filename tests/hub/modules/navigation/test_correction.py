"""Landmarks bring the robot back to where it is."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.navigation import LandmarkCorrection
from hub.modules.navigation.correction import LARGEST_TURN, RECENT_S, PoseCorrection
from hub.pose import Pose

DRIFT = st.builds(
    Pose,
    x=st.floats(-2.0, 2.0),
    y=st.floats(-2.0, 2.0),
    theta=st.floats(-0.9 * LARGEST_TURN, 0.9 * LARGEST_TURN),
)


def seen(place: tuple[float, float], robot: Pose) -> LandmarkCorrection:
    """A landmark at a place in `map`, seen from where the robot really is."""
    x, y = robot.inward(*place)
    return LandmarkCorrection(x=place[0], y=place[1], seen_x=x, seen_y=y)


def test_map_is_odom_before_the_first_landmark() -> None:
    assert PoseCorrection().pose(1.0, 2.0, 0.5) == Pose(x=1.0, y=2.0, theta=pytest.approx(0.5))


@given(DRIFT)
def test_two_landmarks_mend_position_and_heading(drift: Pose) -> None:
    correction = PoseCorrection()
    for odom, place in ((Pose(), (2.0, 1.0)), (Pose(x=1.0, theta=1.0), (-1.0, 2.0))):
        correction.correct(seen(place, drift.then(odom)), odom, 0.0)
    odom = Pose(x=2.0, y=-1.0, theta=2.0)
    true, believed = drift.then(odom), correction.pose(odom.x, odom.y, odom.theta)
    assert (believed.x, believed.y) == pytest.approx((true.x, true.y), abs=1e-6)
    assert math.cos(believed.theta - true.theta) == pytest.approx(1.0)


def test_one_landmark_moves_and_does_not_turn() -> None:
    correction = PoseCorrection()
    correction.correct(LandmarkCorrection(x=3.0, y=1.0, seen_x=2.0, seen_y=0.0), Pose(), 0.0)
    assert correction.pose(0.0, 0.0, 0.4) == Pose(x=1.0, y=1.0, theta=pytest.approx(0.4))


@pytest.mark.parametrize(("place", "later"), [((2.0, 0.5), 1.0), ((-1.0, 2.0), RECENT_S + 1.0)])
def test_landmarks_that_are_near_to_each_other_or_long_ago_do_not_turn(
    place: tuple[float, float], later: float
) -> None:
    correction = PoseCorrection()
    drift = Pose(theta=0.2)
    correction.correct(seen((2.0, 0.0), drift), Pose(), 0.0)
    correction.correct(seen(place, drift), Pose(), later)
    assert correction.odom.theta == 0.0


def test_a_mix_up_of_landmarks_does_not_turn() -> None:
    correction = PoseCorrection()
    correction.correct(seen((2.0, 0.0), Pose(theta=1.5)), Pose(), 0.0)
    correction.correct(seen((0.0, 2.0), Pose(theta=1.5)), Pose(), 1.0)
    assert correction.odom.theta == 0.0


@pytest.mark.parametrize("wrong", [math.nan, math.inf, 1e9])
def test_what_cannot_be_is_refused(wrong: float) -> None:
    for field in ("x", "y", "seen_x", "seen_y"):
        correction = PoseCorrection()
        numbers = {"x": 1.0, "y": 1.0, "seen_x": 1.0, "seen_y": 0.0, field: wrong}
        assert "refused" in correction.correct(LandmarkCorrection(**numbers), Pose(), 0.0)
        assert correction.odom == Pose()


def test_a_shift_leads_from_where_the_robot_is_thought_to_be_to_where_it_is() -> None:
    correction = PoseCorrection()
    correction.odom = Pose(x=1.0, y=-2.0, theta=0.5)
    robot = (0.3, 0.7, -1.0)
    real = Pose(x=4.0, y=5.0, theta=0.2)
    correction.shift(correction.pose(*robot), real)
    now = correction.pose(*robot)
    assert (now.x, now.y, now.theta) == pytest.approx((real.x, real.y, real.theta))
