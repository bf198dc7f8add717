"""The occupancy grid: what scans do to cells, and the pictures of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.map_coding import decode, encode
from hub.gcm.occupancy_map import OccupancyMap
from hub.modules.mapping.evidence import INFRARED, SONAR
from hub.modules.mapping.grid import BORDER, LEAST, LOADED, MOST, OccupancyGrid

NOTHING = np.full(16, np.inf, np.float32)
BLIND = np.full(16, np.nan, np.float32)


def ranges(**by_number: float) -> np.ndarray:
    """Ranges that say nothing but for some sensors: s0=1.0."""
    values = BLIND.copy()
    for name, value in by_number.items():
        values[int(name[1:])] = value
    return values


def at(grid: OccupancyGrid, x: float, y: float) -> float:
    row, column = (math.floor((value - grid.low) / grid.resolution) for value in (y, x))
    return float(grid.log_odds[row, column])


def test_an_echo_marks_its_place_and_frees_the_way_to_it() -> None:
    grid = OccupancyGrid(0.05, 10.0)
    assert grid.add(0.0, 0.0, 0.0, ranges(s0=2.0), BLIND)
    assert at(grid, 2.0, 0.0) > 0.2
    assert at(grid, 1.0, 0.0) < -0.1
    assert at(grid, 2.3, 0.0) == 0.0
    assert at(grid, -1.0, 0.0) == 0.0


@given(
    x=st.floats(-2.0, 2.0),
    y=st.floats(-2.0, 2.0),
    theta=st.floats(-10.0, 10.0),
    sensor=st.integers(0, 15),
    away=st.floats(0.3, 2.8),
    infrared=st.booleans(),
)
def test_an_echo_lies_on_the_axis_of_its_sensor(
    x: float, y: float, theta: float, sensor: int, away: float, *, infrared: bool
) -> None:
    grid = OccupancyGrid(0.05, 12.0)
    scan = ranges(**{f"s{sensor}": min(away, 1.0) if infrared else away})
    away = float(np.nanmax(scan))
    assert grid.add(x, y, theta, BLIND if infrared else scan, scan if infrared else BLIND)
    rows, columns = np.nonzero(grid.log_odds == grid.log_odds.max())
    direction = theta + sensor * math.pi / 8
    for row, column in zip(rows, columns, strict=True):
        beside_x = grid.low + (column + 0.5) * 0.05 - x
        beside_y = grid.low + (row + 0.5) * 0.05 - y
        assert abs(math.hypot(beside_x, beside_y) - away) <= 0.036
        error = math.remainder(math.atan2(beside_y, beside_x) - direction, 2 * math.pi)
        assert abs(error) * away <= 0.15
    assert grid.log_odds.max() > 0.0


def test_evidence_of_a_sonar_falls_with_angle_and_range() -> None:
    def on_axis(away: float) -> float:
        grid = OccupancyGrid(0.05, 10.0)
        grid.add(0.0, 0.0, 0.0, ranges(s0=away), BLIND)
        return float(grid.log_odds.max())

    assert on_axis(0.5) > on_axis(1.5) > on_axis(2.5) > 0.0
    grid = OccupancyGrid(0.05, 10.0)
    grid.add(0.0, 0.0, 0.0, ranges(s0=2.0), BLIND)
    slant = math.radians(8.0)
    assert at(grid, 2.0, 0.0) > at(grid, 2.0 * math.cos(slant), 2.0 * math.sin(slant)) >= 0.0


def test_an_echo_is_put_where_the_map_already_has_something() -> None:
    post = (2.0 * math.cos(0.12), 2.0 * math.sin(0.12))
    grid = OccupancyGrid(0.05, 10.0)
    picture = OccupancyMap(
        cells=np.array([[100]], np.int8), resolution=0.05, origin_x=post[0] - 0.025,
        origin_y=post[1] - 0.025,
    )  # fmt: skip
    grid.paint(picture, LOADED)
    before = at(grid, *post)
    grid.add(0.0, 0.0, 0.0, ranges(s0=2.0), BLIND)
    unknown_beside = at(grid, post[0], -post[1])
    assert at(grid, *post) - before > 2.0 * unknown_beside


def test_a_known_wall_is_not_erased_by_an_echo_from_behind_it() -> None:
    """Smooth walls send beams away: the echo of something farther off comes beside them."""
    grid = OccupancyGrid(0.05, 10.0)
    wall = OccupancyMap(
        cells=np.full((20, 1), 100, np.int8), resolution=0.05, origin_x=1.0, origin_y=-0.5
    )
    grid.paint(wall, LOADED)
    grid.add(0.0, 0.0, 0.0, ranges(s0=2.5), BLIND)
    lost = LOADED - at(grid, 1.01, 0.01)
    assert 0.0 < lost < -0.5 * at(grid, 0.9, 0.01)


def test_what_is_gone_is_forgotten_in_the_end() -> None:
    grid = OccupancyGrid(0.05, 10.0)
    for _ in range(50):
        grid.add(0.0, 0.0, 0.0, ranges(s0=1.025), BLIND)
    assert at(grid, 1.0, 0.0) == pytest.approx(MOST)
    for _ in range(100):
        grid.add(0.0, 0.0, 0.0, ranges(s0=2.5), BLIND)
    assert at(grid, 1.0, 0.0) == pytest.approx(LEAST)


def test_silence_of_a_sonar_frees_only_what_is_near_and_that_of_infrared_nothing() -> None:
    grid = OccupancyGrid(0.05, 10.0)
    grid.add(0.0, 0.0, 0.0, NOTHING, BLIND)
    assert at(grid, SONAR.silent - 0.1, 0.0) < 0.0
    assert at(grid, SONAR.silent + 0.1, 0.0) == 0.0
    assert grid.log_odds.max() == 0.0
    silent = OccupancyGrid(0.05, 10.0)
    silent.add(0.0, 0.0, 0.0, BLIND, NOTHING)
    assert not silent.log_odds.any()


def test_echoes_from_beyond_the_mapped_range_free_what_is_before_it() -> None:
    grid = OccupancyGrid(0.05, 12.0)
    grid.add(0.0, 0.0, 0.0, ranges(s0=4.5), ranges(s0=4.5))
    assert at(grid, 2.5, 0.0) < 0.0
    assert grid.log_odds.max() == 0.0
    assert INFRARED.farthest < SONAR.farthest


@given(
    values=st.lists(st.floats(width=32), min_size=16, max_size=16),
    x=st.floats(), y=st.floats(), theta=st.floats(),
)  # fmt: skip
@example(values=[1.0] * 16, x=1.7e308, y=-1.7e308, theta=1.7e308)
@example(values=[1.0] * 16, x=math.nextafter(2.0, 0.0), y=0.0, theta=0.0)
def test_nothing_that_is_reported_breaks_the_map(
    values: list[float], x: float, y: float, theta: float
) -> None:
    grid = OccupancyGrid(0.1, 4.0)
    scan = np.array(values, np.float32)
    used = grid.add(x, y, theta, scan, scan[::-1])
    assert grid.add(0.3, 0.2, theta if math.isfinite(theta) else 0.0, scan, scan[:3])
    assert grid.outside == (not used)
    assert np.isfinite(grid.log_odds).all()
    assert grid.log_odds.min() >= LEAST
    assert grid.log_odds.max() <= MOST


def test_scans_from_outside_the_square_are_counted_and_left_out() -> None:
    grid = OccupancyGrid(0.05, 4.0)
    assert not grid.add(2.01, 0.0, 0.0, ranges(s8=1.0), BLIND)
    assert grid.outside == 1
    assert not grid.log_odds.any()
    assert grid.add(1.99, -1.99, 0.0, ranges(s0=1.0, s8=1.0), BLIND)
    assert grid.log_odds.any()


def test_the_whole_map_is_what_is_known_and_a_border() -> None:
    grid = OccupancyGrid(0.05, 40.0)
    empty = grid.whole()
    assert (empty.cells == -1).all()
    assert empty.cells.shape == (21, 21)
    grid.add(3.0, -2.0, 0.0, ranges(s0=2.0), BLIND)
    whole = grid.whole()
    known = whole.cells >= 0
    border = round(BORDER / 0.05)
    assert not known[:border].any()
    assert known[border].any()
    assert known[:, border].any()
    assert not known[:, -border:].any()
    assert known[:, -border - 1].any()
    assert whole.origin_x == pytest.approx(3.0 - BORDER, abs=0.2)
    assert np.array_equal(decode(encode(whole.cells), *whole.cells.shape), whole.cells)


def test_the_picture_shows_probabilities_in_percent() -> None:
    grid = OccupancyGrid(0.05, 2.0)
    grid.log_odds[20, 20:24] = (MOST, LEAST, 0.0, math.log(0.65 / 0.35))
    picture = grid.window(0.1, 0.025, 0.2, 0.05)
    assert picture is not None
    assert picture.cells.tolist() == [[95, 10, -1, 65]]


@given(
    x=st.floats(-6, 6), y=st.floats(-6, 6), width=st.floats(0, 9), height=st.floats(0, 9)
)  # fmt: skip
def test_a_window_is_clipped_to_the_square_and_covers_what_was_asked_for(
    x: float, y: float, width: float, height: float
) -> None:
    grid = OccupancyGrid(0.1, 8.0)
    picture = grid.window(x, y, width, height)
    left, right = max(x - width / 2, -4.0), min(x + width / 2, 4.0)
    bottom, top = max(y - height / 2, -4.0), min(y + height / 2, 4.0)
    if left >= right or bottom >= top:
        assert picture is None
        return
    assert picture is not None
    rows, columns = picture.cells.shape
    assert left - 0.1001 <= picture.origin_x <= left + 1e-9
    assert bottom - 0.1001 <= picture.origin_y <= bottom + 1e-9
    assert right - 1e-9 <= picture.origin_x + columns * 0.1 <= right + 0.1001
    assert top - 1e-9 <= picture.origin_y + rows * 0.1 <= top + 0.1001


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_window_that_is_nowhere_shows_nothing(bad: float) -> None:
    grid = OccupancyGrid(0.1, 8.0)
    assert grid.window(bad, 0.0, 1.0, 1.0) is None
    assert grid.window(0.0, bad, 1.0, 1.0) is None
    assert grid.window(0.0, 0.0, 1.0, math.nan) is None


@given(
    cells=st.lists(st.sampled_from([-1, 0, 100]), min_size=12, max_size=12),
    left=st.integers(-30, 30), bottom=st.integers(-30, 30),
)  # fmt: skip
def test_painting_a_picture_and_taking_it_gives_the_same(
    cells: list[int], left: int, bottom: int
) -> None:
    picture = OccupancyMap(
        cells=np.array(cells, np.int8).reshape(3, 4),
        resolution=0.1,
        origin_x=left * 0.1,
        origin_y=bottom * 0.1,
    )
    grid = OccupancyGrid(0.1, 10.0)
    grid.log_odds[:] = 1.0
    assert grid.paint(picture, LOADED) == 0
    taken = grid.window((left + 2) * 0.1, (bottom + 1.5) * 0.1, 0.399, 0.299)
    assert taken is not None
    levels = np.where(taken.cells < 0, -1, np.where(taken.cells < 50, 0, 100))
    assert np.array_equal(levels, picture.cells)
    assert np.count_nonzero(grid.log_odds) == np.count_nonzero(picture.cells >= 0)


def test_known_cells_of_a_picture_outside_the_square_are_counted() -> None:
    picture = OccupancyMap(
        cells=np.array([[0, -1, 100, 100]], np.int8), resolution=1.0, origin_x=0.0, origin_y=0.0
    )
    grid = OccupancyGrid(0.5, 6.0)
    assert grid.paint(picture, LOADED) == 1


def test_a_cell_that_gets_several_is_occupied_if_one_of_them_is() -> None:
    picture = OccupancyMap(
        cells=np.array([[100, 0], [0, 0]], np.int8), resolution=0.05, origin_x=0.0, origin_y=0.0
    )
    grid = OccupancyGrid(0.1, 2.0)
    grid.paint(picture, LOADED)
    assert at(grid, 0.05, 0.05) == LOADED
