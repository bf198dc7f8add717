"""What has held the robot up is on the map that ways are planned on, for a while."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from hub.grids.grid import Grid
from hub.grids.planner import plan
from hub.modules.navigation.unmapped_obstacles import HELD_S, REMEMBERED_S, WIDER, UnmappedObstacles

FREE = Grid(cells=np.zeros((80, 80), np.int8), resolution=0.05, origin_x=-2.0, origin_y=-2.0)


def test_a_robot_is_held_up_that_stands_for_a_while() -> None:
    hindrances = UnmappedObstacles()
    assert not hindrances.held(still=True, now=1.0)
    assert not hindrances.held(still=True, now=1.0 + 0.5 * HELD_S)
    assert hindrances.held(still=True, now=1.0 + HELD_S)
    assert not hindrances.held(still=True, now=1.0 + 1.5 * HELD_S), "once for each time"
    assert hindrances.held(still=True, now=1.0 + 2.0 * HELD_S)


def test_a_robot_that_goes_on_is_not_held_up() -> None:
    hindrances = UnmappedObstacles()
    hindrances.held(still=True, now=1.0)
    hindrances.held(still=False, now=1.0 + 0.5 * HELD_S)
    assert not hindrances.held(still=True, now=1.0 + HELD_S)


def test_ways_lead_round_what_was_in_the_way_and_keep_farther_from_it() -> None:
    hindrances = UnmappedObstacles()
    hindrances.note(np.zeros(1), np.zeros(1), 0.0)
    grid = hindrances.onto(FREE, 1.0)
    way = plan(grid, (-1.0, 0.0), (1.0, 0.0), radius=0.25, comfort=0.0)
    assert way is not None
    off = np.hypot(*np.concatenate([np.linspace(a, b) for a, b in pairwise(way)]).T)
    assert off.min() >= 0.25 + WIDER - 0.05
    assert not FREE.occupied.any(), "the map itself stays as it was"


def test_what_was_in_the_way_is_forgotten() -> None:
    hindrances = UnmappedObstacles()
    hindrances.note(np.zeros(1), np.zeros(1), 0.0)
    assert hindrances.onto(FREE, REMEMBERED_S - 1.0) is not FREE
    assert hindrances.onto(FREE, REMEMBERED_S + 1.0) is FREE
    hindrances.note(np.zeros(1), np.zeros(1), 0.0)
    hindrances.forget()
    assert hindrances.onto(FREE, 1.0) is FREE


def test_what_lies_outside_of_a_map_changes_nothing() -> None:
    hindrances = UnmappedObstacles()
    hindrances.note(np.array([9.0, -9.0]), np.array([0.0, -1e6]), 0.0)
    assert hindrances.onto(FREE, 1.0) is FREE
