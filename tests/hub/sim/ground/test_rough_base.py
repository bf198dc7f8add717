"""What a wheeled and a tracked base master, and how they fail."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.sim.arena import load_arena
from hub.sim.ground.chassis import TRACKED, WHEELED, Chassis
from hub.sim.rough_base import STEP, RoughBase
from hub.sim.steps import LONGEST_ADVANCE
from tests.hub.sim.ground.grounds import (
    GROUSERS,
    RAISED,
    block,
    drive,
    drive_over,
    ground_arena,
    ramp,
    stepfields,
)
from tests.support.cases import for_each
from tests.support.magellan import SimulatedMagellan, magellan_body
from tests.support.repetitions import repetitions

YELLOW = load_arena("yellow")
STAIRS = ((35, 0.18, 0.257), (45, 0.2, 0.2))


def stairs(rise: float, run: float) -> str:
    return f"[[stairs]]\nat = [1.6, 0.0]\nwidth = 3.0\nrise = {rise}\nrun = {run}\nlanding = 2.0\n"


@for_each(("degrees", "over"), [(5, True), (15, True), (20, False)])
def test_wheels_go_over_ramps_of_15_degrees_and_stop_at_the_foot_of_20(
    degrees: int,
    over: bool,  # noqa: FBT001 - a column of the table
) -> None:
    went = drive_over(ramp(degrees), WHEELED, 2.4)
    assert (went.base.pose.x > 2.4) is over
    assert went.base.stuck is not over
    if over:
        assert went.pitch_deg == pytest.approx(degrees, abs=0.1)
    else:
        assert went.base.pose.x < 1.5


@for_each(("degrees", "over"), [(40, True), (45, False)])
def test_tracks_go_up_ramps_as_steep_as_their_grip_allows(
    degrees: int,
    over: bool,  # noqa: FBT001 - a column of the table
) -> None:
    """The limit is atan(grip - rolling resistance), 41 degrees for a grip of 0.9."""
    went = drive_over(ramp(degrees), TRACKED, 2.6)
    assert (went.base.pose.x > 2.6) is over
    assert not went.base.tipped
    assert went.base.odometry.x > went.base.pose.x - 0.6


@for_each(("height", "over"), [(0.01, True), (0.02, False)])
def test_wheels_climb_a_step_of_1_cm_and_not_of_2(
    height: float,
    over: bool,  # noqa: FBT001 - a column of the table
) -> None:
    """A wheel of radius R and grip mu alone climbs R (1 - 1 / sqrt(1 + mu^2)), 1.1 cm."""
    assert (drive_over(block(1.5, height), WHEELED, 2.2).base.pose.x > 2.2) is over


def test_tracks_climb_a_step_of_15_cm() -> None:
    assert drive_over(block(1.8, 0.15), TRACKED, 3.0).base.pose.x > 3.0


@for_each(("degrees", "rise", "run"), STAIRS)
def test_only_grousers_and_raised_flippers_climb_stairs(
    degrees: int, rise: float, run: float
) -> None:
    top, height = 1.6 + 4 * run, 5 * rise
    went = drive_over(stairs(rise, run), TRACKED, top + 0.6)
    assert went.base.pose.z < height - 0.3
    assert went.base.stuck
    went = drive_over(stairs(rise, run), GROUSERS, top + 0.6)
    assert went.base.pose.z == pytest.approx(height, abs=0.001)
    assert degrees - 2 < went.pitch_deg < degrees + 6


def test_with_all_flippers_up_it_is_too_short_for_the_steepest_stairs() -> None:
    up = math.radians(35.0)
    base = RoughBase(ground_arena(stairs(0.2, 0.2)), GROUSERS, flippers=(up, up))
    assert drive(base, 3.2).base.tipped


CROSSING = "[[ramps]]\nat = [1.2, -0.1]\ntiles = [1, 3]\n"


@for_each(
    ("text", "chassis", "over"),
    [
        (CROSSING, WHEELED, False),
        (stepfields("flat", 0.05, 1), WHEELED, False),
        (CROSSING, TRACKED, True),
        (stepfields("flat", 0.05, 1), TRACKED, True),
        (stepfields("hill", 0.05, 2), TRACKED, True),
        (stepfields("hill", 0.1, 3), TRACKED, False),
        (stepfields("hill", 0.1, 5), dataclasses.replace(TRACKED, grip=2.0), True),
    ],
)
def test_tracks_cross_ramps_and_stepfields_and_wheels_do_not(
    text: str,
    chassis: Chassis,
    over: bool,  # noqa: FBT001 - a column of the table
) -> None:
    went = drive_over(text, chassis, 3.0, seconds=10.0)
    assert (went.base.pose.x > 3.0) is over
    assert not went.base.tipped
    assert went.roll_deg < 35.0
    assert went.pitch_deg < 52.0
    if text == CROSSING and over:
        assert went.roll_deg > 10.0
        assert went.pitch_deg > 10.0


@for_each(
    ("chassis", "drop", "linear", "heading"),
    [(WHEELED, 0.5, 0.4, 0.0), (WHEELED, 0.5, -0.4, 180.0), (TRACKED, 1.2, 0.4, 0.0)],
)
def test_it_tips_over_an_edge_and_then_lies_below_it(
    chassis: Chassis, drop: float, linear: float, heading: float
) -> None:
    base = RoughBase(ground_arena(block(-1.0, drop, 2.5), heading_deg=heading), chassis)
    drive(base, 9.0, linear=linear)
    assert base.tipped
    assert not base.loads.any()
    base.advance(2.0)
    after = base.pose
    assert after.lean == pytest.approx(math.pi / 2, abs=0.01)
    assert after.x > 1.5
    assert after.z == pytest.approx(chassis.reach, abs=0.01)
    turned = base.odometry
    base.advance(2.0)
    assert base.pose.x == pytest.approx(after.x, abs=0.02)
    assert base.odometry != turned
    base.command(0.0, 0.0)
    base.advance(0.7)
    assert (base.wheel_linear, base.wheel_angular) == (0.0, 0.0)
    lies = base.pose
    base.advance(5.0)
    assert (base.pose.x, base.pose.y, base.pose.z) == pytest.approx((lies.x, lies.y, lies.z))


def test_a_post_under_its_belly_holds_it_up() -> None:
    text = block(0.53, 0.12, 0.15, 1.425, 0.15)
    base = RoughBase(ground_arena(text), WHEELED)
    assert base.loads @ [point.drives for point in WHEELED.points] == 0.0
    base.command(0.3, 0.5)
    base.advance(1.0)
    assert base.high_centred
    assert base.stuck
    assert (base.pose.x, base.pose.y, base.pose.yaw) == (0.6, 1.5, 0.0)
    assert base.odometry.x > 0.1


def test_odometry_counts_on_while_wheels_spin() -> None:
    base = drive_over(block(1.0, 0.1), WHEELED, 2.0).base
    stood, counted = base.pose, base.odometry
    base.advance(3.0)
    assert base.stuck
    assert (base.slip, base.linear, base.wheel_linear) == (1.0, 0.0, 0.4)
    assert (base.pose.x, base.pose.y) == (stood.x, stood.y)
    assert base.odometry.x - counted.x == pytest.approx(1.2, rel=0.15)


def test_odometry_measures_the_slope_and_not_the_map() -> None:
    base = RoughBase(ground_arena(ramp(15), (2.0, 1.5)), TRACKED, seed=4)
    flat = RoughBase(ground_arena(block(9.0, 0.1)), TRACKED, seed=4)
    for each in (base, flat):
        each.command(0.3, 0.0)
        each.advance(3.0)
    assert base.odometry == flat.odometry
    way, level = base.pose.x - 2.0, flat.pose.x - 0.6
    assert level / way == pytest.approx(1 / math.cos(math.radians(15.0)), rel=0.02)
    assert base.climb == pytest.approx(0.3 * math.sin(math.radians(15.0)), rel=0.05)


def test_it_slides_down_a_slope_that_its_brakes_do_not_hold() -> None:
    sand = "[[surface]]\nat = [0.0, 0.0]\nsize = [9.0, 3.0]\ngrip = 0.4\n"
    held = RoughBase(ground_arena(ramp(25), (2.8, 1.5)), TRACKED)
    slides = RoughBase(ground_arena(ramp(25) + sand, (2.8, 1.5)), TRACKED)
    for base in (held, slides):
        base.advance(1.0)
    assert (held.pose.x, held.slide_speed) == (2.8, 0.0)
    assert slides.slide_speed > 0.5
    assert slides.pose.x < 2.6
    slides.advance(4.0)
    assert slides.slide_speed == 0.0
    assert slides.odometry.x == 0.0


def test_a_pipe_that_turns_gives_no_hold_until_flippers_reach_the_floor() -> None:
    step = block(1.85, 0.1)
    pipe = "[[pipe]]\nat = [1.8, 0.0]\nlength = 3.0\nheight = 0.1\nturning = "
    still = drive_over(step + pipe + "false\n", GROUSERS, 2.2).base
    assert still.pose.x > 2.2
    base = drive_over(step + pipe + "true\n", GROUSERS, 2.2).base
    assert base.stuck
    assert base.pose.x < 1.85
    base.command_flippers(math.radians(-30.0), math.radians(-30.0))
    base.advance(3.0)
    assert base.pose.x > 2.2


def test_a_deck_carries_a_base_from_its_ramp_and_roofs_a_base_below_it() -> None:
    deck = "[[deck]]\nat = [3.0, 0.0]\nsize = [3.0, 3.0]\nheight = 0.6\n"
    way_up = "[[ramp]]\nat = [1.0, 1.0]\nsize = [2.0, 1.0]\nhigh = 0.6\n"
    above = drive(RoughBase(ground_arena(deck + way_up), TRACKED), 3.7).base
    assert above.pose.z == pytest.approx(0.6, abs=0.001)
    below = drive(RoughBase(ground_arena(deck + way_up, (1.5, 0.5)), TRACKED), 3.7).base
    assert (below.pose.x > 3.7, below.pose.z) == (True, 0.0)
    low = deck.replace("0.6", "0.4")
    stopped = drive(RoughBase(ground_arena(low), TRACKED), 3.7).base
    assert stopped.pose.x == pytest.approx(3.0 - TRACKED.reach, abs=0.02)


def test_a_box_below_the_deck_does_not_stop_it_above_and_a_wall_does() -> None:
    deck = "[[deck]]\nat = [3.0, 0.0]\nsize = [5.0, 3.0]\nheight = 0.8\n"
    way_up = "[[ramp]]\nat = [1.0, 0.0]\nsize = [2.0, 3.0]\nhigh = 0.8\n"
    things = (
        "[[box]]\nat = [4.0, 1.5]\nsize = [0.4, 0.4, 0.5]\n"
        "[[wall]]\nfrom = [5.5, 0.0]\nto = [5.5, 3.0]\nheight = 1.5\n"
    )
    arena = ground_arena(deck + way_up + things)
    base = drive(RoughBase(arena, TRACKED, bumpers=magellan_body().bumpers), 6.0).base
    assert base.pose.x == pytest.approx(5.45 - TRACKED.reach, abs=1e-3)
    assert base.touches
    assert base.contacts == 1
    assert base.bumpers == 1
    assert (base.linear, base.stuck) == (pytest.approx(0.0, abs=1e-3), False)


def test_a_wall_that_it_touches_all_the_way_up_a_ramp_is_one_contact() -> None:
    wall = "[[wall]]\nfrom = [0.0, 1.95]\nto = [9.0, 1.95]\nheight = 3.0\n"
    base = RoughBase(ground_arena(ramp(15) + wall, (0.6, 1.53), heading_deg=8.0), TRACKED)
    drive(base, 4.0)
    assert base.pose.z > 0.5
    assert base.touches
    assert base.contacts == 1


@settings(max_examples=repetitions(4, 40))
@given(
    seed=st.integers(0, 2**32),
    commands=st.lists(
        st.tuples(st.floats(-1.0, 1.0), st.floats(-2.0, 2.0)), min_size=1, max_size=4
    ),
)
def test_on_a_level_floor_it_moves_as_the_base_without_a_height_map_to_the_last_bit(
    seed: int, commands: list[tuple[float, float]]
) -> None:
    rough, flat = RoughBase(YELLOW, WHEELED, seed=seed), SimulatedMagellan(YELLOW, seed=seed)
    for linear, angular in commands:
        rough.command(linear, angular)
        flat.set_velocity(linear, angular)
        rough.advance(0.7)
        flat.advance(0.7)
        truth, state = flat.ground_truth(), flat.sensors(0.0)
        assert (rough.pose.x, rough.pose.y, rough.pose.yaw) == (truth.x, truth.y, truth.theta)
        assert rough.odometry == type(rough.odometry)(x=state.x, y=state.y, theta=state.theta)
        assert (rough.linear, rough.angular) == (truth.linear, truth.angular)
        assert (rough.pose.z, rough.pose.roll, rough.pose.pitch) == (0.0, 0.0, 0.0)
        assert rough.contacts == truth.contacts


def test_the_same_seed_and_commands_give_the_same_bits() -> None:
    arena = ground_arena(stepfields("flat", 0.05, 7))

    def run(seed: int) -> tuple[object, ...]:
        random = np.random.default_rng(9)
        base = RoughBase(arena, TRACKED, seed=seed)
        for _ in range(6):
            base.command(float(random.uniform(0.0, 0.5)), float(random.uniform(-0.5, 0.5)))
            base.command_flippers(float(random.uniform(0.0, 1.0)), 0.0)
            base.advance(0.33)
        return base.pose, base.loads.tobytes(), base.odometry

    assert run(1) == run(1)
    assert run(1)[:2] == run(2)[:2]
    assert run(1) != run(2)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308])
def test_commands_and_times_that_are_no_numbers_do_no_harm(value: float) -> None:
    base = RoughBase(ground_arena(block(9.0, 0.1)), TRACKED)
    base.command(value, value)
    base.command_flippers(value, value)
    base.advance(0.1)
    linear, angular = base.commanded
    assert abs(linear) <= 0.5
    assert abs(angular) <= 1.0
    if math.isnan(value):
        home = tuple(pair.home for pair in TRACKED.flippers)
        assert (linear, angular, base.flippers) == (0.0, 0.0, home)
    before = base.steps
    base.advance(value)
    assert 0 <= base.steps - before <= LONGEST_ADVANCE / STEP + 1
    assert math.isfinite(base.pose.x + base.pose.z)


def test_at_rest_on_rough_ground_nothing_moves_until_the_next_command() -> None:
    base = RoughBase(ground_arena(stepfields("flat", 0.05, 7), (2.0, 1.5)), TRACKED)
    base.advance(5.0)
    pose, loads = base.pose, base.loads
    base.advance(5.0)
    assert base.pose == pose
    assert (base.loads == loads).all()
    assert base.climb == 0.0
    base.command(0.3, 0.0)
    base.advance(1.0)
    assert base.pose.x > pose.x


def test_a_turn_against_the_side_of_a_step_stops_there_and_goes_back() -> None:
    base = RoughBase(ground_arena(block(0.8, 0.5), (0.615, 1.5)), WHEELED)
    base.command(0.0, 0.5)
    heights = []
    for _ in range(20):
        base.advance(0.05)
        heights.append(base.pose.z)
    assert max(heights) < 0.01
    assert base.stuck
    turned = base.pose.yaw
    assert 0.1 < turned < math.pi / 8
    base.command(0.0, -0.5)
    base.advance(0.5)
    assert base.pose.yaw < turned - 0.1


def test_flippers_turn_at_their_speed_within_their_limits_and_lift_the_body() -> None:
    base = RoughBase(ground_arena(block(9.0, 0.1)), TRACKED, flippers=(0.0, 0.0))
    base.command_flippers(9.0, -9.0)
    base.advance(0.2)
    assert base.flippers == pytest.approx((0.2, -0.2))
    base.advance(4.0)
    assert base.flippers == (TRACKED.flippers[0].limits[1], TRACKED.flippers[1].limits[0])
    assert math.degrees(base.pose.pitch) == pytest.approx(20.0, abs=8.0)
    base.command_flippers(-9.0, -9.0)
    base.advance(5.0)
    lifted = 0.3 * math.sin(math.radians(60.0))
    assert base.pose.z == pytest.approx(lifted, abs=0.005)
    base.command_flippers(math.nan, 0.0)
    base.advance(5.0)
    assert base.flippers == (TRACKED.flippers[0].limits[0], 0.0)
    assert base.pose.pitch < 0.0


def test_a_robot_of_another_size_keeps_its_own_distance_from_walls() -> None:
    wall = "[[wall]]\nfrom = [3.0, 0.0]\nto = [3.0, 3.0]\n"
    for chassis, reach in ((WHEELED, WHEELED.reach), (TRACKED, TRACKED.reach)):
        base = drive(
            RoughBase(ground_arena(wall), chassis, flippers=RAISED if chassis.flippers else None),
            9.0,
            8.0,
        ).base
        assert base.pose.x == pytest.approx(2.95 - reach, abs=1e-4)
