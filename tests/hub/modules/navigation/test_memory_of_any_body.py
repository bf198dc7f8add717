"""Obstacles that sensors anywhere on a body of any shape show."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.beam_scans import BeamScan
from hub.gcm.beams import beams_of
from hub.gcm.body import RobotBody
from hub.gcm.outline import exits
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.ground_memory import GroundMemory
from hub.modules.navigation.obstacle_memory import CONE_S, LEAST_CELLS, RESOLUTION, ObstacleMemory
from hub.pose import Pose
from tests.hub.modules.navigation.bodies import HALF_LENGTH, HALF_WIDTH, LONG
from tests.support.messages import drive_state

Floats = npt.NDArray[np.float64]
BEAMS = beams_of(LONG)
LASER = np.arange(len(BEAMS.kind))[BEAMS.groups["laser"]]


class Memory(ObstacleMemory):
    """The memory of the long robot."""

    def __init__(self) -> None:
        super().__init__(LONG, BeamRules(LONG, BEAMS), 1.8)

    def see(self, ranges: Floats, now: float, pose: Pose | None = None) -> None:
        """Take ranges of all beams [m]."""
        here = pose or Pose()
        self.moved(drive_state(x=here.x, y=here.y, theta=here.theta), now)
        self.scanned(BeamScan(pose=here, ranges=ranges, fresh=~np.isnan(ranges)), now)

    def held(self) -> list[tuple[float, float]]:
        """Points around the origin [m]."""
        return list(zip(*map(np.ndarray.tolist, self.points(0.0, 0.0, 0.0, 3.0)), strict=True))


def ranges(**given_ranges: float) -> Floats:
    """Ranges of some groups [m]; mast and floor are unknown, and the others see nothing."""
    values = np.full(len(BEAMS.kind), np.inf)
    for name in ("mast", "floor"):
        values[BEAMS.groups[name]] = np.nan
    for name, value in given_ranges.items():
        values[BEAMS.groups[name]] = value
    return values


@given(
    st.integers(0, 359),
    st.floats(0.5, 1.4),
    st.builds(Pose, x=st.floats(-9.0, 9.0), y=st.floats(-9.0, 9.0), theta=st.floats(-9.0, 9.0)),
)
def test_each_hit_of_a_laser_anywhere_on_the_body_is_a_point(
    beam: int, away: float, pose: Pose
) -> None:
    memory, seen = Memory(), ranges()
    seen[LASER[beam]] = away
    memory.see(seen, 1.0, pose)
    x, y = memory.points(pose.x, pose.y, pose.theta, 3.0)
    # It hangs upside down at (0.3, 0) and looks to the left: its angles count clockwise.
    bearing = math.pi / 2.0 - (-math.pi + beam * math.tau / 360)
    assert np.hypot(x - 0.3 - away * math.cos(bearing), y - away * math.sin(bearing)).max() < 1e-6
    assert len(x) == 1


@given(st.lists(st.floats(0.05, 9.0), min_size=360, max_size=360))
def test_a_whole_scan_leaves_a_point_near_each_hit_and_no_others(away: list[float]) -> None:
    memory, seen = Memory(), ranges()
    seen[LASER] = away
    memory.see(seen, 1.0)
    x, y = memory.points(0.0, 0.0, 0.0, 9.0)
    hit_x, hit_y = BEAMS.hits(LASER, seen)
    near = np.hypot(hit_x, hit_y) < 0.5 * LEAST_CELLS * RESOLUTION - 0.3
    apart = np.hypot(hit_x[near, None] - x, hit_y[near, None] - y)
    assert not near.any() or apart.min(axis=1).max() < 1.5 * RESOLUTION
    back = np.hypot(x[:, None] - hit_x, y[:, None] - hit_y)
    assert not len(x) or back.min(axis=1).max() < 1e-9


def test_a_laser_sees_that_an_obstacle_is_gone() -> None:
    memory = Memory()
    memory.see(ranges(laser=1.0), 0.0)
    assert memory.held()
    for step in range(1, 6):
        memory.see(ranges(), 0.1 * step, Pose(theta=0.05 * step))
    assert not memory.held()


def test_a_single_ray_says_nothing_of_what_is_behind_it() -> None:
    memory, seen = Memory(), ranges()
    seen[LASER[90]] = 1.0
    memory.see(seen, 0.0)
    assert len(memory.held()) == 1
    for step in range(1, 6):
        memory.see(ranges(laser=math.nan, mast=math.inf), 0.1 * step, Pose(x=0.02 * step))
    assert len(memory.held()) == 1


def test_a_cone_beside_the_body_is_an_arc_there() -> None:
    memory = Memory()
    memory.see(ranges(left=0.3), 0.0)
    assert len(memory.held()) > 1
    assert all(math.isclose(math.hypot(x, y - HALF_WIDTH), 0.3) for x, y in memory.held())
    memory.see(ranges(), CONE_S + 0.1, Pose(theta=1.0))
    memory.see(ranges(), 2.0 * CONE_S + 0.2, Pose(theta=2.0))
    assert not memory.held()


def test_a_range_too_near_to_measure_is_an_obstacle_at_the_outline() -> None:
    memory, seen = Memory(), ranges(mast=0.7)
    memory.see(seen, 0.0)
    ((x, y),) = memory.held()
    assert math.isclose(x, HALF_LENGTH, abs_tol=0.02)
    assert math.isclose(y, 0.0, abs_tol=1e-9)


def test_a_remembered_point_explains_a_range_too_near_to_measure() -> None:
    memory, seen = Memory(), ranges(mast=0.7)
    seen[LASER[270]] = 0.3
    memory.see(seen, 0.0)
    ((x, _),) = memory.held()
    assert math.isclose(x, 0.6, abs_tol=1e-6)


def test_a_wide_bumper_is_a_row_of_points_on_the_outline() -> None:
    memory = Memory()
    memory.moved(drive_state(bumpers=0b11), 0.0)
    points = memory.held()
    assert len(points) == 4
    for x, y in points:
        assert abs(math.atan2(y, x)) <= 0.4
        assert math.isclose(max(abs(x) / HALF_LENGTH, abs(y) / HALF_WIDTH), 1.0)


def test_a_body_without_sensors_remembers_nothing() -> None:
    body = RobotBody(name="a", kind="b", radius=0.2)
    memory = ObstacleMemory(body, BeamRules(body, beams_of(body)), 1.8)
    memory.moved(drive_state(bumpers=0xFFFF), 0.0)
    nothing = np.empty(0)
    memory.scanned(BeamScan(pose=Pose(), ranges=nothing, fresh=nothing > 0.0), 0.0)
    assert not len(memory.points(0.0, 0.0, 0.0, 9.0)[0])


@given(st.floats(-0.4, 0.4), st.floats(-0.15, 0.15), st.floats(-4.0, 4.0))
def test_lines_leave_the_outline_on_it(x: float, y: float, bearing: float) -> None:
    def exit_of(body: RobotBody) -> tuple[float, float]:
        (away,) = exits(body, np.array([x]), np.array([y]), np.array([bearing]))
        return x + away * math.cos(bearing), y + away * math.sin(bearing)

    ahead, left = exit_of(LONG)
    assert math.isclose(max(abs(ahead) / HALF_LENGTH, abs(left) / HALF_WIDTH), 1.0)
    round_body = RobotBody(name="a", kind="b", radius=0.5)
    assert math.isclose(math.hypot(*exit_of(round_body)), 0.5)


def test_lines_that_miss_the_outline_have_no_exit() -> None:
    for body in (LONG, RobotBody(name="a", kind="b", radius=0.2)):
        away = exits(body, np.array([2.0, 2.0]), np.array([0.0, 0.0]), np.array([1.5, 0.0]))
        assert list(away) == [0.0, 0.0]


def test_what_covers_a_laser_inside_the_outline_is_at_the_rim() -> None:
    memory, seen = Memory(), ranges()
    seen[LASER] = 0.0
    memory.see(seen, 1.0)
    bearings = [math.atan2(y, x - 0.3) for x, y in memory.held()]
    assert max(np.diff(sorted(bearings))) < math.radians(3.0), "all around, of a full circle"
    for x, y in memory.held():
        assert abs(max(abs(x) - HALF_LENGTH, abs(y) - HALF_WIDTH)) < 0.02


def test_what_stands_before_a_beam_to_the_ground_is_an_obstacle_unless_it_is_the_ground() -> None:
    for along, found in ((0.1, 1), (0.4, 0), (math.nan, 0)):
        ground = GroundMemory(LONG, BEAMS, step=0.05)
        ways = np.full(len(BEAMS.kind), np.nan)
        ways[BEAMS.groups["floor"]] = along
        scan = BeamScan(pose=Pose(), ranges=ways, fresh=~np.isnan(ways), along=ways)
        ground.scanned(scan, 1.0)
        x, _ = ground.points(0.0, 0.0, 0.0, 3.0)
        assert len(x) == found
        assert (np.abs(x - HALF_LENGTH) < 0.02).all()
