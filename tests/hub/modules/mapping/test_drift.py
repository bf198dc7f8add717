"""A corrected pose brings new evidence back to where the walls are."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from hub.modules.mapping.grid import OccupancyGrid
from hub.pose import Pose
from hub.sim.arena import Arena
from tests.hub.modules.mapping.touring import (
    BEAMS,
    Floats,
    PoseSource,
    Report,
    Score,
    mapped,
    score,
    surfaces_in_sight,
    tour,
    true_pose,
)
from tests.hub.sim.arenas import arena_of
from tests.support.magellan import SimulatedMagellan

ROOM = """
name = "room"
[start]
at = [0.6, 0.6]
[hall]
[[wall]]
from = [0.0, 0.0]
to = [4.0, 0.0]
[[wall]]
from = [4.0, 0.0]
to = [4.0, 3.0]
[[wall]]
from = [0.0, 3.0]
to = [4.0, 3.0]
[[wall]]
from = [0.0, 0.0]
to = [0.0, 3.0]
[[box]]
at = [2.0, 1.5]
size = [1.2, 0.6, 1.0]
"""
ROUND = ((3.4, 0.6), (3.4, 2.4), (0.6, 2.4), (0.6, 0.6))


@pytest.fixture(scope="module")
def arena() -> Arena:
    return arena_of(ROOM)


@pytest.fixture(scope="module")
def reports(arena: Arena) -> list[Report]:
    robot = SimulatedMagellan(arena, seed=1)
    driven = list(tour(robot, ROUND * 3))
    assert robot.ground_truth().contacts == 0
    return driven


@pytest.fixture(scope="module")
def surfaces(arena: Arena, reports: list[Report]) -> Floats:
    """One round sees all that there is to see."""
    return surfaces_in_sight(reports[: len(reports) // 3], arena)


Result = Callable[[list[Report], Callable[[Report], Pose]], Score]


@pytest.fixture(scope="module")
def result(arena: Arena, surfaces: Floats) -> Result:
    return lambda reports, source: score(
        mapped(reports, source, OccupancyGrid(0.05, 14.0, BEAMS)), arena, surfaces
    )


@pytest.fixture(scope="module")
def two_rounds(reports: list[Report]) -> list[Report]:
    return reports[: len(reports) * 2 // 3]


@pytest.fixture(scope="module")
def drifting(arena: Arena, two_rounds: list[Report], result: Result) -> Score:
    """Of a map that two rounds without a landmark made."""
    return result(two_rounds, PoseSource(arena.start, math.inf))


def test_with_true_poses_the_map_is_true(
    arena: Arena, reports: list[Report], result: Result
) -> None:
    made = result(reports[: len(reports) // 3], true_pose(arena.start))
    assert made.wall_error < 0.05
    assert made.f1 > 0.9


def test_landmarks_keep_a_map_from_drifting_away(
    arena: Arena, two_rounds: list[Report], drifting: Score, result: Result
) -> None:
    corrected = result(two_rounds, PoseSource(arena.start, 8.0))
    assert drifting.wall_error > 0.12
    assert corrected.wall_error < 0.5 * drifting.wall_error
    assert corrected.f1 > drifting.f1 + 0.4


def test_after_a_late_correction_the_map_heals(
    arena: Arena, reports: list[Report], two_rounds: list[Report], drifting: Score, result: Result
) -> None:
    """Two rounds without a landmark, then one: the next round puts the walls right again."""
    healed = result(reports, PoseSource(arena.start, reports[len(two_rounds)].time))
    assert healed.wall_error < 0.7 * drifting.wall_error
    assert healed.f1 > drifting.f1 + 0.3
