"""The body in a fluid against closed forms, to one per cent, and its energy."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.orientation import quaternion, roll_pitch_yaw
from hub.sim.afloat import blimp, rov
from hub.sim.afloat.attitude import (
    into_body,
    into_world,
    up_in_body,
)
from hub.sim.afloat.floating_body import STILL, FloatingBody, HullSpec, Six
from hub.sim.afloat.fluid import AIR_DENSITY
from hub.sim.afloat.thrusters import FRONT, LIFT, MOST_THRUST, TAIL, TAIL_BEHIND
from hub.sim.afloat.vehicle import STEP
from hub.sim.steps import GRAVITY
from tests.hub.sim.afloat.closed_forms import energy, steady_speed
from tests.support.cases import for_each

BLIMP, ROV = blimp.hull(), rov.hull()
HULLS = {"blimp": BLIMP, "rov": ROV}
EXACT = 0.01
ANGLES = st.floats(-1.5, 1.5)
SPEEDS = st.floats(-0.8, 0.8)


def run(body: FloatingBody, thrust: Six, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        body.step(thrust, STEP)


def neutral(hull: HullSpec) -> HullSpec:
    return dataclasses.replace(hull, volume=hull.mass / hull.density)


def undamped(hull: HullSpec) -> HullSpec:
    return dataclasses.replace(neutral(hull), linear=STILL, quadratic=STILL)


def test_forward_speed_of_the_blimp_follows_the_hyperbolic_tangent() -> None:
    """m u' = F - D u^2 has the solution u = sqrt(F / D) tanh(t / tau)."""
    thrust, drag = FRONT[0], BLIMP.quadratic[0]
    final = math.sqrt(thrust / drag)
    tau = (BLIMP.mass + BLIMP.added[0]) / (drag * final)
    assert final == pytest.approx(0.756, rel=EXACT)
    assert tau == pytest.approx(4.1, rel=EXACT)
    body = FloatingBody(BLIMP)
    for number in range(1, 1001):
        # Through the centre of mass, so that it does not pitch.
        body.step((thrust, 0.0, 0.0, 0.0, -BLIMP.sag * thrust, 0.0), STEP)
        wanted = final * math.tanh(number * STEP / tau)
        assert body.velocity[0] == pytest.approx(wanted, abs=EXACT * final)
    assert body.velocity[0] == pytest.approx(final, rel=EXACT)


def test_the_blimp_turns_as_fast_as_the_drag_of_its_turn_allows() -> None:
    for thrust in TAIL:
        body = FloatingBody(BLIMP)
        moment = thrust * TAIL_BEHIND
        final, tau = moment / BLIMP.linear[5], BLIMP.inertia[2] / BLIMP.linear[5]
        for number in range(1, 501):
            body.step((0.0, 0.0, 0.0, 0.0, 0.0, moment), STEP)
            wanted = final * (1.0 - math.exp(-number * STEP / tau))
            assert body.velocity[5] == pytest.approx(wanted, abs=EXACT * final)
    assert final == pytest.approx(1.838, rel=EXACT)


@for_each(("thrust", "speed"), [(LIFT[0], 0.452), (-LIFT[1], -0.337)])
def test_the_blimp_climbs_as_fast_as_its_drag_allows(thrust: float, speed: float) -> None:
    body = FloatingBody(BLIMP)
    run(body, (0.0, 0.0, thrust, 0.0, 0.0, 0.0), 25.0)
    assert body.velocity[2] == pytest.approx(speed, rel=EXACT)
    assert steady_speed(BLIMP, 2, thrust) == pytest.approx(speed, rel=EXACT)


@for_each(("grams", "sinking"), [(1, 0.211), (2, 0.299), (5, 0.472)])
def test_a_heavy_blimp_sinks_without_thrust(grams: float, sinking: float) -> None:
    body = FloatingBody(blimp.hull(grams / 1000.0))
    run(body, STILL, 40.0)
    assert body.velocity[2] == pytest.approx(-sinking, rel=EXACT)


