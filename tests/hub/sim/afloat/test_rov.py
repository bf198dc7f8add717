"""The whole underwater robot: it holds, steps, stops, surfaces, and is carried."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.gcm.body import HoldKind
from hub.pose import wrapped
from hub.sim.afloat.rov import LIMITS, SHAPE, SURFACED, Dive, SimulatedRov, hull
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.afloat.tether import TetherSpec, drag_factor
from hub.sim.afloat.vehicle import STEP
from hub.sim.arena_specs import WaterSpec
from hub.sim.geometry import Box, Surface
from hub.sim.spatial_pose import SpatialPose
from tests.hub.sim.afloat.closed_forms import steady_speed
from tests.support.cases import for_each
from tests.support.repetitions import repetitions

OPEN = Surroundings()
SURFACE = 10.0
LONG = TetherSpec(length=1000.0, anchor=(0.0, 0.0, 5.0))
WALL = Box(
    low=(2.0, -9.0, 0.0), high=(2.2, 9.0, 12.0), surface=Surface(texture="wood", colour=(9, 9, 9))
)


def rov(
    depth: float = 3.0,
    *,
    around: Surroundings = OPEN,
    current: float = 0.0,
    tether: TetherSpec | None = None,
    density: float = 1026.0,
    leaks_at: float = math.inf,
    charge: float = 1.0,
    seed: int = 1,
) -> SimulatedRov:
    return SimulatedRov(
        around,
        start=SpatialPose(z=SURFACE - depth),
        water=WaterSpec(surface=SURFACE, current=(current, 0.0)),
        tether=tether,
        density=density,
        leaks_at=leaks_at,
        charge=charge,
        seed=seed,
    )


def dive(robot: SimulatedRov, seconds: float, every: float = 0.1) -> list[SpatialPose]:
    poses = []
    for _ in range(round(seconds / every)):
        robot.advance(every)
        poses.append(robot.pose)
    return poses


def speed(robot: SimulatedRov) -> float:
    velocity = robot.velocity
    return math.sqrt(velocity.surge**2 + velocity.sway**2 + velocity.heave**2)


def test_it_holds_its_depth_within_5_mm_and_stays_upright() -> None:
    robot = rov()
    poses = dive(robot, 40.0)[100:]
    assert np.std([pose.z for pose in poses]) <= 0.005
    assert np.mean([pose.z for pose in poses]) == pytest.approx(SURFACE - 3.0, abs=0.005)
    assert robot.hold.depth == pytest.approx(3.0, abs=0.01)
    assert robot.readings.altitude == pytest.approx(7.0, abs=0.25)
    assert max(abs(robot.pose.roll), abs(robot.pose.pitch)) < math.radians(2.0)
    assert not robot.hold.fails


@for_each(
    ("down", "seed"),
    [(down, seed) for down in (1.0, -1.0) for seed in range(1, 1 + repetitions(1, 10))],
)
def test_a_step_of_a_metre_settles_within_4_s_and_overshoots_by_less_than_2_cm(
    down: float, seed: int
) -> None:
    robot = rov(seed=seed)
    dive(robot, 5.0)
    robot.start_hold(HoldKind.DEPTH, 3.0 + down)
    ways = [down * (SURFACE - 3.0 - pose.z) for pose in dive(robot, 8.0)]
    assert max(ways) <= 1.02
    assert all(abs(way - 1.0) <= 0.05 for way in ways[40:])


def test_a_quarter_turn_settles_without_overshoot_and_twists_the_tether() -> None:
    robot = rov()
    dive(robot, 3.0)
    start = robot.pose.yaw
    robot.start_hold(HoldKind.HEADING, robot.readings.heading + math.pi / 2)
    turns = [wrapped(pose.yaw - start) for pose in dive(robot, 4.0)]
    assert max(turns) <= math.radians(93.0)
    assert all(abs(turn - math.pi / 2) <= math.radians(4.0) for turn in turns[20:])
    assert robot.readings.tether_turns == pytest.approx(0.25, abs=0.03)


@for_each(
    ("axis", "wanted"),
    [
        ("surge", 0.7),
        ("surge", -0.3),
        ("sway", 0.55),
        ("heave", 0.5),
        ("heave", -0.5),
        ("yaw", 1.2),
    ],
)
def test_it_moves_as_commanded_and_is_at_rest_1500_ms_after_it(axis: str, wanted: float) -> None:
    robot = rov(5.0, tether=LONG)
    dive(robot, 2.0)
    robot.command(**{axis: 2.0 * wanted if abs(wanted) > 0.3 else wanted})
    dive(robot, 3.0)
    assert getattr(robot.velocity, axis) == pytest.approx(wanted, rel=0.05)
    assert max(abs(robot.pose.roll), abs(robot.pose.pitch)) < math.radians(3.0)
    if axis != "heave":
        assert robot.pose.z == pytest.approx(SURFACE - 5.0, abs=0.02)
    robot.command()
    robot.advance(0.34)
    x, y, _, _, _, yaw = robot.thrust
    assert x * robot.velocity.surge <= 0.01, "it brakes by reverse thrust"
    assert y * robot.velocity.sway <= 0.01
    robot.advance(1.16)
    assert speed(robot) < 0.05
    assert abs(robot.velocity.yaw) < 0.1
    assert abs(yaw) < 8.0
    dive(robot, 1.0)
    assert speed(robot) < 0.05
    assert not robot.hold.braking


@for_each(
    "commands",
    [
        {"surge": 9.0, "yaw": 9.0},
        {"surge": 9.0, "sway": -9.0},
        {"surge": 0.7, "sway": -0.5, "heave": 0.5},
        {"surge": -0.7, "heave": -0.5, "yaw": 1.0},
    ],
)
def test_it_is_at_rest_1500_ms_after_several_motions(commands: dict[str, float]) -> None:
    robot = rov(5.0, tether=LONG)
    dive(robot, 2.0)
    robot.command(**commands)
    dive(robot, 4.0)
    start = robot.pose
    robot.command()
    robot.advance(1.5)
    assert speed(robot) < 0.05
    assert math.dist((start.x, start.y, start.z), (robot.pose.x, robot.pose.y, robot.pose.z)) < 0.3


def test_it_does_not_brake_away_from_a_wall_that_stopped_it() -> None:
    robot = rov(5.0, around=Surroundings((WALL,)))
    robot.command(surge=0.7)
    dive(robot, 8.0)
    assert robot.touching
    x = robot.pose.x
    robot.command()
    assert min(pose.x for pose in dive(robot, 3.0)) > x - 0.05


def test_where_its_log_has_no_ground_it_coasts() -> None:
    start, water = SpatialPose(z=75.0), WaterSpec(surface=80.0)
    robot = SimulatedRov(OPEN, start=start, water=water, tether=LONG)
    robot.command(surge=0.7)
    dive(robot, 3.0)
    assert math.isnan(robot.readings.surge)
    robot.command()
    robot.advance(0.6)
    assert robot.thrust[0] == pytest.approx(0.0, abs=1.0)
    robot.advance(0.9)
    assert speed(robot) < 0.1


def test_all_motions_at_once_saturate_the_thrusters_and_it_stays_upright() -> None:
    robot = rov(5.0, tether=LONG)
    robot.command(surge=9.0, sway=9.0, heave=-9.0, yaw=9.0)
    poses = dive(robot, 4.0)
    assert max(max(abs(pose.roll), abs(pose.pitch)) for pose in poses) < math.radians(30.0)
    robot.command()
    dive(robot, 4.0)
    assert max(abs(robot.pose.roll), abs(robot.pose.pitch)) < math.radians(2.0)


def test_it_rolls_and_pitches_by_command_and_levels_when_left_alone() -> None:
    robot = rov()
    robot.command(pitch=0.3)
    dive(robot, 1.0)
    robot.command()
    dive(robot, 3.0)
    assert robot.pose.pitch == pytest.approx(0.3, abs=0.05)
    assert robot.pose.z == pytest.approx(SURFACE - 3.0, abs=0.03)
    assert abs(robot.velocity.surge) < 0.02
    robot.brake_and_hold()
    dive(robot, 3.0)
    assert robot.pose.pitch == pytest.approx(0.0, abs=0.03)


def test_it_surfaces_by_thrusters_within_10_s_and_stays_there() -> None:
    robot = rov()
    dive(robot, 1.0)
    robot.surface()
    dive(robot, 10.0)
    assert SURFACE - robot.pose.z < 0.3
    robot.command()
    dive(robot, 5.0)
    assert SURFACE - robot.pose.z == pytest.approx(SURFACED, abs=0.03)
    robot.command(heave=-0.3)
    assert robot.dive is Dive.DIVING
    dive(robot, 3.0)
    assert SURFACE - robot.pose.z > 0.5


@for_each("order", [SimulatedRov.brake_and_hold, lambda robot: robot.start_hold(HoldKind.DEPTH)])
def test_an_order_to_hold_ends_its_way_up(order: Callable[[SimulatedRov], None]) -> None:
    robot = rov(depth=5.0)
    dive(robot, 1.0)
    robot.surface()
    dive(robot, 3.0)
    assert robot.velocity.heave > 0.3
    order(robot)
    dive(robot, 3.0)
    assert abs(robot.velocity.heave) < 0.02
    assert SURFACE - robot.pose.z > 3.0


def test_a_leak_brings_it_up_at_once_whatever_is_commanded() -> None:
    robot = rov(leaks_at=2.0)
    robot.command(heave=-0.3)
    dive(robot, 1.9)
    assert not robot.readings.leak
    dive(robot, 0.2)
    assert robot.readings.leak
    robot.brake_and_hold()
    robot.start_hold(HoldKind.DEPTH)
    dive(robot, 0.1)
    assert robot.dive is Dive.SURFACING
    for _ in range(100):
        robot.command(surge=0.2, heave=-0.5)
        robot.advance(0.1)
    assert robot.dive is Dive.SURFACING
    assert SURFACE - robot.pose.z < 0.3
    assert robot.pose.x > 0.5


@for_each(("density", "depth"), [(1026.0, 0.0), (1000.0, SURFACE)])
def test_without_power_it_floats_up_in_the_sea_and_sinks_in_fresh_water(
    density: float, depth: float
) -> None:
    start = 0.5 if density > 1010.0 else SURFACE - 0.5
    robot = rov(start, density=density, charge=1e-9)
    dive(robot, 25.0)
    assert SURFACE - robot.pose.z == pytest.approx(depth, abs=0.15)
    assert robot.hold.fails


def test_it_does_not_leave_the_water() -> None:
    robot = rov(1.0)
    robot.command(heave=0.5)
    poses = dive(robot, 8.0)
    assert max(pose.z for pose in poses) < SURFACE
    assert abs(robot.pose.roll) < math.radians(5.0)


def test_a_current_carries_it_while_it_holds_depth_and_heading() -> None:
    robot = rov(current=0.2)
    dive(robot, 20.0)
    assert robot.pose.x == pytest.approx(3.8, abs=0.3)
    assert robot.hold.carried > 3.0
    assert not robot.hold.fails
    assert robot.pose.z == pytest.approx(SURFACE - 3.0, abs=0.01)


def test_the_tether_slows_it_and_stops_it_at_full_length() -> None:
    """The drag of a third of 21 m adds to the hull's."""
    bare = hull()
    dragging = (bare.quadratic[0] + drag_factor(21.0), *bare.quadratic[1:])
    force = bare.drag(0, LIMITS.surge)
    wanted = steady_speed(dataclasses.replace(bare, quadratic=dragging), 0, force)
    robot = rov(tether=TetherSpec(length=50.0, anchor=(-19.5, 0.0, SURFACE - 3.0)))
    robot.command(surge=LIMITS.surge)
    while robot.pose.x < 1.5:
        robot.advance(STEP)
    assert robot.velocity.surge == pytest.approx(wanted, rel=0.01)
    robot = rov(tether=TetherSpec(length=10.0, anchor=(-8.0, 0.0, SURFACE - 3.0)))
    robot.command(surge=LIMITS.surge)
    dive(robot, 8.0)
    assert 2.0 < robot.pose.x < 2.3
    assert robot.readings.tether_used == 1.0
    assert abs(robot.velocity.surge) < 0.05


