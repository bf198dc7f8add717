"""The rim of a robot as the console knows it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.body import Point32, RobotBody
from rune_tui.model.body import corners, largest_radius, rim


def body_of(*points: tuple[float, float], radius: float = 1.0) -> RobotBody:
    footprint = tuple(Point32(x=x, y=y) for x, y in points)
    return RobotBody(name="r", kind="k", radius=radius, footprint=footprint)


def test_a_body_without_corners_is_a_circle() -> None:
    assert rim(body_of(radius=0.5), 16) == pytest.approx(0.5)
    assert not len(corners(body_of()))


def test_of_an_unknown_body_distances_are_from_its_origin() -> None:
    assert not rim(None, 16).any()
    assert largest_radius(None) == 0.0


def test_the_rim_of_a_rectangle_is_ahead_left_behind_and_at_its_corners() -> None:
    car = body_of((0.6, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.6, -0.3))
    ahead, left, behind, right = rim(car, 4)
    assert (ahead, left, behind, right) == pytest.approx((0.6, 0.3, 0.4, 0.3))
    assert rim(body_of((1, 1), (-1, 1), (-1, -1), (1, -1)), 8)[1] == pytest.approx(math.sqrt(2.0))


@given(st.integers(3, 32), st.floats(0.05, 5.0), st.floats(0.0, 6.3), st.integers(1, 64))
def test_the_rim_of_a_regular_polygon_lies_between_its_two_circles(
    sides: int, radius: float, turned: float, count: int
) -> None:
    angles = turned + np.arange(sides) * math.tau / sides
    points = [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]
    distances = rim(body_of(*points, radius=radius), count)
    assert (distances <= radius * (1.0 + 1e-6)).all()
    assert (distances >= radius * math.cos(math.pi / sides) * (1.0 - 1e-6)).all()


@pytest.mark.parametrize("radius", [0.0, 1e-300, 0.4])
def test_a_radius_that_is_too_small_for_the_corners_is_not_believed(radius: float) -> None:
    assert largest_radius(body_of((0.6, 0.3), (-0.4, 0.3), (-0.4, -0.3), radius=radius)) == (
        pytest.approx(math.hypot(0.6, 0.3))
    )
