"""The robot's tilt and height at the time of a picture."""

from __future__ import annotations

import math

import pytest

from hub.gcm.flight import Altitude
from hub.gcm.imu import Imu
from hub.modules.vision.stances import Stances


def flying() -> Stances:
    stances = Stances(stands=False)
    for number in range(5):
        stances.tilted(Imu.of(roll=0.1 * number, pitch=-0.2), 10.0 + 0.05 * number)
        stances.rose(Altitude(stamp=0.0, above_ground=1.0 + number), 10.0 + 0.1 * number)
    return stances


def test_a_stance_lies_between_the_measurements_before_and_after_it() -> None:
    stance = flying().at(10.125)
    assert stance.roll == pytest.approx(0.25)
    assert stance.pitch == pytest.approx(-0.2)
    assert stance.above_ground == pytest.approx(2.25)


@pytest.mark.parametrize("time", [9.9, 11.0])
def test_long_after_and_before_all_measurements_nothing_is_known(time: float) -> None:
    stance = flying().at(time)
    assert [*map(math.isnan, (stance.roll, stance.pitch, stance.above_ground))] == [True] * 3


def test_the_newest_measurement_holds_for_a_moment() -> None:
    assert flying().at(10.45).above_ground == 5.0


def test_a_robot_that_stands_is_on_the_ground_whatever_its_sensors_measure() -> None:
    stances = Stances(stands=True)
    assert (stances.at(1.0).above_ground, math.isnan(stances.at(1.0).roll)) == (0.0, True)
    stances.tilted(Imu.of(roll=0.3, pitch=0.1), 1.0)
    stances.rose(Altitude(stamp=0.0, above_ground=0.4), 1.0)
    assert (stances.at(1.1).roll, stances.at(1.1).above_ground) == (0.3, 0.0)


def test_a_height_that_is_not_measured_is_not_taken_for_the_ground() -> None:
    stances = Stances(stands=False)
    for above in (math.nan, 0.0):
        stances.rose(Altitude(stamp=0.0, depth=1.0, above_ground=above), 1.0)
        assert math.isnan(stances.at(1.1).above_ground)
