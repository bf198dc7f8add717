"""The free time of an outline of any shape is the one that small steps find too."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hub.gcm.outline import hull
from hub.modules.navigation.sweeps import MOST_EDGES, Sweep

Floats = npt.NDArray[np.float64]
STEP = 0.002
PLACES = st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
BOX = np.array(((0.5, -0.2), (0.5, 0.2), (-0.3, 0.2), (-0.3, -0.2)))


@st.composite
def outlines(draw: st.DrawFn) -> Floats:
    """Corners of random convex outlines around the origin."""
    count = draw(st.integers(3, 20))
    bearings = np.cumsum([draw(st.floats(0.2, 1.0)) for _ in range(count)])
    bearings *= math.tau / (bearings[-1] + draw(st.floats(0.2, 1.0)))
    aways = [draw(st.floats(0.15, 0.6)) for _ in range(count)]
    corners = hull(np.stack((aways * np.cos(bearings), aways * np.sin(bearings)), axis=1))
    assume(len(corners) >= 3)
    return corners


def free(
    corners: Floats,
    linear: float,
    angular: float,
    *places: tuple[float, float],
    ahead: float = 0.0,
    around: float = 0.0,
) -> float:
    """The free time of one velocity [s]."""
    x, y = np.array(places, dtype=np.float64).reshape(-1, 2).T
    one = np.ones(1)
    times = Sweep(corners).free_times(
        one * linear, one * angular, x.copy(), y.copy(), one * ahead, one * around
    )
    return float(times[0])


def least_beyond(corners: Floats, x: Floats, y: Floats) -> Floats:
    """How far points are beyond the edge that they are farthest from [m], shape (n,)."""
    along = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(*along.T)
    aside = (x[:, None] - corners[:, 0]) * along[:, 1] - (y[:, None] - corners[:, 1]) * along[:, 0]
    beyond: Floats = (aside / length).max(axis=1)
    return beyond


def inside(corners: Floats, x: float, y: float, beyond: float = 0.0) -> bool:
    """Whether a point is inside, or at most so far beyond each edge's line [m]."""
    return bool(least_beyond(corners, np.array([x]), np.array([y]))[0] <= beyond)


def stepped(
    corners: Floats, linear: float, angular: float, place: tuple[float, float], beyond: float
) -> float:
    """The free time, by driving for 4 s; inf beyond that."""
    times = np.arange(0.0, 4.0, STEP)
    turned = angular * times
    half = turned / 2.0
    chord = linear * times * np.sinc(half / math.pi)
    to_x, to_y = place[0] - chord * np.cos(half), place[1] - chord * np.sin(half)
    x = to_x * np.cos(turned) + to_y * np.sin(turned)
    y = to_y * np.cos(turned) - to_x * np.sin(turned)
    met = np.flatnonzero(least_beyond(corners, x, y) <= beyond)
    return float(times[met[0]]) if len(met) else math.inf


@given(
    outlines(),
    st.floats(0.0, 1.0),
    st.floats(-2.0, 2.0),
    st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
)
def test_times_agree_with_small_steps(
    corners: Floats, linear: float, angular: float, place: tuple[float, float]
) -> None:
    assume(len(corners) <= MOST_EDGES and not inside(corners, *place, 0.01))
    exact = free(corners, linear, angular, place)
    if exact > 3.9:
        exact = math.inf
    wider, narrower = (stepped(corners, linear, angular, place, by) for by in (0.004, -0.004))
    assert exact >= wider - 2.0 * STEP
    assert exact <= narrower + 2.0 * STEP


@given(outlines(), st.floats(0.0, 1.0), st.floats(-2.0, 2.0), st.lists(PLACES, max_size=8))
def test_the_first_contact_counts_and_margins_only_shorten(
    corners: Floats, linear: float, angular: float, places: list[tuple[float, float]]
) -> None:
    times = [free(corners, linear, angular, place) for place in places]
    together = free(corners, linear, angular, *places)
    assert together == pytest.approx(min(times, default=math.inf), abs=1e-3)
    outside = [place for place in places if not inside(corners, *place, 1e-4)]
    near = free(corners, linear, angular, *outside, ahead=0.1, around=0.02)
    assert near <= free(corners, linear, angular, *outside) + 1e-9


def test_a_long_body_passes_where_its_circle_does_not() -> None:
    wall = [(x / 20.0, side) for x in range(-40, 41) for side in (-0.25, 0.25)]
    assert free(BOX, 0.5, 0.0, *wall, ahead=0.1, around=0.02) > 1e3
    assert free(BOX, 0.0, 1.0, *wall) < 0.3


def test_ahead_it_is_the_distance_to_the_front() -> None:
    assert math.isclose(free(BOX, 0.5, 0.0, (1.0, 0.1)), 1.0, rel_tol=1e-4)
    assert math.isclose(free(BOX, 0.5, 0.0, (1.0, 0.1), ahead=0.1), 0.8, rel_tol=1e-4)
    assert free(BOX, 0.5, 0.0, (1.0, 0.21)) > 1e3
    assert free(BOX, 0.5, 0.0, (-1.0, 0.0)) > 1e3


def test_turning_on_the_spot_meets_what_is_beside_the_ends() -> None:
    quarter = free(BOX, 0.0, 1.0, (0.0, 0.4))
    assert math.isclose(quarter, math.acos(0.2 / 0.4))
    assert free(BOX, 0.0, 1.0, (0.0, 0.55)) == math.inf
    assert free(BOX, 0.0, 1.0, (0.3, 0.25)) < free(BOX, 0.0, -1.0, (0.3, 0.25))


def test_a_point_within_the_margin_does_not_stop_a_body_that_leaves_it() -> None:
    assert free(BOX, 0.5, 0.0, (0.52, 0.0), ahead=0.05) == 0.0
    away = BOX @ np.array(((-1.0, 0.0), (0.0, -1.0)))  # it drives backwards
    assert free(away, 0.5, 0.0, (-0.52, 0.0), ahead=0.05) > 1e3


def test_the_tail_that_swings_out_later_is_seen() -> None:
    # Beside the front the point goes away at first; the rear comes nearer to it afterwards.
    place = (0.02, -0.21)
    assert free(BOX, 0.3, 1.0, place, around=0.2) < math.inf


@given(outlines(), st.floats(-4.0, 4.0), PLACES)
def test_an_outline_in_another_frame_is_the_same(
    corners: Floats, axis: float, place: tuple[float, float]
) -> None:
    cosine, sine = math.cos(axis), math.sin(axis)
    x, y = place[0] * cosine + place[1] * sine, place[1] * cosine - place[0] * sine
    straight = Sweep(corners).distances(np.array([place[0]]), np.array([place[1]]))
    turned = Sweep(corners).along(axis).distances(np.array([x]), np.array([y]))
    assert np.allclose(straight, turned)
    assert straight[0] <= np.hypot(*(corners - place).T).min() + 1e-9


def test_the_hull_leaves_out_what_is_inside() -> None:
    points = np.array(((0.0, 0.0), (1.0, 0.0), (0.5, 0.1), (1.0, 1.0), (0.5, 0.0), (0.0, 1.0)))
    assert hull(points).tolist() == [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
