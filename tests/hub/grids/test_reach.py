"""What counts as ground that the robot can reach and fits on."""

from __future__ import annotations

import numpy as np
import pytest

from hub.grids.grid import Grid
from hub.grids.reach import standing_ground, ways

RADIUS = 0.25


def ground(cells: np.ndarray) -> float:
    """Ground in reach of a robot in the left room [m^2]."""
    grid = Grid(cells=cells.astype(np.int8), resolution=0.1, origin_x=0.0, origin_y=0.0)
    lengths = ways(grid, (1.0, 1.5), radius=RADIUS)
    return standing_ground(grid, lengths, RADIUS)


def room() -> np.ndarray:
    """A room of 2 m by 3 m whose walls are known; what is beyond them is not."""
    cells = np.full((32, 60), -1)
    cells[:, :22] = 100
    cells[1:-1, 1:21] = 0
    return cells


def test_it_is_the_room_without_the_robots_radius_along_its_walls() -> None:
    assert ground(room()) == pytest.approx(1.6 * 2.6)


@pytest.mark.parametrize(
    ("columns", "gap"),
    [
        pytest.param(slice(22, 60), 0, id="no way through the wall"),
        pytest.param(slice(22, 26), 10, id="a strip behind a gap is narrower than the robot"),
    ],
)
def test_free_ground_behind_a_wall_does_not_count(columns: slice, gap: int) -> None:
    cells = room()
    cells[:, columns] = 0
    cells[10 : 10 + gap, 21] = 0
    assert ground(cells) < ground(room()) + 0.5


def test_another_room_counts_once_its_door_is_open() -> None:
    cells = room()
    cells[:, 22:60] = 0
    cells[10:20, 21] = 0
    assert ground(cells) > 2.0 * ground(room())
