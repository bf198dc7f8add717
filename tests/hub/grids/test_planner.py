"""Ways over maps: never too near to obstacles, never dearer than they have to be."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.grids.clearance import clearance
from hub.grids.costs import Caution, crossing
from hub.grids.grid import Grid
from hub.grids.planner import Way, line_cost, plan
from hub.grids.wavefront import spread
from tests.hub.grids.grid_maps import drawn, maps

ROOM = drawn(
    "####################",
    "#..................#",
    "#..................#",
    "#..................#",
    "#..................#",
    "##########.....#####",
    "#..................#",
    "#..................#",
    "#..................#",
    "#..................#",
    "####################",
)


def crossed(grid: Grid, way: Way) -> set[tuple[int, int]]:
    """Cells that a way leads through."""
    cells = set()
    for (x0, y0), (x1, y1) in itertools.pairwise(way):
        count = max(2, math.ceil(math.hypot(x1 - x0, y1 - y0) / (0.05 * grid.resolution)))
        for part in np.linspace(0.0, 1.0, count):
            x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
            # On a border between cells neither counts: rounding decides which it would be.
            sides = ((x - grid.origin_x) / 0.1 % 1.0, (y - grid.origin_y) / 0.1 % 1.0)
            if all(1e-6 < side < 1.0 - 1e-6 for side in sides):
                cells.add(grid.cell(x, y))
    return cells


@st.composite
def tasks(draw: st.DrawFn) -> tuple[Grid, tuple[int, int], tuple[int, int]]:
    """A map, and two cells of it."""
    grid = draw(maps(walls=0.15))

    def cell() -> tuple[int, int]:
        row = draw(st.integers(0, grid.height_cells - 1))
        return row, draw(st.integers(0, grid.width_cells - 1))

    return grid, cell(), cell()


@given(tasks(), st.floats(0.0, 0.25))
def test_a_way_keeps_off_obstacles(
    task: tuple[Grid, tuple[int, int], tuple[int, int]], radius: float
) -> None:
    grid, start, goal = task
    way = plan(
        grid, grid.centre(*start), grid.centre(*goal), radius=radius, squeeze=1.0, tolerance=0.0
    )
    if way is None:
        return
    assert way[0] == grid.centre(*start)
    assert way[-1] == grid.centre(*goal)
    distance = clearance(grid.occupied, grid.resolution, 1.0)
    for cell in crossed(grid, way):
        inside = grid.contains(*cell)
        near_start = math.dist(cell, start) <= math.ceil(radius / 0.1) + 1
        assert not inside or distance[cell] >= radius or near_start


@given(tasks())
def test_a_way_costs_hardly_more_than_the_cheapest(
    task: tuple[Grid, tuple[int, int], tuple[int, int]],
) -> None:
    grid, start, goal = task
    caution = Caution(radius=0.1)
    way = plan(
        grid,
        grid.centre(*start),
        grid.centre(*goal),
        radius=caution.radius,
        unknown_cost=caution.unknown,
        squeeze=1.0,
        tolerance=0.0,
    )
    wide = grid.covering((grid.centre(*start), grid.centre(*goal)), 1.0)
    assert wide is not None
    first, last = wide.cell(*grid.centre(*start)), wide.cell(*grid.centre(*goal))
    factors = crossing(wide, first, caution)
    cheapest = spread(factors, first)[last]
    if way is None:
        assert not math.isfinite(cheapest)
        return
    cells = [wide.cell(*point) for point in way]
    cost = sum(line_cost(factors, a, b) for a, b in itertools.pairwise(cells))
    assert cost <= 1.02 * cheapest + 1e-9


@given(st.integers(-12, 12), st.integers(-12, 12))
def test_a_line_over_even_ground_costs_its_length(down: int, right: int) -> None:
    factors = np.full((25, 25), 3.0)
    cost = line_cost(factors, (12, 12), (12 + down, 12 + right))
    assert cost == pytest.approx(3.0 * math.hypot(down, right))


def test_a_way_leads_through_the_door() -> None:
    way = plan(ROOM, (0.25, 0.25), (0.25, 0.85), radius=0.15)
    assert way is not None
    assert any(0.95 < x < 1.55 for x, _ in way)
    assert len(way) < 8


def test_a_robot_that_is_too_wide_for_the_door_has_no_way() -> None:
    assert plan(ROOM, (0.25, 0.25), (0.25, 0.85), radius=0.35, squeeze=1.0) is None


def test_a_door_that_is_narrow_on_the_map_is_tried_if_there_is_no_other() -> None:
    assert plan(ROOM, (0.25, 0.25), (0.25, 0.85), radius=0.35) is not None
    assert plan(ROOM, (0.25, 0.25), (0.25, 0.85), radius=0.35, squeeze=0.95) is None
    two = drawn("..........", "..........", "#.####...#", "..........", "..........")
    way = plan(two, (0.15, 0.05), (0.15, 0.45), radius=0.15, unknown_cost=math.inf)
    assert way is not None
    assert max(x for x, _ in way) > 0.6, "the wide door, though it is farther"


def test_open_ground_is_crossed_in_one_line() -> None:
    empty = drawn(*["." * 30] * 20)
    assert plan(empty, (0.31, 0.42), (2.57, 1.33), radius=0.2) == ((0.31, 0.42), (2.57, 1.33))


def test_a_way_stays_in_the_middle_of_a_corridor() -> None:
    corridor = drawn("#" * 40, *["." * 40] * 9, "#" * 40)
    way = plan(corridor, (0.25, 0.25), (3.75, 0.25), radius=0.15)
    assert way is not None
    rows = {row for row, column in crossed(corridor, way) if 8 < column < 32}
    assert rows <= {4, 5, 6}


def test_a_robot_beside_a_wall_gets_out() -> None:
    way = plan(ROOM, (0.15, 0.15), (1.75, 0.25), radius=0.2)
    assert way is not None


def test_a_robot_that_the_map_has_inside_a_wall_gets_out() -> None:
    way = plan(ROOM, (0.05, 0.25), (1.75, 0.25), radius=0.15)
    assert way is not None


def test_a_goal_inside_a_wall_is_approached() -> None:
    way = plan(ROOM, (0.25, 0.25), (1.95, 0.25), radius=0.15, tolerance=0.3)
    assert way is not None
    assert math.dist(way[-1], (1.95, 0.25)) <= 0.3
    assert plan(ROOM, (0.25, 0.25), (1.95, 0.25), radius=0.15, squeeze=1.0, tolerance=0.0) is None


def test_the_unknown_is_gone_around_or_not_entered() -> None:
    dark = drawn(*["." * 20] * 4, *["....????????????????"] * 12, *["." * 20] * 4)
    around = plan(dark, (1.85, 0.25), (1.85, 1.75), radius=0.1, unknown_cost=10.0)
    assert around is not None
    assert any(x < 0.5 for x, _ in around)
    through = plan(dark, (1.85, 0.25), (1.85, 1.75), radius=0.1, unknown_cost=0.1)
    assert through is not None
    assert all(x > 0.5 for x, _ in through)
    sealed = drawn("....", "????", "....")
    across = {"radius": 0.0, "tolerance": 0.0}
    assert plan(sealed, (0.15, 0.05), (0.15, 0.25), **across, unknown_cost=math.inf) is None
    assert plan(sealed, (0.15, 0.05), (0.15, 0.25), **across, unknown_cost=5.0) is not None


def test_a_goal_beyond_the_map_is_reached_through_the_unknown() -> None:
    way = plan(drawn("..", ".."), (0.05, 0.05), (3.0, -2.0), radius=0.1)
    assert way is not None
    assert way[-1] == (3.0, -2.0)


@pytest.mark.parametrize("goal", [(math.nan, 0.0), (0.0, math.inf), (1e7, 0.0)])
def test_a_goal_that_is_nowhere_has_no_way(goal: tuple[float, float]) -> None:
    assert plan(ROOM, (0.25, 0.25), goal, radius=0.1) is None