def test_it_stops_at_a_wall_and_on_the_floor() -> None:
    robot = rov(around=Surroundings((WALL,)))
    robot.command(surge=0.7, heave=-0.5)
    dive(robot, 25.0)
    assert robot.pose.x == pytest.approx(2.0 - SHAPE.radius, abs=0.002)
    assert robot.pose.z == pytest.approx(SHAPE.below, abs=0.002)
    assert robot.contacts >= 1
    robot.command()
    dive(robot, 2.0)
    assert robot.pose.x == pytest.approx(2.0 - SHAPE.radius, abs=0.05)


def test_its_battery_empties_faster_with_thrust() -> None:
    holding, driving = rov(), rov(tether=LONG)
    driving.command(surge=0.7)
    dive(holding, 10.0)
    dive(driving, 10.0)
    assert 1.0 > holding.battery.fraction > driving.battery.fraction > 0.98
    assert driving.battery.voltage < holding.battery.voltage < 16.8


@settings(max_examples=repetitions(4, 50))
@given(
    commands=st.lists(st.tuples(*[st.floats(-2, 2)] * 6), min_size=1, max_size=4),
    seed=st.integers(0, 2**32),
)
def test_no_commands_bring_it_out_of_its_pool(
    commands: list[tuple[float, float, float, float, float, float]], seed: int
) -> None:
    robot = rov(1.0, around=Surroundings((WALL,)), current=0.1, seed=seed)
    for command in commands:
        robot.command(*command)
        for pose in dive(robot, 2.0):
            assert SHAPE.below - 1e-9 <= pose.z < SURFACE + 0.05
            assert pose.x <= 2.0 - SHAPE.radius + 1e-9


def test_the_same_seed_and_calls_give_the_same_bits() -> None:
    def run(seed: int, *, peek: bool) -> list[object]:
        robot = rov(current=0.1, seed=seed)
        for number in range(15):
            robot.command(surge=0.1 * number, yaw=0.3 - 0.03 * number, pitch=0.1)
            robot.advance(0.13)
            if peek:
                assert robot.readings.depth > 0.0
                assert robot.hold is not None
        return [robot.pose, robot.velocity, robot.readings, robot.battery, robot.hold]

    assert run(1, peek=False) == run(1, peek=True)
    assert run(1, peek=False) != run(2, peek=False)


def test_it_goes_no_higher_than_the_surface_for_a_hold() -> None:
    robot = rov()
    robot.start_hold(HoldKind.DEPTH, -5.0)
    assert robot.hold_state(HoldKind.DEPTH, tolerance=0.3).target == SURFACED
