"""Grids turn, shift, grow and shrink, and nothing occupied gets lost."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.occupancy_map import OccupancyMap
from rune_tui.model.map_window import MapWindow
from rune_tui.raster.grid_picture import (
    OUTSIDE,
    UNKNOWN,
    grid_colours,
    grid_values,
)
from tests.support.cases import for_each

NORTH = math.pi / 2.0
CORNER = np.array([[0, 100], [50, UNKNOWN]], np.int8)
"""Free in the south-west, occupied in the south-east, unknown in the north-east."""


def grid(
    cells: np.ndarray, resolution: float = 1.0, origin: tuple[float, float] = (0.0, 0.0)
) -> OccupancyMap:
    return OccupancyMap(cells=cells, resolution=resolution, origin_x=origin[0], origin_y=origin[1])


def window(**changes: float) -> MapWindow:
    values = {"x": 1.0, "y": 1.0, "metres_per_pixel": 1.0, "width": 2, "height": 2, "up": NORTH}
    return MapWindow(**values | changes)  # type: ignore[arg-type]


def test_north_is_up_and_east_is_right() -> None:
    values = grid_values(grid(CORNER), window())
    assert values.tolist() == [[50, UNKNOWN], [0, 100]]


@pytest.mark.parametrize(
    ("up", "expected"),
    [
        (0.0, [[UNKNOWN, 100], [50, 0]]),
        (math.pi, [[0, 50], [100, UNKNOWN]]),
        (-NORTH, [[100, 0], [UNKNOWN, 50]]),
    ],
)
def test_the_picture_turns_with_what_is_up(up: float, expected: list[list[int]]) -> None:
    assert grid_values(grid(CORNER), window(up=up)).tolist() == expected


def test_shifting_brings_in_what_is_outside() -> None:
    values = grid_values(grid(CORNER, 1.0, (10.0, 20.0)), window(x=12.0, y=21.0))
    assert values.tolist() == [[UNKNOWN, OUTSIDE], [100, OUTSIDE]]
    far = grid_values(grid(CORNER, 1.0, (10.0, 20.0)), window(x=-1e6))
    assert (far == OUTSIDE).all()


def test_enlarged_cells_are_squares_with_hard_edges() -> None:
    values = grid_values(grid(CORNER), window(metres_per_pixel=0.25, width=8, height=8))
    larger = np.repeat(np.repeat([[50, UNKNOWN], [0, 100]], 4, axis=0), 4, axis=1)
    assert (values == larger).all()


@given(step=st.integers(2, 9), seed=st.integers(0, 99))
def test_shrunk_by_whole_cells_a_pixel_shows_its_most_occupied_cell(step: int, seed: int) -> None:
    cells = np.random.default_rng(seed).integers(-1, 101, (step * 5, step * 7)).astype(np.int8)
    shown = window(x=3.5 * step, y=2.5 * step, metres_per_pixel=float(step), width=7, height=5)
    values = grid_values(grid(cells), shown)
    expected = cells.reshape(5, step, 7, step).max(axis=(1, 3))
    assert (values == expected[::-1]).all()


@example(scale=1.0, up=1.41015625, row=0, column=0, shift=0.0)
@given(
    scale=st.floats(0.3, 12.0),
    up=st.floats(-math.pi, math.pi),
    row=st.integers(0, 39),
    column=st.integers(0, 59),
    shift=st.floats(-3.0, 3.0),
)
def test_a_single_occupied_cell_is_seen_less_than_a_pixel_from_its_place(
    scale: float, up: float, row: int, column: int, shift: float
) -> None:
    cells = np.zeros((40, 60), np.int8)
    cells[row, column] = 100
    shown = MapWindow(
        x=3.0 + shift * 0.05,
        y=2.0 - shift * 0.03,
        metres_per_pixel=0.1 * scale,
        width=2 * math.ceil(40 / scale) + 2,
        height=2 * math.ceil(40 / scale) + 2,
        up=up,
    )
    values = grid_values(grid(cells, 0.1), shown)
    rows, columns = np.nonzero(values == 100)
    assert len(rows)
    x, y = shown.pixels(((column + 0.5) * 0.1, (row + 0.5) * 0.1)).tolist()
    away = np.maximum(np.abs(columns + 0.5 - x), np.abs(rows + 0.5 - y))
    # Half a pixel, and what a block's or cell's middle can be away from its corner.
    assert away.max() < 0.5 + math.sqrt(0.5) * max(1.0, 1.0 / scale) + 1e-9


@for_each("scale", [1.3, 2.0, 3.7, 6.1])
@for_each("up", [NORTH, 0.4])
def test_a_wall_one_cell_thin_has_no_holes_when_shrunk(scale: float, up: float) -> None:
    cells = np.zeros((120, 120), np.int8)
    cells[:, 60] = 100
    shown = window(x=60.0, y=60.0, metres_per_pixel=scale, width=30, height=30, up=up)
    values = grid_values(grid(cells), shown)
    along = np.linspace(40.0, 80.0, 200) if scale > 2.0 else np.linspace(55.0, 65.0, 50)
    places = np.floor(shown.pixels(np.stack((np.full_like(along, 60.5), along), axis=1)))
    padded = np.pad(values, 1)
    for column, row in places.astype(int):
        assert padded[row : row + 3, column : column + 3].max() == 100
    assert (values == 100).sum() < 4 * 30


def test_free_space_turned_and_shrunk_a_little_has_no_holes() -> None:
    cells = np.zeros((80, 80), np.int8)
    for up in np.linspace(0.0, 1.5, 7):
        for scale in (1.01, 1.2, 1.4):
            shown = window(
                x=40.0, y=40.0, metres_per_pixel=scale, width=30, height=30, up=float(up)
            )
            assert (grid_values(grid(cells), shown) == 0).all()


@for_each(
    ("cells", "resolution", "origin"),
    [
        (np.empty((0, 0), np.int8), 1.0, (0.0, 0.0)),
        (np.empty((0, 5), np.int8), 1.0, (0.0, 0.0)),
        (CORNER, 0.0, (0.0, 0.0)),
        (CORNER, math.nan, (0.0, 0.0)),
        (CORNER, 1.0, (math.nan, 0.0)),
    ],
)
def test_a_grid_that_is_nowhere_shows_nothing(
    cells: np.ndarray, resolution: float, origin: tuple[float, float]
) -> None:
    for scale in (0.5, 3.0):
        values = grid_values(grid(cells, resolution, origin), window(metres_per_pixel=scale))
        assert (values == OUTSIDE).all()


def test_values_have_their_colours() -> None:
    colours = grid_colours(
        free=(200, 200, 200, 255),
        occupied=(0, 100, 0, 255),
        unknown=(9, 9, 9, 99),
        outside=(0, 0, 0, 0),
    )
    picture = colours[grid_values(grid(CORNER), window(width=4)).view(np.uint8)]
    assert picture.shape == (2, 4, 4)
    assert picture[0].tolist() == [[0, 0, 0, 0], [100, 150, 100, 255], [9, 9, 9, 99], [0, 0, 0, 0]]
    assert picture[1, 1:3].tolist() == [[200, 200, 200, 255], [0, 100, 0, 255]]


@given(
    x=st.floats(-99.0, 99.0),
    y=st.floats(-99.0, 99.0),
    up=st.floats(-7.0, 7.0),
    scale=st.floats(0.001, 9.0),
)
def test_pixels_of_a_window_lead_back_to_their_places(
    x: float, y: float, up: float, scale: float
) -> None:
    shown = MapWindow(x=x, y=y, metres_per_pixel=scale, width=160, height=96, up=up)
    pixels = np.array([(0.0, 0.0), (80.0, 48.0), (159.0, 3.0)])
    assert shown.pixels(shown.points(pixels)) == pytest.approx(pixels, abs=1e-8)
    assert shown.points((80.0, 48.0)) == pytest.approx([x, y])
    ahead = shown.points((80.0, 47.0)) - (x, y)
    assert ahead == pytest.approx([scale * math.cos(up), scale * math.sin(up)], abs=1e-9)
