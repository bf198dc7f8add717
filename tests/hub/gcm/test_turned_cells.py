"""Turned maps on the axes of their frame."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.mapping import MOST_CELLS
from hub.gcm.turned_cells import turned_map
from hub.pose import Pose

CELLS = np.full((4, 6), -1, np.int8)
CELLS[1:3, 2:6] = [[0, 0, 30, 100], [100, 0, 0, 70]]


def values_at(made, x, y):
    """The values of a map at places; -2: outside."""
    column = np.floor((x - made.origin_x) / made.resolution).astype(int)
    row = np.floor((y - made.origin_y) / made.resolution).astype(int)
    height, width = made.cells.shape
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    return np.where(inside, made.cells[row * inside, column * inside], -2)


def middles(origin, resolution):
    """The middles of all cells in the frame, and their values."""
    row, column = np.indices(CELLS.shape).reshape(2, -1)
    return *origin.outward((column + 0.5) * resolution, (row + 0.5) * resolution), CELLS.ravel()


def test_a_map_on_its_axes_stays_as_it_is():
    made = turned_map(CELLS, 0.5, Pose(x=1.0, y=-2.0))
    assert made.cells is CELLS
    assert (made.origin_x, made.origin_y, made.resolution) == (1.0, -2.0, 0.5)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_quarter_turn_moves_each_known_cell(quarters):
    origin = Pose(x=0.3, y=-0.7, theta=quarters * math.pi / 2.0)
    made = turned_map(CELLS, 0.1, origin)
    assert sorted(made.cells.shape) == [2, 4]
    x, y, values = middles(origin, 0.1)
    assert (values_at(made, x, y)[values >= 0] == values[values >= 0]).all()
    assert sorted(made.cells.ravel()) == sorted(CELLS[CELLS >= 0])


@given(
    st.floats(-math.pi, math.pi),
    st.floats(-50.0, 50.0),
    st.floats(-50.0, 50.0),
    st.floats(0.01, 1.0),
)
def test_no_occupied_cell_is_lost_and_none_appears_elsewhere(theta, x, y, resolution):
    origin = Pose(x=x, y=y, theta=theta)
    made = turned_map(CELLS, resolution, origin)
    ahead, left, values = middles(origin, resolution)
    solid = values >= 50
    assert (values_at(made, ahead, left)[solid] >= 50).all()
    row, column = np.nonzero(made.cells >= 50)
    at_x = made.origin_x + (column + 0.5) * resolution
    at_y = made.origin_y + (row + 0.5) * resolution
    away = np.hypot(at_x[:, None] - ahead[solid], at_y[:, None] - left[solid]).min(axis=1)
    assert (away < 1.5 * resolution).all()


def test_an_unknown_map_is_small_and_a_large_one_is_refused():
    turned = Pose(theta=0.8)
    assert (turned_map(np.full((900, 900), -1, np.int8), 0.1, turned).cells == -1).all()
    long = np.zeros((MOST_CELLS, 10), np.int8)
    assert turned_map(long, 0.1, turned) is not None
    wide = np.zeros((10, MOST_CELLS), np.int8)
    wide = np.broadcast_to(wide[:1], (MOST_CELLS, MOST_CELLS))
    assert turned_map(wide, 0.1, turned) is None
