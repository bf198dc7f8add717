"""The pose is doubted as much as the wheels have moved, whatever the rate of reports."""

from __future__ import annotations

import math

import pytest

from hub.modules.navigation.pose_uncertainty import (
    LAID_TURN,
    LAID_WAY,
    LANDMARK_OFF,
    PoseUncertainty,
    Spread,
)
from hub.pose import Pose, wrapped


def driven(*, speed: float, rate: float, hz: float = 20.0, seconds: float = 5.0) -> PoseUncertainty:
    """After a drive [m/s, rad/s] with reports of this rate."""
    doubt = PoseUncertainty()
    for step in range(round(seconds * hz) + 1):
        now = step / hz
        doubt.moved(Pose(x=speed * now, theta=wrapped(rate * now)), now)
    return doubt


def test_standing_leaves_no_doubt_and_turning_much_more_than_driving_straight() -> None:
    still, straight, turning = (
        driven(speed=speed, rate=rate).spread
        for speed, rate in ((0.0, 0.0), (0.3, 0.0), (0.0, 0.5))
    )
    assert still.way <= straight.way
    assert still.turn == pytest.approx(straight.turn)
    assert turning.turn > 5.0 * straight.turn


@pytest.mark.parametrize("hz", [10.0, 50.0])
def test_the_rate_of_reports_does_not_matter(hz: float) -> None:
    usual, other = driven(speed=0.2, rate=0.3).spread, driven(speed=0.2, rate=0.3, hz=hz).spread
    assert other.turn == pytest.approx(usual.turn, rel=0.1)
    assert other.way == pytest.approx(usual.way, rel=0.1)


def test_it_is_never_so_large_that_everything_would_be_tried() -> None:
    spread = driven(speed=0.5, rate=1.0, seconds=300.0).spread
    assert spread.turn < math.radians(10.0)
    assert spread.way < 0.2


def test_a_match_settles_it_and_a_landmark_settles_the_place_only() -> None:
    doubt = driven(speed=0.3, rate=0.3)
    heading = doubt.spread.turn
    doubt.met_landmark()
    assert doubt.spread.turn == pytest.approx(heading, rel=0.2)
    assert doubt.spread.way == pytest.approx(LANDMARK_OFF, rel=0.1)
    doubt.matched(Spread(turn=0.03, way=0.03))
    assert doubt.spread.turn == pytest.approx(0.03, rel=0.1)
    assert doubt.spread.way == pytest.approx(0.03, rel=0.1)


def test_where_scans_show_the_motion_it_grows_with_the_root_of_the_way() -> None:
    doubt = PoseUncertainty()
    doubt.matched(Spread(turn=0.01, way=0.02))
    for number in range(1, 1001):
        doubt.moved(Pose(x=0.1 * number), 0.1 * number)
        doubt.laid()
    assert doubt.whole.way == pytest.approx(math.hypot(0.02, LAID_WAY * 10.0), rel=0.1)
    assert doubt.whole.turn == pytest.approx(math.hypot(0.01, LAID_TURN * 10.0), rel=0.2)
