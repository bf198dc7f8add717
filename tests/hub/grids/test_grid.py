"""How cells lie in the frame, and which maps are refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError
from hub.gcm import map_coding
from hub.gcm.mapping import Map
from hub.grids.grid import MAX_CELLS, UNKNOWN, Grid, grid_of
from tests.hub.grids.grid_maps import drawn, maps
from tests.support.cases import for_each


def message(cells: np.ndarray, **fields: object) -> Map:
    data = map_coding.encode(cells)
    known = {
        "stamp": 0.0,
        "resolution": 0.05,
        "width_cells": cells.shape[1],
        "height_cells": cells.shape[0],
        "origin_x": -3.0,
        "origin_y": 1.0,
        "data": data,
    }
    return Map(**{**known, **fields})


@given(maps(), st.data())
def test_the_middle_of_a_cell_lies_in_it(grid: Grid, data: st.DataObject) -> None:
    row = data.draw(st.integers(0, grid.height_cells - 1))
    column = data.draw(st.integers(0, grid.width_cells - 1))
    assert grid.cell(*grid.centre(row, column)) == (row, column)
    assert grid.contains(row, column)
    assert not grid.contains(row, grid.width_cells)


def test_the_map_of_a_message_has_its_cells_where_the_message_says() -> None:
    cells = np.array([[0, 100, -1], [50, 20, 0]], np.int8)
    grid = grid_of(message(cells))
    assert np.array_equal(grid.cells, cells)
    assert grid.cell(-3.0 + 0.06, 1.01) == (0, 1)
    assert grid.occupied.tolist() == [[False, True, False], [False, False, False]]
    assert grid.free.tolist() == [[True, False, False], [False, True, True]]
    assert grid.unknown.tolist() == [[False, False, True], [False, False, False]]


@for_each(
    "fields",
    [
        {"resolution": math.nan},
        {"resolution": 0.0},
        {"resolution": -0.05},
        {"origin_x": math.inf},
        {"origin_y": math.nan},
        {"width_cells": 0},
        {"width_cells": -3, "height_cells": -2},
        {"width_cells": MAX_CELLS, "height_cells": 2},
        {"data": np.zeros(0, np.uint8)},
        {"data": np.frombuffer(b"\x01nonsense", np.uint8)},
    ],
)
def test_a_message_that_is_no_map_is_refused(fields: dict[str, object]) -> None:
    with pytest.raises(CodecError):
        grid_of(message(np.zeros((2, 3), np.int8), **fields))


def test_ground_is_added_around_a_map_without_moving_it() -> None:
    grid = drawn("#.", "..")
    wide = grid.covering(((-1.0, 0.1), (0.1, 2.0)), 0.25)
    assert wide is not None
    row, column = wide.cell(*grid.centre(1, 0))
    assert wide.cells[row, column] == 100
    assert (wide.cells >= 0).sum() == 4
    for x, y in ((-1.2, 0.1), (0.1, 2.2)):
        row, column = wide.cell(x, y)
        assert wide.cells[row, column] == UNKNOWN
    assert grid.covering(((0.1, 0.1),), 0.05) is grid


def test_a_map_does_not_grow_without_end() -> None:
    assert drawn("..").covering(((1e6, 1e6),), 1.0) is None
