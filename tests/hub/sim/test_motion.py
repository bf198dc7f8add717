"""How the simulated base moves: limits, accelerations, contact, odometry."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.pose import Pose, wrapped
from hub.robots.simulated_base import STEP
from hub.sim.arena import Arena, load_arena
from hub.sim.battery import Battery
from hub.sim.kinematics import ANGULAR, LINEAR, approach, moved
from hub.sim.odometry import WheelOdometry
from hub.sim.steps import LONGEST_ADVANCE
from tests.hub.sim.arenas import VOID, arena_of
from tests.support.cases import for_each
from tests.support.magellan import SimulatedMagellan, magellan_body
from tests.support.repetitions import repetitions

YELLOW = load_arena("yellow")
EMPTY = load_arena("empty")
RADIUS = magellan_body().radius
NARROW = arena_of(
    VOID
    + "[[wall]]\nfrom=[-1.0,0.5]\nto=[1.5,0.5]\n"
    + "[[wall]]\nfrom=[1.0,0.5]\nto=[1.0,-1.5]\n"
    + "[[box]]\nat=[-0.6,0]\nsize=[0.3,0.3,0.3]\n"
    + "[[cylinder]]\nat=[0.4,-0.6]\nradius=0.1\nheight=0.5\n"
    + "[[cylinder]]\nat=[-0.3,-0.7]\nradius=0.25\nheight=0.5\n"
)

VELOCITIES = st.tuples(st.floats(-3.0, 3.0), st.floats(-6.0, 6.0), st.floats(0.05, 1.5))


def clearance(arena: Arena, robot: SimulatedMagellan) -> float:
    truth = robot.ground_truth()
    return float(arena.footprints.distances(truth.x, truth.y).min()) - RADIUS


@given(commands=st.lists(VELOCITIES, min_size=1, max_size=5), seed=st.integers(0, 2**32))
def test_no_commands_bring_the_body_into_anything(
    commands: list[tuple[float, float, float]], seed: int
) -> None:
    robot = SimulatedMagellan(NARROW, seed=seed, linear_limit=3.0, angular_limit=6.0)
    for linear, angular, seconds in commands:
        robot.set_velocity(linear, angular)
        for _ in range(round(seconds / 0.05)):
            robot.advance(0.05)
            assert clearance(NARROW, robot) >= -1e-9


def test_driving_at_random_through_the_yellow_arena_touches_but_never_enters() -> None:
    random = np.random.default_rng(1)
    robot = SimulatedMagellan(YELLOW, seed=3)
    for _ in range(repetitions(80, 1000)):
        robot.set_velocity(float(random.uniform(-0.1, 0.5)), float(random.uniform(-1, 1)))
        robot.advance(0.5)
        assert clearance(YELLOW, robot) >= -1e-9
    assert robot.ground_truth().contacts > 0


def test_the_same_seed_and_commands_give_the_same_bits() -> None:
    def run(seed: int, *, peek: bool) -> list[object]:
        random = np.random.default_rng(9)
        robot = SimulatedMagellan(YELLOW, seed=seed)
        for _ in range(40):
            robot.set_velocity(float(random.uniform(-0.5, 0.5)), float(random.uniform(-1, 1)))
            robot.advance(0.13)
            if peek:
                robot.drive_state(0.0)
        state = robot.drive_state(0.0)
        numbers = [
            state.x,
            state.y,
            state.theta,
            robot.sensors(0.0).battery_voltage,
            robot.ground_truth(),
        ]
        return [*numbers, *(scan.ranges.tobytes() for scan in robot.sensors(0.0).scans)]

    assert run(1, peek=False) == run(1, peek=True)
    assert run(1, peek=False)[:3] != run(2, peek=False)[:3]


@given(velocity=st.floats(-1, 1), target=st.floats(-1, 1), seconds=st.floats(0.001, 2.0))
def test_velocity_changes_no_faster_than_the_accelerations_allow(
    velocity: float, target: float, seconds: float
) -> None:
    for limits in (LINEAR, ANGULAR):
        after = approach(velocity, target, limits, seconds)
        assert min(velocity, target) - 1e-9 <= after <= max(velocity, target) + 1e-9
        assert abs(after - velocity) <= limits.braking * seconds + 1e-9
        if abs(after) > abs(velocity) and after * velocity >= 0.0:
            assert abs(after) - abs(velocity) <= limits.speeding_up * seconds + 1e-9


def test_the_robot_follows_limits_and_stops_from_full_speed_in_time() -> None:
    robot = SimulatedMagellan(EMPTY)
    robot.set_velocity(9.0, -9.0)
    robot.advance(0.2)
    assert robot.ground_truth().linear == pytest.approx(0.2)
    robot.advance(1.0)
    truth = robot.ground_truth()
    assert (truth.linear, truth.angular) == pytest.approx((0.5, -1.0))
    assert (truth.commanded_linear, truth.commanded_angular) == (0.5, -1.0)
    robot.set_velocity(0.0, 0.0)
    robot.advance(0.3)
    truth = robot.ground_truth()
    assert (truth.linear, truth.angular) == (0.0, 0.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308])
def test_commands_and_times_that_are_no_numbers_do_no_harm(value: float) -> None:
    robot = SimulatedMagellan(EMPTY)
    robot.set_velocity(value, value)
    robot.advance(0.1)
    truth = robot.ground_truth()
    if math.isnan(value):
        assert (truth.commanded_linear, truth.linear) == (0.0, 0.0)
    assert abs(truth.commanded_linear) <= 0.5
    assert abs(truth.commanded_angular) <= 1.0
    before = truth.time
    robot.advance(value)
    assert before <= robot.ground_truth().time <= before + LONGEST_ADVANCE + STEP


def test_a_straight_way_and_a_circle_end_where_geometry_says() -> None:
    pose = Pose(x=0.0, y=0.0, theta=0.0)
    for _ in range(100):
        pose = moved(pose, 0.02 * math.pi, 0.02 * math.pi)
    assert (pose.x, pose.y) == pytest.approx((0.0, 0.0), abs=1e-9)
    half = moved(Pose(x=1.0, y=2.0, theta=math.pi / 2), math.pi, math.pi)
    assert (half.x, half.y, abs(half.theta)) == pytest.approx((-1.0, 2.0, math.pi / 2))


@for_each("bumper", range(16))
def test_the_bumper_that_faces_the_wall_is_pressed(bumper: int) -> None:
    """The robot stands against a wall in the north, turned so that one bumper faces it."""
    north = 90.0 - 22.5 * bumper
    text = (
        f'name="a"\n[start]\nat=[0.0, 0.0]\nheading_deg={north}\n'
        f"[[wall]]\nfrom=[-2.0, {RADIUS + 0.0505}]\nto=[2.0, {RADIUS + 0.0505}]\n"
    )
    robot = SimulatedMagellan(arena_of(text))
    assert robot.drive_state(0.0).bumpers == 1 << bumper
    assert robot.ground_truth().touching == 1


def test_a_contact_is_counted_once_while_it_lasts_and_again_after_it_ended() -> None:
    robot = SimulatedMagellan(NARROW)
    counts = []
    for linear in (0.5, 0.5, -0.2, 0.5):
        robot.set_velocity(linear, 0.0)
        robot.advance(1.5 if linear < 0 else 3.0)
        truth = robot.ground_truth()
        counts.append((truth.contacts, truth.touching))
    assert counts == [(1, 1), (1, 1), (1, 0), (2, 1)]
    assert robot.drive_state(0.0).bumpers == 1
    assert abs(robot.ground_truth().linear) < 0.02


def test_the_body_slides_along_a_wall_that_it_meets_at_an_angle() -> None:
    text = 'name="a"\n[start]\nat=[0,0]\nheading_deg=20\n[[wall]]\nfrom=[-1,0.5]\nto=[9,0.5]\n'
    robot = SimulatedMagellan(arena_of(text))
    robot.set_velocity(0.5, 0.0)
    robot.advance(2.0)
    first = robot.ground_truth()
    robot.advance(2.0)
    second = robot.ground_truth()
    assert first.touching == second.touching == 1
    assert second.x > first.x + 0.05
    assert second.y == pytest.approx(first.y, abs=1e-5)


def reckoned(seed: int, linear: float, angular: float, seconds: float) -> Pose:
    """Where the encoders of a robot see it after a motion at these velocities."""
    odometry = WheelOdometry(np.random.SeedSequence(seed))
    for _ in range(round(seconds / STEP)):
        odometry.moved(linear * STEP, angular * STEP, STEP)
    return odometry.pose


@settings(max_examples=repetitions(5, 100))
@given(seed=st.integers(0, 2**32))
def test_odometry_drifts_but_not_without_bound(seed: int) -> None:
    pose, true = reckoned(seed, 0.5, 0.25, 20.0), moved(Pose(), 0.5 * 20.0, 0.25 * 20.0)
    # Slip and chance may nearly cancel out, but never quite.
    assert 0.0 < math.dist((pose.x, pose.y), (true.x, true.y)) < 0.25 * 0.5 * 20.0
    assert 0.0 < abs(wrapped(pose.theta - true.theta)) < 1.0


def test_odometry_of_most_robots_is_off_by_more_than_a_hundredth_of_a_straight_way() -> None:
    ends = [reckoned(seed, 0.5, 0.0, 15.0) for seed in range(repetitions(24, 100))]
    assert 0.01 < np.median([math.dist((end.x, end.y), (7.5, 0.0)) / 7.5 for end in ends]) < 0.04


def test_odometry_starts_at_zero_wherever_the_robot_starts_and_stands_still_with_it() -> None:
    robot = SimulatedMagellan(YELLOW)
    robot.advance(3.0)
    state, truth = robot.drive_state(7.5), robot.ground_truth()
    assert (state.x, state.y, state.theta) == (0.0, 0.0, 0.0)
    assert state.odometry.header.stamp.seconds == 7.5
    assert (truth.x, truth.y) == (YELLOW.start.x, YELLOW.start.y)


def test_a_battery_falls_with_time_and_faster_with_load() -> None:
    full = Battery()
    idle, driving = full.after(600.0, 0.0, 0.0), full.after(600.0, -0.5, 0.5)
    assert 1.0 == full.fraction > idle.fraction > driving.fraction > 0.0
    assert full.voltage > idle.voltage > driving.voltage
    assert driving.after(0.01, 0.0, 0.0).voltage > driving.voltage
    assert full.after(1e9, 0.5, 1.0).fraction == 0.0