def test_the_rov_is_as_fast_as_its_thrusters_and_its_drag_say() -> None:
    ahead = 4.0 * MOST_THRUST * math.sqrt(0.5)
    up = 4.0 * MOST_THRUST
    lift = ROV.buoyancy - ROV.weight
    assert lift == pytest.approx(2.44, rel=EXACT)
    assert rov.hull(1000.0).buoyancy - ROV.weight == pytest.approx(-0.98, rel=EXACT)
    body = FloatingBody(dataclasses.replace(neutral(ROV), sag=0.0))
    run(body, (ahead, 0.0, 0.0, 0.0, 0.0, 0.0), 10.0)
    assert body.velocity[0] == pytest.approx(steady_speed(ROV, 0, ahead), rel=EXACT)
    assert body.velocity[0] == pytest.approx(0.734, rel=EXACT)
    body = FloatingBody(ROV)
    run(body, (0.0, 0.0, up, 0.0, 0.0, 0.0), 10.0)
    assert body.velocity[2] == pytest.approx(steady_speed(ROV, 2, up + lift), rel=EXACT)
    assert body.velocity[2] == pytest.approx(0.726, rel=EXACT)


@for_each(("density", "speed"), [(1026.0, 0.056), (1000.0, -0.0257)])
def test_an_rov_without_power_rises_in_the_sea_and_sinks_in_fresh_water(
    density: float, speed: float
) -> None:
    body = FloatingBody(rov.hull(density))
    run(body, STILL, 15.0)
    assert body.velocity[2] == pytest.approx(speed, rel=EXACT)


@for_each(
    ("name", "axis", "period"),
    [("blimp", 0, 1.169), ("blimp", 1, 1.718), ("rov", 0, 3.65)],
)
def test_a_body_swings_with_the_period_of_its_reduced_inertia(
    name: str, axis: int, period: float
) -> None:
    hull = undamped(HULLS[name])
    moment = hull.mass * hull.sag
    inertia = hull.inertia[axis] - moment**2 / (hull.mass + hull.added[1 - axis])
    closed = math.tau * math.sqrt(inertia / (moment * GRAVITY))
    assert closed == pytest.approx(period, rel=EXACT)
    tilt = [0.05, 0.0, 0.0] if axis == 0 else [0.0, 0.05, 0.0]
    body = FloatingBody(hull, attitude=quaternion(*tilt))
    crossings, last = [], 0.05
    for number in range(1, 1000):
        body.step(STILL, STEP)
        angle = roll_pitch_yaw(*body.attitude)[axis]
        if last * angle < 0.0:
            crossings.append((number - angle / (angle - last)) * STEP)
        last = angle
    halves = [later - sooner for sooner, later in pairwise(crossings)]
    assert 2.0 * sum(halves) / len(halves) == pytest.approx(closed, rel=EXACT)


@for_each(("name", "roll"), [("blimp", 0.3), ("rov", 0.2)])
def test_the_weight_rights_the_body(name: str, roll: float) -> None:
    hull = HULLS[name]
    body = FloatingBody(neutral(hull), attitude=quaternion(roll, 0.0, 0.0))
    change = body.acceleration(STILL, body.attitude, STILL)
    moment = hull.inertia[0] * change[3] + hull.mass * hull.sag * change[1]
    assert moment == pytest.approx(-hull.weight * hull.sag * math.sin(roll), rel=EXACT)


@for_each("name", HULLS)
def test_energy_is_nearly_kept_without_drag(name: str) -> None:
    hull = undamped(HULLS[name])
    body = FloatingBody(hull, attitude=quaternion(0.3, -0.4, 1.0))
    body.velocity = (0.5, -0.2, 0.1, 0.4, -0.3, 0.5)
    start = energy(body)
    kinetic = start - energy(FloatingBody(hull, attitude=body.attitude))
    run(body, STILL, 60.0)
    # The scale: kinetic energy, and that of a swing from upright to flat.
    assert abs(energy(body) - start) < 0.01 * (kinetic + hull.weight * hull.sag)


@given(
    name=st.sampled_from(sorted(HULLS)),
    angles=st.tuples(ANGLES, ANGLES, ANGLES),
    speeds=st.tuples(SPEEDS, SPEEDS, SPEEDS, SPEEDS, SPEEDS, SPEEDS),
)
def test_energy_never_rises_without_thrust(
    name: str, angles: tuple[float, float, float], speeds: Six
) -> None:
    body = FloatingBody(HULLS[name], attitude=quaternion(*angles))
    body.velocity = speeds
    before = energy(body)
    for _ in range(100):
        body.step(STILL, STEP)
        assert energy(body) <= before + 1e-9
        before = energy(body)


