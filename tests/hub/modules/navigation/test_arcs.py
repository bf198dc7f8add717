"""The way along an arc to a contact is the one that small steps along it find too."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.modules.navigation.arcs import free_ways

RADIUS = 0.25
LONGEST = 3.0
STEP = 0.002


def way(
    linear: float, angular: float, *points: tuple[float, float], width: float = RADIUS
) -> float:
    """The free way of one velocity [m]."""
    x, y = np.array(points, dtype=np.float64).reshape(-1, 2).T
    ways = free_ways(
        np.array([linear]),
        np.array([angular]),
        x.copy(),
        y.copy(),
        np.array([RADIUS]),
        np.array([width]),
    )
    return float(ways[0])


def stepped(linear: float, angular: float, point: tuple[float, float]) -> float:
    """The same, by driving; inf beyond LONGEST."""
    x = y = theta = gone = 0.0
    seconds = STEP / abs(linear)
    while gone < LONGEST:
        if math.hypot(point[0] - x, point[1] - y) <= RADIUS:
            return gone
        theta += angular * seconds / 2.0
        x += linear * seconds * math.cos(theta)
        y += linear * seconds * math.sin(theta)
        theta += angular * seconds / 2.0
        gone += STEP
    return math.inf


def test_straight_ahead_it_is_the_distance_less_the_radius() -> None:
    assert way(0.5, 0.0, (1.0, 0.0)) == pytest.approx(0.75, abs=1e-6)


def test_backwards_only_what_is_behind_counts() -> None:
    assert way(-0.5, 0.0, (1.0, 0.0)) > 3.0
    assert way(-0.5, 0.0, (-1.0, 0.0)) == pytest.approx(0.75, abs=1e-6)


def test_the_nearest_of_several_points_counts() -> None:
    assert way(0.5, 0.0, (2.0, 0.0), (1.0, 0.0), (1.5, 0.0)) == pytest.approx(0.75, abs=1e-6)


def test_turning_on_the_spot_meets_nothing() -> None:
    assert way(0.0, 1.0, (0.1, 0.0), (0.26, 0.0)) == math.inf


def test_a_point_inside_does_not_stop_a_body_that_leaves_it() -> None:
    assert way(0.5, 0.0, (0.2, 0.0)) == 0.0
    assert way(-0.5, 0.0, (0.2, 0.0)) == math.inf


def test_what_passes_beside_the_cut_off_sides_does_not_count() -> None:
    beside = (1.0, 0.24)
    assert way(0.5, 0.0, beside) < 1.0
    assert way(0.5, 0.0, beside, width=0.23) == math.inf


@given(
    st.floats(0.05, 1.0),
    st.sampled_from((1.0, -1.0)),
    st.floats(-2.0, 2.0),
    st.floats(0.3, 2.0),
    st.floats(-math.pi, math.pi),
)
def test_arcs_agree_with_small_steps(
    speed: float, sign: float, angular: float, away: float, bearing: float
) -> None:
    point = (away * math.cos(bearing), away * math.sin(bearing))
    exact, found = way(sign * speed, angular, point), stepped(sign * speed, angular, point)
    if exact > LONGEST - 0.05 or found == math.inf:
        # A graze that the steps jump over, or one beyond their end.
        assert found == math.inf or _grazes(sign * speed, angular, point) or exact > LONGEST - 0.05
    else:
        assert exact == pytest.approx(found, abs=0.05) or _grazes(sign * speed, angular, point)


def _grazes(linear: float, angular: float, point: tuple[float, float]) -> bool:
    """Whether the rim hardly touches the point."""
    if abs(angular) < 1e-6:
        return abs(abs(point[1]) - RADIUS) < 0.01
    turn = linear / angular
    return abs(abs(math.hypot(point[0], point[1] - turn) - abs(turn)) - RADIUS) < 0.01
