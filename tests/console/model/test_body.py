"""The outline of a robot, and its bumpers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.body import Bumper, Point32, RobotBody
from rune_tui.model.body import corners, largest_radius, pressed_bumpers, rooms


def body_of(*points: tuple[float, float], radius: float = 1.0) -> RobotBody:
    footprint = tuple(Point32(x=x, y=y) for x, y in points)
    return RobotBody(name="r", kind="k", radius=radius, footprint=footprint)


def rooms_at(body: RobotBody, *points: tuple[float, float]) -> list[float]:
    return rooms(body, np.array(points, np.float64)).tolist()


def test_room_beside_a_circle_is_counted_from_its_rim() -> None:
    body = body_of(radius=0.5)
    assert not len(corners(body))
    assert rooms_at(body, (2.0, 0.0), (0.0, -0.6), (0.3, 0.3)) == pytest.approx([1.5, 0.1, 0.0])


def test_room_beside_a_rectangle_is_counted_from_its_nearest_edge_or_corner() -> None:
    car = body_of((0.6, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.6, -0.3))
    points = ((1.6, 0.0), (0.0, 0.5), (-0.9, -0.3), (0.9, -0.7), (0.5, 0.2))
    assert rooms_at(car, *points) == pytest.approx([1.0, 0.2, 0.5, 0.5, 0.0])


def test_the_hollow_of_a_body_is_outside_of_it() -> None:
    fork = body_of((1, 1), (-1, 1), (-1, -1), (1, -1), (1, -0.5), (0, -0.5), (0, 0.5), (1, 0.5))
    assert rooms_at(fork, (0.5, 0.0), (0.5, 0.7)) == pytest.approx([0.5, 0.0])


@given(st.integers(3, 32), st.floats(0.05, 5.0), st.floats(0.0, 6.3), st.floats(0.0, 6.3))
def test_room_beside_a_regular_polygon_is_that_of_its_two_circles_or_between(
    sides: int, radius: float, turned: float, bearing: float
) -> None:
    angles = turned + np.arange(sides) * math.tau / sides
    points = [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]
    body = body_of(*points, radius=radius)
    away = 2.0 * radius
    (room,) = rooms_at(body, (away * math.cos(bearing), away * math.sin(bearing)))
    assert away - radius * (1.0 + 1e-6) <= room
    assert room <= away - radius * math.cos(math.pi / sides) * (1.0 - 1e-6)


def test_bumpers_are_those_of_the_description() -> None:
    bumpers = (
        Bumper(name="left", direction=0.8, width=1.0),
        Bumper(name="right", direction=-0.8, width=1.0),
    )
    body = RobotBody(name="r", kind="k", radius=0.3, bumpers=bumpers)
    assert pressed_bumpers(body, 0b10) == (bumpers[1],)
    assert pressed_bumpers(body, 0b100) == ()
    assert pressed_bumpers(None, 0b11) == ()


@pytest.mark.parametrize("radius", [0.0, 1e-300, 0.4])
def test_a_radius_that_is_too_small_for_the_corners_is_not_believed(radius: float) -> None:
    assert largest_radius(body_of((0.6, 0.3), (-0.4, 0.3), (-0.4, -0.3), radius=radius)) == (
        pytest.approx(math.hypot(0.6, 0.3))
    )