@given(
    angles=st.tuples(ANGLES, ANGLES, ANGLES),
    speeds=st.tuples(SPEEDS, SPEEDS, SPEEDS, SPEEDS, SPEEDS, SPEEDS),
    normal=st.tuples(ANGLES, ANGLES),
    share=st.floats(0.0, 1.0),
)
def test_a_strike_ends_the_motion_against_it_and_adds_no_energy(
    angles: tuple[float, float, float], speeds: Six, normal: tuple[float, float], share: float
) -> None:
    body = FloatingBody(BLIMP, attitude=quaternion(*angles))
    body.velocity = speeds
    before = energy(body)
    direction = into_world(quaternion(0.0, *normal), (1.0, 0.0, 0.0))
    against = sum(a * b for a, b in zip(direction, body.world_velocity, strict=True))
    body.strike(direction, share)
    after = sum(a * b for a, b in zip(direction, body.world_velocity, strict=True))
    assert after == pytest.approx(against * (1.0 - share) if against < 0.0 else against, abs=1e-9)
    assert energy(body) <= before + 1e-9


def test_a_body_drifts_with_the_fluid_and_a_draft_does_not_turn_a_still_one() -> None:
    """Drag alone takes it along: 1 / u_r grows by D t / (m + A)."""
    body = FloatingBody(BLIMP)
    for _ in range(3000):
        body.step(STILL, STEP, flow=(0.3, 0.0, 0.0))
    grown = BLIMP.quadratic[0] * 60.0 / (BLIMP.mass + BLIMP.added[0])
    assert body.velocity[0] == pytest.approx(0.3 - 1.0 / (1.0 / 0.3 + grown), rel=EXACT)
    assert abs(roll_pitch_yaw(*body.attitude)[2]) < 1e-9
    assert BLIMP.mass == pytest.approx(BLIMP.volume * AIR_DENSITY)


def test_a_body_that_moves_with_a_current_turns_in_it_undisturbed() -> None:
    body = FloatingBody(dataclasses.replace(neutral(ROV), linear=STILL, quadratic=STILL))
    body.velocity = (0.3, -0.2, 0.0, 0.0, 0.0, 0.5)
    for _ in range(200):
        body.step(STILL, STEP, flow=(0.3, -0.2, 0.0))
    assert body.world_velocity == pytest.approx((0.3, -0.2, 0.0), abs=0.001)
    assert body.velocity[5] == pytest.approx(0.5, abs=0.001)


@given(angles=st.tuples(ANGLES, ANGLES, ANGLES), normal=st.tuples(ANGLES, ANGLES))
def test_a_strike_changes_the_velocity_as_a_force_there_does(
    angles: tuple[float, float, float], normal: tuple[float, float]
) -> None:
    body = FloatingBody(BLIMP, attitude=quaternion(*angles))
    direction = into_world(quaternion(0.0, *normal), (1.0, 0.0, 0.0))
    force = into_body(body.attitude, direction)
    pushed = body.acceleration(STILL, body.attitude, (*force, 0.0, 0.0, 0.0))
    free = body.acceleration(STILL, body.attitude, STILL)
    wanted = [one - other for one, other in zip(pushed, free, strict=True)]
    body.velocity = (-force[0], -force[1], -force[2], 0.0, 0.0, 0.0)
    before = body.velocity
    body.strike(direction)
    found = [one - other for one, other in zip(body.velocity, before, strict=True)]
    scale = math.hypot(*found) / math.hypot(*wanted)
    assert found == pytest.approx([scale * each for each in wanted], abs=1e-9)


@given(angles=st.tuples(ANGLES, ANGLES, ANGLES), vector=st.tuples(SPEEDS, SPEEDS, SPEEDS))
def test_attitudes_turn_vectors_there_and_back(
    angles: tuple[float, float, float], vector: tuple[float, float, float]
) -> None:
    attitude = quaternion(*angles)
    assert roll_pitch_yaw(*attitude) == pytest.approx(angles, abs=1e-9)
    assert into_body(attitude, into_world(attitude, vector)) == pytest.approx(vector, abs=1e-9)
    assert up_in_body(attitude) == pytest.approx(into_body(attitude, (0.0, 0.0, 1.0)), abs=1e-9)


def test_pitch_lowers_the_nose_and_yaw_turns_left() -> None:
    ahead = (1.0, 0.0, 0.0)
    assert into_world(quaternion(0.0, 0.5, 0.0), ahead)[2] < 0.0
    assert into_world(quaternion(0.0, 0.0, 0.5), ahead)[1] > 0.0
    assert into_world(quaternion(0.5, 0.0, 0.0), (0.0, 1.0, 0.0))[2] > 0.0
