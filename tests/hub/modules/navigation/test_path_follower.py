"""A simulated robot with its real sensors: what the pilot lets it do, and where it takes it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from hub.gcm.geometry import Twist
from hub.gcm.navigation import Assistance, GoalCommand, Point, Task, TurnCommand
from hub.gcm.outline import corners
from hub.grids.grid import Grid
from hub.modules.navigation.assistance import LAPSE_S
from hub.modules.navigation.path_follower import PathFollower, known_part
from hub.modules.navigation.sweeps import Sweep
from hub.pose import Pose, wrapped
from hub.sim.arena import Arena, load_arena
from tests.hub.modules.navigation.bodies import LONG
from tests.hub.modules.navigation.drives import BODY, Drive, random_start
from tests.support.footprints import distances
from tests.support.messages import drive_state
from tests.support.repetitions import repetitions

EMPTY = load_arena("empty")
YELLOW = load_arena("yellow")


def goal(
    *places: tuple[float, float], theta: float = math.nan, patience: float = math.nan
) -> GoalCommand:
    points = tuple(Point(x=x, y=y) for x, y in places)
    return GoalCommand(points=points, theta=theta, patience=patience)


@pytest.mark.parametrize("seed", range(repetitions(4, 40)))
def test_full_speed_ahead_from_anywhere_touches_nothing(seed: int) -> None:
    drive = Drive(YELLOW, random_start(YELLOW, seed), seed)
    drive.push(0.5, 0.0, 6.0)
    assert drive.truth.contacts == 0


@pytest.mark.parametrize("seed", range(100, 100 + repetitions(2, 20)))
def test_full_speed_back_from_anywhere_touches_nothing(seed: int) -> None:
    drive = Drive(YELLOW, random_start(YELLOW, seed), seed)
    drive.push(-0.5, 0.0, 5.0)
    assert drive.truth.contacts == 0


def at_a_wall() -> Drive:
    """Pushed against the hall's north wall."""
    drive = Drive(EMPTY, Pose(x=0.0, y=9.0, theta=math.pi / 2.0))
    drive.push(0.5, 0.0, 4.0)
    assert drive.pilot.held_back == 1.0
    return drive


def test_at_a_wall_it_stands_still_and_can_turn_and_back_off() -> None:
    drive = at_a_wall()
    before = drive.truth
    drive.push(0.5, 0.0, 2.0)
    assert abs(drive.truth.y - before.y) < 0.01
    drive.push(0.0, 1.0, 1.0)
    assert drive.truth.theta - before.theta > 0.5
    drive.push(-0.5, 0.0, 1.0)
    assert math.hypot(drive.truth.x - before.x, drive.truth.y - before.y) > 0.2
    assert drive.truth.contacts == 0


def test_it_gets_through_a_doorway() -> None:
    drive = Drive(YELLOW, Pose(x=5.25, y=5.0, theta=math.pi / 2.0))
    drive.push(0.5, 0.0, 4.5)
    assert drive.truth.y > 6.5
    assert drive.truth.contacts == 0


def test_without_assistance_it_follows_into_the_wall_and_that_lapses() -> None:
    drive = at_a_wall()
    drive.pilot.assist(Assistance.OFF, drive.now)
    drive.push(0.5, 0.0, 1.0)
    assert drive.truth.contacts
    drive.robot.command(Twist())
    assert drive.pilot.assistance(drive.now + LAPSE_S - 0.1) is Assistance.OFF
    assert drive.pilot.assistance(drive.now + LAPSE_S + 0.1) is Assistance.ON


def test_in_the_open_nothing_is_held_back() -> None:
    drive = Drive(EMPTY, EMPTY.start)
    drive.push(0.5, 0.2, 1.0)
    assert drive.pilot.held_back < 0.01
    assert drive.truth.linear > 0.48


