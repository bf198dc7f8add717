"""What has held the robot up is on the map that ways are planned on, for a while."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from hub.grids.grid import Grid
from hub.grids.planner import plan
from hub.modules.navigation.unmapped_obstacles import (
    BLOCKED_S,
    REMEMBERED_S,
    WIDER,
    UnmappedObstacles,
)

FREE = Grid(cells=np.zeros((80, 80), np.int8), resolution=0.05, origin_x=-2.0, origin_y=-2.0)


def test_a_robot_is_held_up_that_stands_for_a_while() -> None:
    obstacles = UnmappedObstacles()
    assert not obstacles.blocked(still=True, now=1.0)
    assert not obstacles.blocked(still=True, now=1.0 + 0.5 * BLOCKED_S)
    assert obstacles.blocked(still=True, now=1.0 + BLOCKED_S)
    assert not obstacles.blocked(still=True, now=1.0 + 1.5 * BLOCKED_S), "once for each time"
    assert obstacles.blocked(still=True, now=1.0 + 2.0 * BLOCKED_S)


def test_a_robot_that_goes_on_is_not_held_up() -> None:
    obstacles = UnmappedObstacles()
    obstacles.blocked(still=True, now=1.0)
    obstacles.blocked(still=False, now=1.0 + 0.5 * BLOCKED_S)
    assert not obstacles.blocked(still=True, now=1.0 + BLOCKED_S)


def test_ways_lead_round_what_was_in_the_way_and_keep_farther_from_it() -> None:
    obstacles = UnmappedObstacles()
    obstacles.note(np.zeros(1), np.zeros(1), 0.0)
    grid = obstacles.onto(FREE, 1.0)
    way = plan(grid, (-1.0, 0.0), (1.0, 0.0), radius=0.25, comfort=0.0)
    assert way is not None
    off = np.hypot(*np.concatenate([np.linspace(a, b) for a, b in pairwise(way)]).T)
    assert off.min() >= 0.25 + WIDER - 0.05
    assert not FREE.occupied.any(), "the map itself stays as it was"


def test_what_was_in_the_way_is_forgotten() -> None:
    obstacles = UnmappedObstacles()
    obstacles.note(np.zeros(1), np.zeros(1), 0.0)
    assert obstacles.onto(FREE, REMEMBERED_S - 1.0) is not FREE
    assert obstacles.onto(FREE, REMEMBERED_S + 1.0) is FREE
    obstacles.note(np.zeros(1), np.zeros(1), 0.0)
    obstacles.forget()
    assert obstacles.onto(FREE, 1.0) is FREE


def test_what_lies_outside_of_a_map_changes_nothing() -> None:
    obstacles = UnmappedObstacles()
    obstacles.note(np.array([9.0, -9.0]), np.array([0.0, -1e6]), 0.0)
    assert obstacles.onto(FREE, 1.0) is FREE
