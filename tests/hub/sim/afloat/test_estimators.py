"""What a floating robot makes of faulty sensors."""

from __future__ import annotations

import math

import pytest

from hub.sim.afloat import blimp, rov
from hub.sim.afloat.estimators import (
    AirspeedObserver,
    ClimbObserver,
    EchoReference,
    HeadingFilter,
)
from hub.sim.afloat.floating_body import STILL, FloatingBody
from hub.sim.afloat.holds import (
    ClimbGains,
    HeadingHold,
    HeightHold,
    RestingPlace,
    TiltGains,
    TiltHold,
    TurnGains,
)

CLIMB = ClimbGains(climb_per_metre=0.5, fastest=0.3, force_per_climb=0.3, stopped=0.05)
TURN = TurnGains(moment_per_angle=2.0, moment_per_rate=1.0, stopped=0.1)


def test_an_observer_finds_climb_and_weight_from_heights_alone() -> None:
    spec = blimp.hull(0.002)
    body = FloatingBody(spec, (0.0, 0.0, 2.0))
    seen = ClimbObserver(spec, height=2.0, rate=1.5, most_trim=0.06)
    for number in range(1500):
        body.step((0.0, 0.0, 0.01, 0.0, 0.0, 0.0), 0.02)
        seen.predict(0.01, 0.02)
        if number % 5 == 0:
            seen.correct(body.position[2], 0.1)
    assert seen.height == pytest.approx(body.position[2], abs=0.02)
    assert seen.climb == pytest.approx(body.velocity[2], abs=0.01)
    assert seen.trim == pytest.approx(spec.buoyancy - spec.weight, rel=0.05)


def test_a_table_below_is_rejected_then_becomes_the_ground() -> None:
    echoes = EchoReference()
    assert echoes.height(1.5, 1.5) == 1.5
    jumped = [echoes.height(0.75, 1.5) for _ in range(EchoReference.JUMPS)]
    assert all(map(math.isnan, jumped[:-1]))
    assert jumped[-1] == 1.5
    assert echoes.ground == pytest.approx(0.75)
    assert echoes.height(0.8, 1.5) == pytest.approx(1.55)
    back = [echoes.height(1.5, 1.52) for _ in range(EchoReference.JUMPS)]
    assert back[-1] == 1.52
    assert echoes.ground == pytest.approx(0.02)


def test_single_false_echoes_and_missing_ones_change_no_ground() -> None:
    echoes = EchoReference()
    for _ in range(10):
        for _ in range(EchoReference.JUMPS - 1):
            assert math.isnan(echoes.height(0.5, 1.5))
        assert math.isnan(echoes.height(math.nan, 1.5))
    assert echoes.height(1.5, 1.5) == 1.5


def test_a_heading_follows_the_gyro_at_once_and_the_compass_in_seconds() -> None:
    headings = HeadingFilter(3.0)
    for _ in range(50):
        headings.advance(0.5, 3.5, 0.02)
    assert headings.heading == pytest.approx(3.5 - math.tau, abs=0.06) or headings.heading > 3.0
    for _ in range(2000):
        headings.advance(0.0, -3.0, 0.02)
    assert headings.heading == pytest.approx(-3.0, abs=0.01)


def test_an_anemometer_that_stands_ends_a_wrong_estimate() -> None:
    """Against a wall the thrust says that it flies, and the anemometer that it does not."""
    seen = AirspeedObserver(blimp.hull(), least=0.05)
    for _ in range(500):
        seen.advance(0.04, 0.0, 0.02)
    assert seen.speed < 0.15
    for _ in range(500):
        seen.advance(0.0, 0.6, 0.02)
    assert seen.speed == pytest.approx(0.6, abs=0.05)


def test_an_anemometer_that_stands_says_nothing_of_slow_air() -> None:
    seen = AirspeedObserver(blimp.hull(), least=0.05)
    seen.speed = 0.04
    for _ in range(50):
        seen.advance(0.0, 0.0, 0.02)
    assert seen.speed == pytest.approx(0.04, rel=0.05)


def test_a_height_hold_climbs_by_command_brakes_then_holds() -> None:
    spec = rov.hull()
    seen = ClimbObserver(spec, height=1.0, rate=2.0, most_trim=10.0)
    hold = HeightHold(spec, CLIMB)
    assert hold.lift(seen, 0.2) > spec.drag(2, 0.2)
    assert hold.goal is None
    seen.climb = 0.2
    assert hold.lift(seen, 0.0) < 0.0
    assert hold.goal is None
    seen.climb = 0.01
    hold.lift(seen, 0.0)
    assert hold.goal == 1.0
    seen.height = 1.5
    assert hold.lift(seen, 0.0) < 0.0
    assert hold.off(seen.height) == pytest.approx(0.5)
    hold.hold(3.0)
    hold.lift(seen, 0.0)
    assert hold.off(seen.height) == 0.0


def test_the_trim_is_lifted_and_the_wanted_climb_is_limited() -> None:
    spec = rov.hull()
    seen = ClimbObserver(spec, height=0.0, rate=2.0, most_trim=10.0)
    hold = HeightHold(spec, CLIMB)
    hold.hold(0.0)
    seen.trim = -3.0
    assert hold.lift(seen, 0.0) == pytest.approx(3.0)
    hold.hold(100.0)
    seen.climb, seen.trim = 0.3, 0.0
    assert hold.lift(seen, 0.0) == pytest.approx(spec.drag(2, 0.3))


def test_a_heading_hold_takes_the_short_way() -> None:
    hold = HeadingHold(rov.hull(), TURN)
    hold.hold(math.pi - 0.1)
    assert hold.moment(-math.pi + 0.1, 0.0, 0.0) == pytest.approx(-0.4)
    assert hold.moment(0.0, 0.0, 1.0) == pytest.approx(1.0 + rov.hull().drag(5, 1.0))
    assert hold.goal is None
    assert hold.moment(0.5, 1.0, 0.0) == pytest.approx(-1.0)
    hold.moment(0.7, 0.05, 0.0)
    assert hold.goal == 0.7


def test_commanded_tilts_stay_within_their_limit_until_the_body_is_levelled() -> None:
    hold = TiltHold(TiltGains(moment_per_angle=10.0, moment_per_rate=1.0, most=0.5))
    hold.turn(1.0, -0.2, 1.0)
    assert (hold.roll, hold.pitch) == (0.5, -0.2)
    assert hold.moments(0.5, 0.0, 0.1, 0.0) == pytest.approx((-0.1, -2.0))
    hold.level()
    assert hold.moments(0.0, 0.0, 0.0, 0.0) == STILL[:2]


def test_a_robot_is_carried_from_where_it_came_to_rest() -> None:
    place = RestingPlace(0.1)
    place.follow(1.0, 0.0, 0.5, moving=True)
    place.follow(2.0, 0.0, 0.2, moving=False)
    assert place.braking
    assert place.carried(9.0, 0.0) == 0.0
    place.follow(3.0, 0.0, 0.05, moving=False)
    place.follow(4.0, 0.0, 0.3, moving=False)
    assert not place.braking
    assert place.carried(6.0, 4.0) == 5.0
