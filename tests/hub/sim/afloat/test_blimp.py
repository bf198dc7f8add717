"""The whole blimp: it holds, steps, brakes, lands, and is carried."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.gcm.body import HoldKind
from hub.gcm.vehicle import HoldPhase
from hub.pose import wrapped
from hub.sim.afloat.blimp import LIMITS, LONGEST_HOLD, LOW_BATTERY, SHAPE, Flight, SimulatedBlimp
from hub.sim.afloat.motion import NEUTRAL, BodyVelocity
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.afloat.vehicle import STEP
from hub.sim.arena_specs import AirSpec
from hub.sim.geometry import Box, Surface
from hub.sim.spatial_pose import SpatialPose
from hub.sim.steps import LONGEST_ADVANCE
from tests.support.cases import for_each
from tests.support.repetitions import repetitions

OPEN = Surroundings()
TABLE = Box(
    low=(1.5, -2.0, 0.0), high=(4.0, 2.0, 0.75), surface=Surface(texture="wood", colour=(9, 9, 9))
)
CLOTH = Surface(texture="fabric", colour=(9, 9, 9))
WALL = Box(
    low=(2.0, -9.0, 0.0), high=(2.2, 9.0, 5.0), surface=Surface(texture="wood", colour=(9, 9, 9))
)


def blimp(
    height: float = 2.0,
    *,
    around: Surroundings = OPEN,
    draft: float = 0.0,
    wind: float = 0.0,
    charge: float = 1.0,
    seed: int = 1,
) -> SimulatedBlimp:
    air = AirSpec(draft=draft, wind=(wind, 0.0))
    start = SpatialPose(z=height)
    return SimulatedBlimp(around, start=start, air=air, charge=charge, seed=seed)


def fly(robot: SimulatedBlimp, seconds: float, every: float = 0.1) -> list[SpatialPose]:
    poses = []
    for _ in range(round(seconds / every)):
        robot.advance(every)
        poses.append(robot.pose)
    return poses


def speed(robot: SimulatedBlimp) -> float:
    return math.hypot(robot.velocity.surge, robot.velocity.sway)


def test_it_holds_its_height_within_2_cm_and_lands_after_ten_minutes_alone() -> None:
    robot = blimp(1.5, draft=0.04)
    robot.brake_and_hold()
    poses = fly(robot, LONGEST_HOLD - 30.0)[300:]
    robot.brake_and_hold()
    assert np.std([pose.z for pose in poses]) <= 0.02
    assert np.mean([pose.z for pose in poses]) == pytest.approx(1.5, abs=0.02)
    assert robot.flight is Flight.FLYING
    assert robot.hold.height == pytest.approx(1.5, abs=0.05)
    assert robot.battery.fraction > 0.9
    fly(robot, 29.0)
    assert robot.flight is Flight.FLYING
    fly(robot, 12.0)
    assert robot.flight is Flight.LANDED
    assert robot.thrusts == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert robot.pose.z == pytest.approx(SHAPE.below, abs=0.001)


@for_each(
    ("up", "seed"), [(up, seed) for up in (1.0, -1.0) for seed in range(1, 1 + repetitions(1, 10))]
)
def test_a_step_of_a_metre_takes_6_s_and_overshoots_by_less_than_10_cm(
    up: float, seed: int
) -> None:
    robot = blimp(2.5, draft=0.04, seed=seed)
    fly(robot, 10.0)
    robot.start_hold(HoldKind.HEIGHT, 2.5 + up)
    rises = [up * (pose.z - 2.5) for pose in fly(robot, 20.0)]
    assert next(number for number, rise in enumerate(rises) if rise > 0.9) * 0.1 <= 6.0
    assert max(rises) <= 1.1
    assert rises[-1] == pytest.approx(1.0, abs=0.05)


@for_each(("draft", "seed"), [(0.0, 1), (0.04, 2)])
def test_it_brakes_from_full_speed_within_4_s_and_120_cm(draft: float, seed: int) -> None:
    robot = blimp(draft=draft, seed=seed)
    robot.command(surge=9.0)
    fly(robot, 20.0)
    assert robot.commanded.surge == LIMITS.surge
    assert speed(robot) == pytest.approx(LIMITS.surge, abs=0.05 + draft)
    start = robot.pose
    robot.command()
    robot.advance(0.34)
    assert robot.thrusts[0] <= 0.0
    assert robot.hold.braking
    seconds = 0.34
    while speed(robot) > 0.1:
        robot.advance(STEP)
        seconds += STEP
    assert seconds <= 4.0
    assert math.dist((start.x, start.y), (robot.pose.x, robot.pose.y)) <= 1.2
    robot.advance(2.0)
    assert not robot.hold.braking
    assert speed(robot) < 0.1
    assert robot.hold.heading is not None


@for_each(("speed", "draft"), [(0.3, 0.0), (0.5, 0.04), (LIMITS.surge, 0.04), (-0.4, 0.04)])
def test_it_flies_ahead_at_the_speed_that_is_commanded(speed: float, draft: float) -> None:
    """Without fins it would turn across the air; its heading hold keeps it straight."""
    robot = blimp(draft=draft, seed=3)
    robot.command(surge=speed)
    poses = fly(robot, 20.0)
    assert robot.velocity.surge == pytest.approx(speed, abs=0.02 + 2.0 * draft)
    # The compass errs by 10 degrees either way.
    assert max(abs(wrapped(pose.yaw)) for pose in poses) < math.radians(25.0)


def test_a_draft_that_turns_it_across_its_way_slows_it_until_it_is_back() -> None:
    """It has no fins: at full speed a draft from the side turns it further than its tail can."""
    robot = blimp(3.0, draft=0.15, seed=1)
    robot.command(surge=LIMITS.surge)
    poses = fly(robot, 50.0)
    assert max(abs(wrapped(pose.yaw)) for pose in poses) < math.radians(50.0)
    assert robot.pose.x > 20.0


def test_it_turns_climbs_and_holds_what_it_reached() -> None:
    robot = blimp()
    robot.command(yaw=0.5, heave=0.15)
    fly(robot, 5.0)
    assert robot.hold.heading is None
    assert robot.hold.height is None
    assert robot.velocity.yaw == pytest.approx(0.5, abs=0.05)
    assert robot.velocity.heave == pytest.approx(0.15, abs=0.03)
    robot.command()
    fly(robot, 5.0)
    hold, pose = robot.hold, robot.pose
    fly(robot, 5.0)
    assert robot.pose.z == pytest.approx(hold.height, abs=0.03)
    assert wrapped(robot.pose.yaw - pose.yaw) == pytest.approx(0.0, abs=math.radians(8.0))
    assert not robot.hold.fails


def test_a_table_below_does_not_lift_it() -> None:
    """The range jumps by 0.75 m at each edge of the table."""
    robot = blimp(1.5, around=Surroundings((TABLE,)))
    robot.command(surge=0.4)
    altitudes, heights = [], []
    for _ in range(150):
        robot.advance(0.1)
        altitudes.append(robot.readings.altitude)
        heights.append(robot.pose.z)
    assert robot.pose.x > 4.5
    assert np.nanmin(altitudes) < 0.8
    assert np.nanmax(altitudes) > 1.4
    assert max(abs(height - 1.5) for height in heights) < 0.15


def test_without_an_echo_it_holds_its_height_by_the_barometer() -> None:
    """Fabric below swallows all echoes; the barometer drifts by less than that."""
    carpet = Box(low=(-9.0, -9.0, 0.0), high=(9.0, 9.0, 0.01), surface=CLOTH)
    robot = blimp(1.5, around=Surroundings((carpet,)))
    heights = [pose.z for pose in fly(robot, 40.0)]
    assert math.isnan(robot.readings.altitude)
    assert max(abs(height - 1.5) for height in heights) < 0.45


def test_echoes_correct_the_barometer_until_there_are_none() -> None:
    carpet = Box(low=(2.0, -9.0, 0.0), high=(40.0, 9.0, 0.01), surface=CLOTH)
    robot = blimp(1.5, around=Surroundings((carpet,)), seed=2)
    first = robot.readings.barometer
    fly(robot, 120.0)
    assert abs(robot.readings.barometer - first) > 0.15
    robot.command(surge=0.6)
    fly(robot, 12.0)
    robot.command()
    heights = [pose.z for pose in fly(robot, 12.0)]
    assert math.isnan(robot.readings.altitude)
    assert max(abs(height - 1.5) for height in heights) < 0.25


def test_on_the_ground_no_wind_moves_it() -> None:
    robot = blimp(wind=0.15)
    robot.land()
    fly(robot, 12.0)
    assert robot.flight is Flight.LANDED
    x = robot.pose.x
    fly(robot, 5.0)
    assert robot.pose.x == pytest.approx(x, abs=0.005)


def test_drafts_carry_it_and_the_hold_fails() -> None:
    robot = blimp(wind=0.1)
    fly(robot, 8.0)
    assert not robot.hold.fails
    fly(robot, 12.0)
    assert robot.hold.carried > 1.0
    assert robot.hold.fails
    assert abs(robot.hold.off) < 0.1


def test_an_empty_battery_drops_it_and_the_hold_fails() -> None:
    robot = blimp(charge=2e-4)
    fly(robot, 8.0)
    assert robot.battery.fraction == 0.0
    assert robot.hold.off < -0.3
    assert robot.hold.fails
    hold = robot.hold_state(HoldKind.HEIGHT, tolerance=0.3)
    assert hold.phase is HoldPhase.FAILING
    assert hold.error < -0.3
    fly(robot, 10.0)
    assert robot.pose.z == pytest.approx(SHAPE.below, abs=0.001)


def test_left_alone_it_lands_at_a_low_battery_but_not_under_command() -> None:
    robot = blimp(charge=LOW_BATTERY)
    robot.command()
    fly(robot, 2.0)
    assert robot.flight is Flight.FLYING
    robot.brake_and_hold()
    robot.resume()
    fly(robot, 2.0)
    assert robot.flight is Flight.FLYING
    robot.brake_and_hold()
    fly(robot, 12.0)
    assert robot.flight is Flight.LANDED


def test_a_command_ends_a_landing_and_takes_off_again() -> None:
    robot = blimp()
    robot.land()
    fly(robot, 2.0)
    robot.command()
    fly(robot, 0.1)
    assert robot.flight is Flight.LANDING
    assert robot.hold.height is None
    robot.command(yaw=0.1)
    assert robot.flight is Flight.FLYING
    robot.command()
    robot.land()
    fly(robot, 12.0)
    assert robot.flight is Flight.LANDED
    still = robot.pose
    robot.command(surge=0.5)
    fly(robot, 3.0)
    assert math.dist((still.x, still.y), (robot.pose.x, robot.pose.y)) < 0.001
    robot.command(heave=0.2)
    fly(robot, 6.0)
    robot.command()
    fly(robot, 6.0)
    assert robot.pose.z > 1.0
    assert robot.velocity.heave == pytest.approx(0.0, abs=0.03)


def test_it_stops_at_a_wall_and_does_not_fly_back_when_it_brakes() -> None:
    robot = blimp(around=Surroundings((WALL,)))
    robot.command(surge=0.7)
    fly(robot, 12.0)
    assert robot.contacts >= 1
    assert robot.touching
    assert robot.pose.x <= 2.0 - SHAPE.radius + 1e-9
    robot.command()
    fly(robot, 5.0)
    assert robot.pose.x > 2.0 - SHAPE.radius - 0.3


@settings(max_examples=repetitions(4, 50))
@given(
    commands=st.lists(
        st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-4, 4)), min_size=1, max_size=4
    ),
    seed=st.integers(0, 2**32),
)
def test_no_commands_bring_it_into_walls_ceiling_or_ground(
    commands: list[tuple[float, float, float]], seed: int
) -> None:
    around = Surroundings((WALL, TABLE), ceiling=3.0)
    robot = blimp(around=around, draft=0.1, seed=seed)
    for surge, heave, yaw in commands:
        robot.command(surge=surge, heave=heave, yaw=yaw)
        for pose in fly(robot, 3.0):
            assert SHAPE.below - 1e-9 <= pose.z <= 3.0 - SHAPE.above + 1e-9
            assert pose.x <= 2.0 - SHAPE.radius + 1e-9


def test_the_same_seed_and_calls_give_the_same_bits_and_reading_changes_nothing() -> None:
    def run(seed: int, *, peek: bool) -> list[object]:
        robot = blimp(draft=0.04, seed=seed)
        for number in range(20):
            robot.command(surge=0.1 * number, yaw=0.3 - 0.03 * number)
            robot.advance(0.13)
            if peek:
                assert robot.readings.height > 0.0
                assert robot.hold is not None
        return [robot.pose, robot.velocity, robot.readings, robot.battery, robot.hold]

    assert run(1, peek=False) == run(1, peek=True)
    assert run(1, peek=False) != run(2, peek=False)


@for_each("value", [math.nan, math.inf, -math.inf, 1e308])
def test_commands_and_times_that_are_no_numbers_do_no_harm(value: float) -> None:
    robot = blimp()
    robot.command(*[value] * 6)
    found = robot.commanded
    assert found == NEUTRAL if math.isnan(value) else abs(found.surge) == LIMITS.surge
    assert (found.sway, found.roll, found.pitch) == (0.0, 0.0, 0.0)
    robot.start_hold(HoldKind.HEIGHT, value if math.isinf(value) else math.nan)
    robot.advance(value)
    assert robot.time <= LONGEST_ADVANCE + STEP
    assert all(map(math.isfinite, (robot.pose.x, robot.pose.z, robot.velocity.yaw)))


def test_it_can_start_on_the_ground() -> None:
    robot = blimp(0.0)
    fly(robot, 2.0)
    assert robot.flight is Flight.LANDED
    assert robot.pose.z == SHAPE.below
    assert robot.velocity == BodyVelocity()
