"""Distances to the nearest obstacle, against measuring each."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.grids.clearance import MOST_CELLS, clearance
from hub.grids.grid import Grid
from tests.hub.grids.grid_maps import maps


@given(maps(), st.floats(0.05, 4.0))
def test_distances_are_those_to_the_nearest_obstacle(grid: Grid, cap: float) -> None:
    rows, columns = np.indices(grid.cells.shape)
    expected = np.full(grid.cells.shape, cap)
    for row, column in np.argwhere(grid.occupied):
        away = 0.1 * np.hypot(rows - row, columns - column)
        expected = np.minimum(expected, away)
    assert clearance(grid.occupied, 0.1, cap) == pytest.approx(expected, abs=1e-5)


def test_a_cap_beyond_what_can_be_counted_is_lowered() -> None:
    occupied = np.zeros((2, 500), np.bool_)
    occupied[0, 0] = True
    distance = clearance(occupied, 1.0, 1e9)
    assert distance[0, 100] == 100.0
    assert distance[1, 499] == MOST_CELLS
