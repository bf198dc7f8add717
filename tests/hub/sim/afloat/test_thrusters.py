"""Thrusters, tether, drafts and batteries against the numbers of their sources."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.sim.afloat.floating_body import STILL
from hub.sim.afloat.fluid import Drafts, submerged, thrust_share
from hub.sim.afloat.lithium_battery import LithiumBattery
from hub.sim.afloat.tether import Tether, TetherSpec, drag_factor
from hub.sim.afloat.thrusters import (
    FRONT,
    LIFT,
    MIX,
    MOST_THRUST,
    TAIL,
    EightThrusters,
    Propellers,
    allocated,
    t200_throttle,
    t200_thrust,
)
from hub.sim.arena_specs import AirSpec
from tests.support.cases import for_each

FORCE, MOMENT = st.floats(-200.0, 200.0), st.floats(-30.0, 30.0)
SMALL = st.floats(-5.0, 5.0)


@for_each(("throttle", "thrust"), [(0.0, 0.0), (0.25, 4.603), (0.5, 16.594), (0.972, 30.6)])
def test_the_curve_of_a_thruster_is_that_of_its_source(throttle: float, thrust: float) -> None:
    """By hand: at 0.25 the terms are 2.225 + 2.75 - 0.395 + 0.024 - 0.001, which is 4.60."""
    found = t200_thrust(np.array([throttle, -throttle]))
    assert found == pytest.approx([thrust, -thrust], rel=0.001, abs=1e-9)


def test_a_throttle_gives_the_thrust_that_it_was_computed_for() -> None:
    thrusts = np.linspace(-MOST_THRUST, MOST_THRUST, 101)
    assert t200_thrust(t200_throttle(thrusts)) == pytest.approx(thrusts, abs=0.01)
    assert (np.diff(t200_throttle(thrusts)) > 0.0).all()
    assert pytest.approx(30.6, rel=0.01) == MOST_THRUST
    assert t200_throttle(np.array([99.0])) == pytest.approx([0.972], abs=0.002)


@given(wrench=st.tuples(SMALL, SMALL, SMALL, SMALL, SMALL, SMALL))
def test_eight_thrusters_give_each_force_and_moment(
    wrench: tuple[float, float, float, float, float, float],
) -> None:
    assert MIX @ allocated(wrench) == pytest.approx(wrench, abs=1e-9)


@given(wrench=st.tuples(FORCE, FORCE, FORCE, SMALL, SMALL, MOMENT))
def test_too_much_shrinks_surge_sway_yaw_and_heave_but_not_what_keeps_upright(
    wrench: tuple[float, float, float, float, float, float],
) -> None:
    thrusts = allocated(wrench)
    assert (np.abs(thrusts) <= MOST_THRUST + 1e-9).all()
    found = MIX @ thrusts
    # At full thrust of the other four, the moments of surge and sway leave this much.
    assert found[3:5] == pytest.approx(wrench[3:5], abs=1e-6)
    for axis in (0, 1, 2, 5):
        assert abs(found[axis]) <= abs(wrench[axis]) + 1e-9 or axis == 2
    assert found[0] * wrench[1] == pytest.approx(found[1] * wrench[0], abs=1e-6)


def test_thrust_for_motion_is_gone_soon_after_it_is_not_wanted() -> None:
    thrusters = EightThrusters()
    for _ in range(100):
        thrusters.advance((60.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0.02)
    assert thrusters.wrench[0] == pytest.approx(60.0, rel=0.01)
    power = thrusters.power
    for _ in range(17):
        thrusters.advance(STILL, 0.02)
    assert abs(thrusters.wrench[0]) < 0.05 * 60.0
    assert thrusters.power < 0.05 * power


def test_propellers_are_limited_each_way_and_pitch_and_roll_the_blimp() -> None:
    propellers = Propellers()
    for _ in range(200):
        propellers.advance(1.0, 1.0, -1.0, 0.02)
    assert (propellers.ahead, propellers.left, propellers.up) == pytest.approx(
        (FRONT[0], TAIL[0], -LIFT[1])
    )
    x, y, z, roll, pitch, yaw = propellers.wrench
    assert (x, y, z) == pytest.approx((0.040, -0.025, -0.025))
    assert roll == pytest.approx(-0.073 * 0.025)
    assert pitch == pytest.approx(-0.144 * 0.040 + 0.045 * 0.025)
    assert yaw == pytest.approx(0.484 * 0.025)


def test_drafts_have_their_strength_and_forget_it_in_seconds() -> None:
    drafts = Drafts(AirSpec(draft=0.1, wind=(0.3, 0.0)), np.random.SeedSequence(1))
    flows = []
    for _ in range(8000):
        drafts.advance(0.5)
        flows.append(drafts.flow)
    found = np.array(flows)
    assert found.mean(axis=0) == pytest.approx((0.3, 0.0, 0.0), abs=0.01)
    assert found.std(axis=0) == pytest.approx((0.1, 0.1, 0.05), rel=0.05)
    east = found[:, 0] - 0.3
    assert (east[8:] * east[:-8]).mean() / east.var() == pytest.approx(math.exp(-1.0), abs=0.08)


def test_a_robot_displaces_less_as_it_leaves_the_water() -> None:
    assert [submerged(depth) for depth in (2.0, 0.127, 0.0, -0.127)] == [1.0, 1.0, 0.5, 0.0]
    assert [thrust_share(depth) for depth in (2.0, 0.05, 0.0, -0.1)] == [1.0, 0.5, 0.0, 0.0]


def test_a_third_of_the_tether_drags_across_the_water() -> None:
    """0.5 rho C d L / 3 of 21 m, as a cylinder across the flow."""
    factor = 0.5 * 1026.0 * 1.2 * 0.0075 * 7.0
    assert drag_factor(21.0) == pytest.approx(factor)
    tether = Tether(TetherSpec(length=25.0, anchor=(0.0, 0.0, 0.0)), (21.0, 0.0, 0.0), 0.0)
    pull = tether.pull((21.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.1, 0.0))
    assert pull == pytest.approx((0.0, -factor * 0.16, 0.0))
    assert (tether.paid_out, tether.used) == pytest.approx((21.0, 0.84))


def test_a_tether_that_is_all_out_holds_the_robot_back() -> None:
    tether = Tether(TetherSpec(length=10.0, anchor=(0.0, 0.0, 0.0)), (0.0, 0.0, 0.0), 0.0)
    assert tether.pull((10.2, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))[0] == pytest.approx(-80)
    stretched = tether.pull((10.2, 0.0, 0.0), (0.5, 0.0, 0.0), (0.5, 0.0, 0.0))[0]
    assert stretched == pytest.approx(-110.0)
    assert tether.used == 1.0


def test_a_tether_counts_turns_across_half_a_turn() -> None:
    tether = Tether(TetherSpec(length=10.0, anchor=(0.0, 0.0, 0.0)), (0.0, 0.0, 0.0), 3.0)
    for number in range(1, 101):
        tether.follow(math.remainder(3.0 + number * 0.05 * math.tau, math.tau))
    assert tether.turns == pytest.approx(5.0)
    for number in range(99, -1, -1):
        tether.follow(math.remainder(3.0 + number * 0.05 * math.tau, math.tau))
    assert tether.turns == pytest.approx(0.0)


def test_a_lithium_battery_empties_with_power_and_its_voltage_falls_under_load() -> None:
    full = LithiumBattery(cells=4, energy=266.0 * 3600.0, resistance=0.02)
    assert full.voltage == pytest.approx(16.8)
    loaded = full.after(3600.0, 133.0)
    assert loaded.fraction == pytest.approx(0.5)
    assert loaded.voltage < loaded.after(0.0, 0.0).voltage < full.voltage
    assert loaded.after(1e9, 133.0).fraction == 0.0
