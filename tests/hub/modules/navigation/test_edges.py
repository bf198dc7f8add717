"""A robot with beams to the ground stops before edges, and only before these."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hub.gcm.navigation import Assistance, GoalCommand, Point, Task
from hub.grids.grid import Grid
from hub.modules.navigation.problems import known_edges, problems
from hub.pose import Pose
from hub.sim.arena import Arena, load_arena
from tests.hub.modules.navigation.drives import TRACKED_ROBOT, Drive, random_start
from tests.hub.sim.ground.grounds import block, ground_arena, ramp

HALF_LENGTH = 0.33
TABLE = block(0.0, 0.5, length=2.5)
"""A raised floor that ends at x = 2.5."""


def drive(arena: Arena, start: Pose, *, assisted: bool = True) -> Drive:
    made = Drive(arena, start, robot=TRACKED_ROBOT)
    if not assisted:
        made.pilot.assist(Assistance.OFF, 0.0)
    return made


def names(made: Drive) -> list[str]:
    return [each.name for each in problems(made.pilot, made.now)]


@pytest.mark.parametrize("linear", [0.3, 0.6, -0.6])
def test_an_assisted_robot_stops_before_an_edge(linear: float) -> None:
    made = drive(ground_arena(TABLE), Pose(x=0.8, y=1.5, theta=0.0 if linear > 0 else math.pi))
    made.push(linear, 0.0, 8.0)
    assert 0.02 < 2.5 - (made.truth.x + HALF_LENGTH) < 0.3
    assert made.truth.z == pytest.approx(0.5, abs=0.01)
    assert made.given.neutral
    assert made.pilot.held_back == 1.0
    assert names(made) == ["edge"]
    x, y = made.pilot.edges
    x = x[(abs(y) < 0.5) & (x * linear > 0.0)]
    assert abs(abs(x) - (2.5 - made.truth.x)).max() < 0.1
    assert len(known_edges(made.pilot).cells) >= len(x) > 5


@pytest.mark.parametrize("assisted", [True, False])
def test_on_the_deck_of_the_orange_arena(*, assisted: bool) -> None:
    """Up the ramp to the deck, a turn to the north, and on to the deck's edge at y = 2.7."""
    made = drive(load_arena("orange"), Pose(x=6.6, y=0.95))
    made.push(0.4, 0.0, 6.0)
    assert made.truth.x > 7.75
    made.push(0.0, 0.8, 0.5 * math.pi / 0.8)
    if not assisted:
        made.pilot.assist(Assistance.OFF, made.now)
    made.push(0.4, 0.0, 8.0)
    if assisted:
        assert made.truth.z == pytest.approx(0.96, abs=0.01)
        assert 2.2 < made.truth.y + HALF_LENGTH < 2.7
    else:
        assert made.truth.z < 0.9


def test_without_assistance_it_falls() -> None:
    made = drive(ground_arena(TABLE), Pose(x=0.8, y=1.5), assisted=False)
    made.push(0.4, 0.0, 8.0)
    assert made.truth.z < 0.4


def test_from_the_edge_it_turns_and_backs_off() -> None:
    made = drive(ground_arena(TABLE), Pose(x=0.8, y=1.5))
    made.push(0.6, 0.0, 8.0)
    stopped = made.truth.x
    made.push(-0.4, 0.0, 1.5)
    assert made.truth.x < stopped - 0.4
    made.push(0.0, 0.8, 1.5)
    assert abs(made.truth.theta) > 0.8


@pytest.mark.parametrize(("degrees", "linear"), [(20.0, 0.5), (15.0, -0.5)])
def test_ramps_are_no_edges(degrees: float, linear: float) -> None:
    top = 2.0 * math.tan(math.radians(degrees))
    ground = ramp(degrees).replace("length = 3.0", "")
    ground += f'[[ramp]]\nat = [6.5, 0.0]\nsize = [2.0, 3.0]\nrises = "west"\nhigh = {top}\n'
    made = drive(ground_arena(ground), Pose(x=0.6, y=1.5, theta=0.0 if linear > 0 else math.pi))
    made.push(linear, 0.0, 38.0)
    assert made.truth.x > 8.5, made.truth


def test_on_level_ground_no_edge_is_known() -> None:
    arena = load_arena("yellow")
    for seed in range(2):
        made = drive(arena, random_start(arena, seed, 0.3))
        for linear, angular in ((0.5, 0.3), (0.0, 1.0), (-0.5, 0.0), (0.5, -0.5)):
            made.push(linear, angular, 2.0)
            assert not known_edges(made.pilot).cells


def test_a_tilted_robot_says_so_and_drives_slowly() -> None:
    made = drive(ground_arena(ramp(15.0)), Pose(x=0.6, y=1.5))
    made.push(0.6, 0.0, 4.0)
    assert math.degrees(abs(made.truth.pitch)) > 10.0
    assert names(made) == ["tilt"]
    assert made.given.linear.x == pytest.approx(0.2)
    assert made.pilot.held_back > 0.5


def test_a_tilted_robot_goes_nowhere_by_itself() -> None:
    made = drive(ground_arena(ramp(15.0)), Pose(x=0.6, y=1.5))
    made.push(0.6, 0.0, 4.0)
    before = made.truth.x
    made.pilot.go(GoalCommand(points=(Point(x=6.0, y=0.0),)), 7, made.now)
    made.carry_out(2.0)
    assert made.truth.x == pytest.approx(before, abs=0.02)
    assert "tilted" in made.pilot.task.why
    made.carry_out(70.0)
    assert made.pilot.task.state is Task.CANCELLED


def test_paths_lead_round_a_hole() -> None:
    # A raised floor of 5 m with a hole of 1 by 1 m in its middle.
    ground = block(0.0, 0.5, length=2.5, y=-1.0, width=5.0)
    ground += block(3.5, 0.5, y=-1.0, width=5.0)
    ground += block(2.5, 0.5, length=1.0, y=-1.0, width=2.0)
    ground += block(2.5, 0.5, length=1.0, y=2.0, width=2.0)
    made = drive(ground_arena(ground), Pose(x=0.8, y=1.5))
    grid = Grid(cells=np.zeros((100, 130), np.int8), resolution=0.05, origin_x=-0.8, origin_y=-2.5)
    made.pilot.go(GoalCommand(points=(Point(x=3.6, y=0.0),), patience=60.0), 7, made.now)
    for _ in range(40):
        made.pilot.mapped(grid, made.now)
        made.carry_out(1.5)
        assert made.truth.z == pytest.approx(0.5, abs=0.02)
    assert made.pilot.task.state is Task.REACHED, made.pilot.task.why