@pytest.mark.parametrize("place", [(2.0, 0.0), (1.0, 1.5), (-1.5, 0.5)])
def test_a_goal_is_reached_with_its_heading(place: tuple[float, float]) -> None:
    drive = Drive(EMPTY, EMPTY.start)
    drive.push(0.0, 0.0, 0.1)
    drive.pilot.go(goal(place, theta=1.0), 7, drive.now)
    drive.carry_out(30.0)
    assert drive.pilot.task.state is Task.REACHED
    pose = drive.pilot.pose
    assert math.dist((pose.x, pose.y), place) < 0.2
    assert pose.theta == pytest.approx(1.0, abs=0.1)


def test_a_turn_is_turned() -> None:
    drive = Drive(EMPTY, EMPTY.start)
    drive.push(0.0, 0.0, 0.1)
    drive.pilot.turn(TurnCommand(angle=-2.0), 7, drive.now)
    drive.carry_out(20.0)
    assert drive.pilot.task.state is Task.REACHED
    assert drive.pilot.pose.theta == pytest.approx(-2.0, abs=0.1)


def test_behind_a_wall_it_is_blocked_without_a_map_and_touches_nothing() -> None:
    drive = Drive(YELLOW, Pose(x=6.0, y=5.0, theta=math.pi / 2.0))
    drive.push(0.0, 0.0, 0.1)
    drive.pilot.go(goal((3.0, 0.0), patience=1.0), 7, drive.now)
    drive.carry_out(60.0)
    assert drive.pilot.task.state is Task.BLOCKED
    assert drive.truth.contacts == 0


def test_with_a_map_it_finds_the_way_around() -> None:
    start = Pose(x=6.0, y=5.0, theta=math.pi / 2.0)
    drive = Drive(YELLOW, start)
    drive.push(0.0, 0.0, 0.1)
    drive.pilot.go(goal((2.5, 0.0)), 7, drive.now)
    drive.pilot.mapped(seen_from(YELLOW, start), drive.now)
    assert drive.pilot.task.route is not None
    drive.carry_out(90.0)
    assert drive.pilot.task.state is Task.REACHED
    assert drive.truth.contacts == 0


def test_it_finds_a_way_round_a_wall_that_the_map_does_not_show() -> None:
    # The map lacks the inner wall east of the doorway between corridor and living room.
    start = Pose(x=6.0, y=5.0, theta=math.pi / 2.0)
    drive = Drive(YELLOW, start)
    drive.push(0.0, 0.0, 0.1)
    whole = seen_from(YELLOW, start)
    column = whole.cell(1.0, 0.0)[1]
    whole.cells[:, column - 3 : column + 4] = 0
    drive.pilot.go(goal((1.9, 0.0)), 7, drive.now)
    drive.pilot.mapped(whole, drive.now)
    route = drive.pilot.task.route
    assert route is not None
    assert max(abs(y) for _, y in route.way) < 0.5, "through the wall"
    drive.carry_out(60.0)
    assert drive.pilot.task.state is Task.REACHED
    assert drive.truth.contacts == 0


def test_the_pose_is_put_right_by_what_is_seen_of_the_map() -> None:
    start = Pose(x=4.1, y=5.4, theta=math.pi / 2.0)
    drive = Drive(YELLOW, start)
    drive.push(0.0, 0.0, 0.1)
    true_map = seen_from(YELLOW, start)
    drive.pilot.correction.odom = Pose(x=0.12, y=-0.1, theta=0.12)
    for _ in range(8):
        drive.pilot.mapped(true_map, drive.now)
        drive.push(0.0, 0.3, 1.5)
    drive.pilot.mapped(true_map, drive.now)
    thought, truth = drive.pilot.pose, drive.truth
    true_x, true_y = truth.y - start.y, start.x - truth.x
    # Walls of this map are solid and 10 cm thick: a point fits anywhere in them.
    assert math.hypot(thought.x - true_x, thought.y - true_y) < 0.1
    assert abs(wrapped(thought.theta - (truth.theta - start.theta))) < 0.05


