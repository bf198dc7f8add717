"""Exploring maps a whole building, does not insist on what cannot be seen, and comes to an end."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.exploring import Exploration
from hub.gcm.autonomy import Behaviour, Phase
from hub.gcm.navigation import Task
from hub.grids.clearance import clearance
from hub.grids.frontiers import Frontier
from hub.grids.grid import Grid
from hub.grids.planner import line_cost, plan
from hub.modules.autonomy.autonomy_task import Sight, Target
from hub.modules.autonomy.base_line import LONGEST, straight_ahead
from hub.modules.autonomy.exploring import (
    ARRIVED,
    AT_HOME,
    RETURN_SPEED,
    TRIES,
    Explore,
    value,
)
from hub.modules.autonomy.novelty import Limits
from tests.hub.modules.autonomy.scene import RADIUS, Scene, hall

BUILDING = """
####################
#         #        #
#         #        #
#                  #
#                  #
#         #        #
#####  ######  #####
#         #        #
#                  #
#                  #
#         #        #
####################
"""
"""Cells of 0.4 m."""
SIGHT = 2.0


class Explorer(Scene):
    """A robot in the building that sees 2 m around itself, and gets at once where it is sent."""

    def __init__(self) -> None:
        super().__init__()
        rows = BUILDING.strip("\n").splitlines()
        walls = np.array([[letter == "#" for letter in row] for row in rows])
        walls = walls.repeat(4, axis=0).repeat(4, axis=1)
        self.truth = np.where(walls, 100, 0).astype(np.int8)
        self.known = np.full(walls.shape, -1, np.int8)
        self.origin = (-1.0, -1.0)
        self.look()

    def look(self) -> None:
        grid = Grid(cells=self.truth, resolution=0.1, origin_x=-1.0, origin_y=-1.0)
        here = grid.cell(self.x, self.y)
        opaque = np.where(grid.occupied, np.inf, 1.0)
        reach = round(SIGHT / 0.1)
        for row in range(max(here[0] - reach, 0), min(here[0] + reach + 1, len(opaque))):
            for column in range(max(here[1] - reach, 0), min(here[1] + reach + 1, opaque.shape[1])):
                if math.dist((row, column), here) <= reach and self.known[row, column] < 0:
                    before = opaque[row, column]
                    opaque[row, column] = 1.0
                    if math.isfinite(line_cost(opaque, here, (row, column))):
                        self.known[row, column] = self.truth[row, column]
                    opaque[row, column] = before
        self.grid = Grid(cells=self.known.copy(), resolution=0.1, origin_x=-1.0, origin_y=-1.0)

    def travel(self) -> None:
        """Go where the pilot wants."""
        assert self.grid is not None
        way = plan(self.grid, (self.x, self.y), self.targets[-1], radius=RADIUS)
        assert way is not None
        self.x, self.y = way[-1]
        self.look()
        self.end(Task.REACHED)


def test_a_whole_building_is_explored() -> None:
    scene = Explorer()
    scene.ask(Behaviour.EXPLORE)
    for _ in range(60):
        scene.wait(3.0)
        if scene.state.behaviour is Behaviour.HOLD:
            break
        assert scene.state.frontier_m > 0.0 or scene.targets[-1] == (0.0, 0.0)
        scene.travel()
    assert scene.why.startswith("explored: ")
    assert scene.why.endswith("; it is back at its start")
    assert math.hypot(scene.x, scene.y) < AT_HOME
    reachable = clearance(scene.truth >= 65, 0.1, 1.0) >= RADIUS
    known = (scene.known >= 0) & reachable
    assert known.sum() / reachable.sum() > 0.97
    assert 5 <= len(scene.targets) < 30


def test_a_frontier_that_stays_is_given_up_after_some_visits() -> None:
    scene = Scene()
    scene.ask(Behaviour.EXPLORE)
    for _ in range(100):
        scene.wait(1.0)
        if scene.task is Task.GOING:
            scene.arrive()
    assert scene.state.behaviour is Behaviour.HOLD
    assert scene.why.startswith("explored: nothing is left; frontiers: 1 given up; it ")
    assert len([target for target in scene.targets if target != (0.0, 0.0)]) == TRIES


def test_frontiers_that_cannot_be_reached_are_given_up() -> None:
    scene = Scene()
    scene.ask(Behaviour.EXPLORE)
    for _ in range(100):
        scene.wait(1.0)
        if scene.task is Task.GOING:
            scene.end(Task.BLOCKED)
    assert scene.why.startswith("explored: nothing is left; frontiers: 1 given up; it ")
    assert len([target for target in scene.targets if target != (0.0, 0.0)]) == TRIES


def test_another_place_comes_first_while_one_rests() -> None:
    scene = Scene()
    grid = hall(known=30)
    grid.cells[19:21, 1:30] = 100
    grid.cells[19:21, 5:12] = 0
    scene.grid = grid
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    scene.end(Task.BLOCKED)
    scene.wait(3.0)
    first, second = scene.targets
    assert (first[1] < 1.0) != (second[1] < 1.0), "the two halves of the hall"


def test_a_place_where_it_was_in_vain_comes_after_one_that_is_alike() -> None:
    grid = hall(known=30)
    grid.cells[19:21, 1:30] = 100
    grid.cells[19:21, 5:12] = 0
    explore = Explore(RADIUS, Limits())
    first = explore.choose(Sight(x=0.0, y=0.0, grid=grid, fresh=True, now=0.0))
    assert isinstance(first, Target)
    explore.blocked(first, 1, 0.0, "")
    later = Sight(x=0.0, y=0.0, grid=grid, fresh=True, now=99.0)
    second = explore.choose(later)
    assert isinstance(second, Target)
    assert (first.points[0].y < 1.0) != (second.points[0].y < 1.0), "the two halves of the hall"


def test_a_room_behind_a_narrow_door_is_worth_more_than_a_gap_near_by() -> None:
    room = Frontier(x=0.0, y=0.0, length=1.8, distance=20.0, gain=10.0)
    gap = Frontier(x=0.0, y=0.0, length=0.45, distance=1.5, gain=3.0)
    assert value(room) > value(gap)


def test_exploring_begins_straight_ahead_so_that_the_first_walls_are_drawn_true() -> None:
    scene = Scene()
    scene.theta = 0.0
    scene.hears()
    scene.grid = hall(known=60)
    scene.grid.cells[25:, 30:] = -1
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    assert scene.targets == [(pytest.approx(LONGEST, abs=0.11), 0.0)]
    scene.arrive()
    scene.wait(3.0)
    assert len(scene.targets) == 2, "and then to what is unknown"
    assert scene.targets[1][1] > 0.5


def test_a_base_line_that_is_blocked_is_left_for_a_frontier() -> None:
    scene = Scene()
    scene.theta = 0.0
    scene.hears()
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    assert scene.targets == [(pytest.approx(1.9, abs=0.11), 0.0)]
    scene.end(Task.BLOCKED)
    scene.wait(3.0)
    assert len(scene.targets) == 2
    assert scene.why.startswith("explores: ")
    assert "m² of new ground" in scene.why


def test_nothing_straight_ahead_of_a_wall() -> None:
    grid = hall(known=60)
    ahead = straight_ahead(grid, 0.0, 0.0, 0.0, radius=RADIUS, longest=LONGEST)
    assert ahead is not None
    grid.cells[8:12, 16] = 100
    assert straight_ahead(grid, 0.0, 0.0, 0.0, radius=RADIUS, longest=LONGEST) is None
    grid.cells[8:12, 6] = 100
    assert straight_ahead(grid, 0.0, 0.0, math.pi, radius=RADIUS, longest=LONGEST) is None
    assert straight_ahead(grid, 50.0, 0.0, 0.0, radius=RADIUS, longest=LONGEST) is None


def test_a_frontier_that_is_gone_is_not_gone_to() -> None:
    scene = Scene()
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    scene.grid = hall(known=50)
    scene.wait(3.0)
    first, second = scene.targets
    assert second[0] > first[0] + 1.0


def test_a_place_is_looked_at_before_the_next_one_is_chosen() -> None:
    scene = Scene()
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    fresh, scene.grid = hall(known=50), None
    scene.arrive()
    scene.wait(1.0)
    assert scene.why == "looks around"
    assert len(scene.targets) == 1
    scene.grid = fresh
    scene.wait(3.0)
    assert scene.targets[1][0] > scene.targets[0][0] + 1.0


def test_of_two_alike_the_nearer_one_is_explored_first() -> None:
    for x in (0.5, 3.5):
        scene = Scene()
        grid = hall(width=52, known=51)
        grid.cells[:, 0] = 0
        grid.cells[:, 50] = 0
        scene.grid = Grid(cells=grid.cells[:, :51], resolution=0.1, origin_x=-1.0, origin_y=-1.0)
        scene.x = x
        scene.hears()
        scene.ask(Behaviour.EXPLORE)
        scene.wait(1.0)
        assert (scene.targets[0][0] < 2.0) == (x < 2.0)


def test_a_speck_in_a_door_does_not_end_the_exploring() -> None:
    scene = Scene()
    grid = hall(known=30)
    grid.cells[:, 20] = 100
    grid.cells[10:19, 20] = 0
    grid.cells[14, 20] = 80
    scene.grid = grid
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    assert scene.targets[0][0] > 1.2


def test_what_is_out_of_reach_is_told_at_the_end() -> None:
    scene = Scene()
    grid = hall(known=45)
    grid.cells[:, 20] = 100
    scene.grid = grid
    scene.ask(Behaviour.EXPLORE)
    scene.wait(5.0)
    assert (
        scene.why == "explored: nothing is left; frontiers: 1 out of reach; it is back at its start"
    )


def with_a_closed_door() -> Grid:
    """A hall whose right part the map shows no way to; it also ends at the left."""
    grid = hall(known=30)
    grid.cells[:, 22] = 100
    grid.cells[1:8, 0] = 0
    return grid


def test_a_closed_door_is_gone_to_when_no_other_place_is_left() -> None:
    scene = Scene()
    scene.grid = with_a_closed_door()
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    assert scene.targets[0][0] < 0.0
    scene.grid.cells[1:8, 0] = 100
    scene.arrive()
    scene.wait(3.0)
    assert len(scene.targets) == 2
    assert 0.5 < scene.targets[-1][0] < 1.2
    scene.arrive()
    scene.wait(3.0)
    assert scene.targets[2:] == [(0.0, 0.0)], "once is enough, then it goes home"
    assert scene.why == "returns to its start; explored: nothing is left; frontiers: 1 out of reach"
    scene.arrive()
    scene.wait(3.0)
    assert scene.why.endswith("1 out of reach; it is back at its start")
    assert scene.state.phase is Phase.DONE


def test_a_robot_that_does_not_get_back_says_so_and_ends() -> None:
    scene = Scene()
    scene.grid = with_a_closed_door()
    scene.ask(Behaviour.EXPLORE)
    for _ in range(20):
        scene.wait(1.0)
        if scene.task is Task.GOING and scene.targets[-1] != (0.0, 0.0):
            scene.arrive()
        elif scene.task is Task.GOING:
            scene.end(Task.BLOCKED)
    assert scene.why.endswith("; it did not get back to its start: so it is")
    assert scene.state.behaviour is Behaviour.HOLD


def test_a_place_that_is_near_enough_is_not_gone_to_by_the_inch() -> None:
    scene = Scene()
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    scene.x, scene.y = scene.targets[-1][0] - 0.9 * ARRIVED, scene.targets[-1][1]
    scene.wait(3.0)
    assert len(scene.targets) > 1 or scene.state.behaviour is Behaviour.HOLD


def test_a_place_to_which_navigation_has_a_much_longer_way_waits() -> None:
    scene = Scene()
    grid = hall(known=30)
    grid.cells[19:21, 1:30] = 100
    grid.cells[19:21, 5:12] = 0
    scene.grid = grid
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    scene.distance = 30.0  # something that the map does not show is in the way
    scene.wait(2.5)
    first, second = scene.targets[:2]
    assert (first[1] < 1.0) != (second[1] < 1.0), "the two halves of the hall"


def test_a_frontier_that_is_worth_much_more_is_gone_to_instead() -> None:
    scene = Scene()
    grid = hall(known=30)
    grid.cells[10:31, 29] = 100  # a small gap is left on the right
    scene.grid = grid
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    assert scene.targets[-1][0] > 1.0
    wide = hall(known=30)
    wide.cells[:] = grid.cells
    wide.cells[1:-1, 0] = 0  # the whole left side is open
    scene.grid = Grid(
        cells=np.pad(wide.cells, ((0, 0), (10, 0)), constant_values=-1),
        resolution=0.1, origin_x=-2.0, origin_y=-1.0,
    )  # fmt: skip
    scene.wait(3.0)
    assert scene.targets[-1][0] < 0.5


def test_closed_doors_are_gone_to_when_nothing_new_comes_until_something_does() -> None:
    explore = Explore(RADIUS, Limits(seconds=60.0))
    grid = with_a_closed_door()

    def look(now: float) -> float:
        """Where it is sent; it has driven since."""
        target = explore.choose(Sight(x=now / 30.0 % 1.0, y=0.0, grid=grid, fresh=True, now=now))
        assert isinstance(target, Target)
        return target.points[0].x

    places = [look(10.0 * step) for step in range(12)]
    assert all(place < 0.0 for place in places[:6])
    assert all(place > 0.5 for place in places[6:])
    grid.cells[:, 26:] = 0
    grid.cells[:, 23:26] = 0
    grid.cells[8:30, 0] = 0  # nothing was known there before
    grid.cells[-1, 2:20] = 0
    grid = Grid(
        cells=np.pad(grid.cells, ((0, 10), (0, 0))), resolution=0.1, origin_x=-1.0, origin_y=-1.0
    )
    assert look(125.0) < 0.5


@pytest.mark.parametrize("known", [0, 1, 4])
def test_first_maps_that_lack_what_the_sensors_see_do_not_end_exploring(known: int) -> None:
    scene = Scene()
    scene.grid = hall(known=known)
    scene.ask(Behaviour.EXPLORE)
    scene.wait(2.0)
    assert scene.why == "looks around"
    scene.grid = hall()
    scene.wait(2.0)
    assert scene.targets


def test_a_map_without_free_ground_never_ends_exploring() -> None:
    scene = Scene()
    scene.grid = hall(known=0)
    scene.ask(Behaviour.EXPLORE)
    scene.wait(60.0)
    assert scene.why == "looks around"


def test_nothing_to_explore_is_said_after_a_look() -> None:
    scene = Scene()
    grid = hall(known=60)
    grid.cells[:, -1] = 100
    scene.grid = grid
    scene.ask(Behaviour.EXPLORE)
    scene.wait(5.0)
    assert scene.why == "explored: nothing is left; it is back at its start"
    assert scene.goals == []
    assert math.isnan(scene.state.frontier_m)


def test_what_is_left_is_told() -> None:
    scene = Scene()
    scene.ask(Behaviour.EXPLORE)
    scene.wait(1.0)
    assert scene.state.frontier_m == pytest.approx(3.8)


def test_exploring_ends_when_drift_makes_ever_new_frontiers_where_all_is_known() -> None:
    scene = Scene()
    scene.grid = _open_at(0)
    scene.ask(Behaviour.EXPLORE)
    seconds = 0
    while scene.state.behaviour is Behaviour.EXPLORE and seconds < 300:
        scene.wait(1.0)
        seconds += 1
        if scene.task is Task.GOING and seconds % 10 == 0:
            scene.grid = _open_at(seconds // 10)
            scene.arrive()
    nothing_new = f"explored: nothing new for {Limits().seconds:g} s; frontiers: 1 left"
    assert scene.why == f"{nothing_new}; it is back at its start"
    assert Limits().seconds <= seconds <= Limits().seconds + 15.0


def test_exploring_ends_when_free_ground_grows_only_behind_walls() -> None:
    scene = Scene()
    scene.grid = _open_at(0)
    scene.ask(Behaviour.EXPLORE)
    seconds = 0
    while scene.state.behaviour is Behaviour.EXPLORE and seconds < 300:
        scene.wait(1.0)
        seconds += 1
        if scene.task is Task.GOING and seconds % 10 == 0:
            scene.grid = _open_at(seconds // 10)
            scene.grid.cells[:, 34] = 100
            scene.grid.cells[:, 35 : 36 + seconds // 20] = 0
            scene.arrive()
    assert scene.why.startswith("explored: ")
    assert seconds <= Limits().seconds + 15.0


def test_exploring_turns_back_in_time_although_new_ground_is_left() -> None:
    scene = Scene()
    scene.grid = hall(width=180, height=18, known=30)
    scene.ask(Behaviour.EXPLORE)
    began = scene.now
    known = 30
    while scene.targets[-1:] != [(0.0, 0.0)] and scene.now < began + 2.0 * Limits().longest:
        scene.wait(30.0)
        if scene.task is Task.GOING and scene.targets[-1] != (0.0, 0.0):
            known += 6
            scene.grid = hall(width=180, height=18, known=known)
            scene.arrive()
    way = math.hypot(scene.x, scene.y)
    assert scene.targets[-1] == (0.0, 0.0)
    left = began + Limits().longest - scene.now
    assert left > 0.0
    assert way / RETURN_SPEED - 30.0 <= left <= way / RETURN_SPEED + 60.0
    scene.arrive()
    scene.wait(3.0)
    assert scene.why.startswith("explored: 600 s are over with the way back; frontiers: 1 left")
    assert scene.why.endswith("; it is back at its start")


def _open_at(place: int) -> Grid:
    """A hall with a gap in its right wall, each time in another of ten places."""
    grid = hall(width=50, height=90, known=30)
    first = 2 + 8 * (place % 10)
    grid.cells[:, 29] = 100
    grid.cells[first : first + 5, 29] = 0
    return grid


def test_the_real_parts_explore_together() -> None:
    exploration = Exploration(1)
    exploration.explore(12.0)
    state = exploration.autonomy.state(exploration.now)
    assert state.behaviour is Behaviour.EXPLORE
    assert state.explored > 0.3
    pose = exploration.navigator.pose
    assert math.hypot(pose.x, pose.y) > 1.0
    assert exploration.robot.ground_truth().contacts == 0
