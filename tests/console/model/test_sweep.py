"""The edges of the path that a body's width sweeps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from rune_tui.model.sweep import swept_edges
from tests.console.model.cameras import numbers

RADIUS = 0.2


def test_straight_ahead_and_back_the_edges_are_straight() -> None:
    left, right = swept_edges(RADIUS, 0.5, 0.0, 2.0)
    assert left == pytest.approx(np.array([(0.0, 0.2), (1.0, 0.2)]))
    assert right == pytest.approx(np.array([(0.0, -0.2), (1.0, -0.2)]))
    left, right = swept_edges(RADIUS, -0.5, 0.0, 2.0)
    assert left[-1] == pytest.approx([-1.0, 0.2])
    assert right[-1] == pytest.approx([-1.0, -0.2])


def test_a_quarter_circle_to_the_left_ends_beside_where_it_began() -> None:
    """0.5 m/s and 0.5 rad/s: 1 m around a centre 1 m to the left."""
    left, right = swept_edges(RADIUS, 0.5, 0.5, math.pi)
    assert left[-1] == pytest.approx([0.8, 1.0])
    assert right[-1] == pytest.approx([1.2, 1.0])
    left, right = swept_edges(RADIUS, 0.5, -0.5, math.pi)
    assert left[-1] == pytest.approx([1.2, -1.0])
    assert right[-1] == pytest.approx([0.8, -1.0])


def test_a_turn_on_the_spot_stays_on_the_rim() -> None:
    left, right = swept_edges(RADIUS, 0.0, 1.0, 1.0)
    assert np.hypot(*left.T) == pytest.approx(RADIUS)
    assert (left == -right).all()
    assert math.atan2(left[-1, 1], left[-1, 0]) == pytest.approx(1.0 + math.pi / 2.0)


def test_standing_still_sweeps_the_body_only() -> None:
    left, right = swept_edges(RADIUS, 0.0, 0.0, 2.0)
    assert left.tolist() == [[0.0, 0.2]] * 2
    assert right.tolist() == [[0.0, -0.2]] * 2


def test_many_turns_are_drawn_once() -> None:
    left, _ = swept_edges(RADIUS, 0.5, 3.0, 1e6)
    assert len(left) < 120
    assert left[-1] == pytest.approx(left[0], abs=1e-9)


@given(linear=numbers(-1.0, 1.0), angular=numbers(-2.0, 2.0), seconds=numbers(0.0, 3.0))
def test_edges_are_where_small_steps_lead(linear: float, angular: float, seconds: float) -> None:
    left, right = swept_edges(RADIUS, linear, angular, seconds)
    x = y = 0.0
    steps = 400
    for step in range(steps):
        heading = angular * seconds * (step + 0.5) / steps
        x += linear * seconds / steps * math.cos(heading)
        y += linear * seconds / steps * math.sin(heading)
    heading = angular * seconds
    beside = np.array((-math.sin(heading), math.cos(heading))) * RADIUS
    assert left[-1] == pytest.approx(np.array((x, y)) + beside, abs=1e-4)
    assert right[-1] == pytest.approx(np.array((x, y)) - beside, abs=1e-4)


@given(linear=numbers(-1.0, 1.0), angular=numbers(-2.0, 2.0))
def test_edges_are_a_body_apart_and_bend_by_few_degrees_a_corner(
    linear: float, angular: float
) -> None:
    left, right = swept_edges(RADIUS, linear, angular, 3.0)
    across = left - right
    assert np.linalg.norm(across, axis=1) == pytest.approx(2.0 * RADIUS)
    heading = np.unwrap(np.arctan2(-across[:, 0], across[:, 1]))
    assert np.abs(np.diff(heading)).max() <= math.radians(4.0) + 1e-9
    assert heading[-1] == pytest.approx(max(-math.tau, min(math.tau, angular * 3.0)), abs=1e-6)