def seen_from(arena: Arena, start: Pose) -> Grid:
    """The arena as a grid in the frame of a robot that starts there, looking north."""
    side, resolution = 200, 0.05
    middles = (np.arange(side) + 0.5) * resolution - 5.0
    ahead, left = np.meshgrid(middles, middles)
    inside = distances(arena.footprints, start.x - left, start.y + ahead) <= 0.0
    cells = np.where(inside, 100, 0).astype(np.int8)
    return Grid(cells=cells, resolution=resolution, origin_x=-5.0, origin_y=-5.0)


def test_only_the_known_part_of_a_map_is_worked_on() -> None:
    cells = np.full((50, 60), -1, dtype=np.int8)
    assert known_part(Grid(cells=cells, resolution=0.1, origin_x=1.0, origin_y=2.0)) is None
    cells[10, 20], cells[14, 22] = 0, 100
    part = known_part(Grid(cells=cells, resolution=0.1, origin_x=1.0, origin_y=2.0))
    assert part is not None
    assert part.cells.shape == (5, 3)
    assert (part.cells[0, 0], part.cells[4, 2]) == (0, 100)
    assert (part.origin_x, part.origin_y) == pytest.approx((3.0, 3.0))


def test_where_the_whole_map_shows_no_way_it_waits_as_long_as_it_has_patience() -> None:
    cells = np.zeros((100, 100), dtype=np.int8)
    ring = np.arange(100)
    around = np.hypot(ring[:, None] - 90.0, ring - 50.0)
    cells[(around > 6.0) & (around < 9.0)] = 100
    grid = Grid(cells=cells, resolution=0.05, origin_x=-2.5, origin_y=-2.5)
    drive = Drive(EMPTY, EMPTY.start)
    drive.push(0.0, 0.0, 0.1)
    drive.pilot.go(goal((0.0, 2.0)), 7, drive.now)
    part = drive.pilot.window
    assert part is not None
    assert part.height > 2.0
    drive.pilot.mapped(grid, drive.now)
    assert drive.pilot.task.active
    whole = drive.pilot.window
    assert whole is not None
    assert math.isnan(whole.x)
    drive.pilot.mapped(grid, drive.now)
    drive.carry_out(3.0)
    assert drive.pilot.task.why == "waits: the map shows no way there"
    assert drive.truth.linear == pytest.approx(0.0, abs=0.01)
    cells[around < 9.0] = 0  # who stood in the way has gone
    drive.pilot.mapped(grid, drive.now)
    drive.carry_out(3.0)
    assert drive.truth.linear > 0.1
    cells[(around > 6.0) & (around < 9.0)] = 100
    drive.pilot.go(goal((0.0, 2.0), patience=0.01), 7, drive.now)
    for _ in range(2):
        drive.pilot.mapped(grid, drive.now)
    drive.carry_out(1.0)
    assert drive.pilot.task.state is Task.BLOCKED
    assert drive.pilot.task.why == "the map shows no way there"


def test_a_long_robot_plans_through_a_corridor_that_its_circle_does_not_fit() -> None:
    cells = np.zeros((80, 80), dtype=np.int8)
    cells[:, 30:50] = 100
    cells[35:45, 30:50] = 0  # 50 cm wide
    grid = Grid(cells=cells, resolution=0.05, origin_x=-1.0, origin_y=-2.0)
    routes = []
    for body in (LONG, dataclasses.replace(LONG, footprint=())):
        outline = Sweep(corners(body)) if body.footprint else None
        limits = dataclasses.replace(BODY, radius=body.radius, outline=outline)
        pilot = PathFollower(limits, body)
        pilot.reported(drive_state(), 0.0, 0.0)
        pilot.go(goal((2.5, 0.0)), 7, 0.0)
        pilot.mapped(grid, 0.0)
        routes.append(pilot.task.route)
    assert routes[0] is not None
    assert routes[1] is None
