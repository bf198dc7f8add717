"""Where maps end."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from hub.grids.frontiers import edge_cells, frontiers, groups
from hub.grids.grid import Grid
from tests.hub.grids.grid_maps import drawn, maps

HALL = drawn(
    "####################",
    "#........?????.....?",
    "#........?????.....?",
    "#........#####.....?",
    "#........#...#.....?",
    "#........#...#.....?",
    "#........#####.....?",
    "#..................?",
    "#..................?",
    "##?????#############",
    "???????????????????#",
    "????????????????????",
)


def test_each_opening_is_one_frontier_with_its_length_and_the_way_to_it() -> None:
    found = frontiers(HALL, (0.45, 0.45), radius=0.05, reach=0.1, shortest=0.15)
    end, below, *sides = found
    assert [frontier.length for frontier in found] == pytest.approx([0.8, 0.5, 0.2, 0.2])
    assert end.x > 1.6
    assert 1.1 < end.distance < 2.0
    assert below.y < 0.5
    assert below.distance < 0.3
    assert {side.x < 1.2 for side in sides} == {True, False}


def test_a_frontier_behind_a_gap_that_is_too_narrow_cannot_be_reached() -> None:
    found = frontiers(HALL, (0.45, 0.55), radius=0.25, reach=0.1, squeeze=1.0)
    assert any(math.isinf(frontier.distance) for frontier in found)
    assert any(math.isfinite(frontier.distance) for frontier in found)


def test_a_frontier_behind_a_wall_is_not_seen_from_this_side() -> None:
    wall = drawn("?????????", "#........", "#########", "#.......#", "#.......#", "#########")
    (behind,) = frontiers(wall, (0.15, 0.15), radius=0.05, reach=0.3, shortest=0.3)
    assert math.isinf(behind.distance)
    (through,) = frontiers(wall, (0.15, 0.15), radius=0.05, reach=0.3, shortest=0.3, in_sight=False)
    assert (through.length, through.y) == (behind.length, pytest.approx(0.25))
    (ahead,) = frontiers(wall, (0.15, 0.45), radius=0.05, reach=0.3, shortest=0.3)
    assert math.isfinite(ahead.distance)


def test_a_map_that_ends_with_free_ground_has_its_frontier_there() -> None:
    (around,) = frontiers(drawn(*["......"] * 6), (0.25, 0.25), radius=0.1)
    assert around.length == pytest.approx(2.0)


def test_specks_of_the_unknown_are_no_frontier() -> None:
    speckled = drawn("#######", "#.....#", "#..?..#", "#..?..#", "#.....#", "#######")
    assert frontiers(speckled, (0.15, 0.15), radius=0.0) == ()


def test_a_robot_outside_the_map_sees_no_frontier() -> None:
    assert frontiers(HALL, (50.0, 0.0), radius=0.1) == ()
    assert frontiers(HALL, (math.nan, 0.0), radius=0.1) == ()


@given(maps(walls=0.5))
def test_frontiers_are_free_ground_beside_the_unknown(grid: Grid) -> None:
    edge = edge_cells(grid)
    around = np.pad(grid.cells, 1, constant_values=-1)
    for row, column in np.argwhere(edge):
        assert grid.free[row, column]
        cross = around[row : row + 3, column + 1], around[row + 1, column : column + 3]
        assert min(part.min() for part in cross) == -1
    start = grid.centre(grid.height_cells // 2, grid.width_cells // 2)
    found = frontiers(grid, start, radius=0.0)
    assert sum(frontier.length for frontier in found) == pytest.approx(0.1 * edge.sum())
    assert all(grid.contains(*grid.cell(frontier.x, frontier.y)) for frontier in found)


@given(maps(walls=0.6))
def test_groups_are_what_hangs_together(grid: Grid) -> None:
    cells = np.argwhere(grid.free)
    if not len(cells):
        return
    names = groups(cells, grid.cells.shape)
    place = {tuple(cell): name for cell, name in zip(cells.tolist(), names.tolist(), strict=True)}
    unseen = set(place)
    islands = 0
    while unseen:
        islands += 1
        open_cells = [unseen.pop()]
        name = place[open_cells[0]]
        while open_cells:
            row, column = open_cells.pop()
            assert place[row, column] == name
            for other in [(row + d, column + r) for d in (-1, 0, 1) for r in (-1, 0, 1)]:
                if other in unseen:
                    unseen.remove(other)
                    open_cells.append(other)
    assert len(set(names.tolist())) == islands


def test_ground_behind_a_frontier_is_where_the_robot_may_stand() -> None:
    hall = np.full((60, 60), -1, np.int8)
    hall[20:40, 10:30] = 0
    hall[19:41, 9] = hall[19, 9:30] = hall[40, 9:30] = 100
    open_hall = Grid(cells=hall, resolution=0.1, origin_x=0.0, origin_y=0.0)
    (room,) = frontiers(open_hall, (2.0, 3.0), radius=0.25, shortest=0.3)
    assert room.gain > 4.0
    niche = hall.copy()
    niche[19:41, 34] = niche[19, 30:35] = niche[40, 30:35] = 100
    (shallow,) = frontiers(
        Grid(cells=niche, resolution=0.1, origin_x=0.0, origin_y=0.0),
        (2.0, 3.0), radius=0.25, shortest=0.3,
    )  # fmt: skip
    assert 0.1 < shallow.gain < 1.0
    crack = hall.copy()
    crack[19:41, 32] = 100
    (slit,) = frontiers(
        Grid(cells=crack, resolution=0.1, origin_x=0.0, origin_y=0.0),
        (2.0, 3.0), radius=0.25, shortest=0.3,
    )  # fmt: skip
    assert slit.gain < 0.5
