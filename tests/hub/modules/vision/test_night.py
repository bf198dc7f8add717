"""The gain in the dark, and the headlight."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.vision import NightCommand
from hub.modules.vision.night import (
    MOST_GAIN,
    SMOOTHING_S,
    WANTED_BRIGHTNESS,
    NightMode,
    next_gain,
)
from tests.support.cases import for_each

BRIGHTNESS = st.floats(0.0, 255.0)


@given(
    gain=st.floats(1.0, MOST_GAIN),
    brightness=BRIGHTNESS,
    seconds=st.one_of(st.floats(-1.0, 1e9), st.just(math.inf)),
)
def test_gain_stays_within_its_limits_and_comes_nearer(
    gain: float, brightness: float, seconds: float
) -> None:
    after = next_gain(gain, brightness, seconds)
    assert 1.0 <= after <= MOST_GAIN
    wanted = min(MOST_GAIN, max(1.0, WANTED_BRIGHTNESS / max(brightness, 1e-9)))
    assert min(gain, wanted) - 1e-9 <= after <= max(gain, wanted) + 1e-9


@given(brightness=BRIGHTNESS, first=st.floats(0.0, 3.0), second=st.floats(0.0, 3.0))
def test_gain_does_not_depend_on_how_often_pictures_are_taken(
    brightness: float, first: float, second: float
) -> None:
    in_two = next_gain(next_gain(2.0, brightness, first), brightness, second)
    assert in_two == pytest.approx(next_gain(2.0, brightness, first + second))


def test_gain_goes_two_thirds_of_its_way_in_its_time() -> None:
    wanted = 8.0
    after = next_gain(1.0, WANTED_BRIGHTNESS / wanted, SMOOTHING_S)
    assert math.log(after) / math.log(wanted) == pytest.approx(1 - math.exp(-1))


def test_pictures_are_as_they_come_until_night_mode_is_on() -> None:
    night = NightMode()
    assert night.see(1.0, 10.0) == 1.0
    assert night.headlight == 0.0
    night.command(NightCommand(on=1))
    assert night.headlight == 1.0
    # The first picture is not kept waiting for its brightness.
    assert night.see(10.0, 10.1) == pytest.approx(9.0)
    night.command(NightCommand(on=0))
    assert (night.see(1.0, 11.0), night.gain, night.headlight) == (1.0, 1.0, 0.0)


def test_bright_pictures_are_never_darkened() -> None:
    night = NightMode()
    night.command(NightCommand(on=1))
    assert night.see(250.0, 1.0) == 1.0


@for_each(("told", "lit"), [(0.3, 0.3), (7.0, 1.0), (-1.0, 0.0), (math.inf, 1.0), (-math.inf, 0.0)])
def test_headlight_is_limited(told: float, lit: float) -> None:
    night = NightMode()
    night.command(NightCommand(on=1, headlight=told))
    assert night.headlight == lit


def test_not_a_number_leaves_the_headlight_as_it_was_chosen() -> None:
    night = NightMode()
    night.command(NightCommand(on=1, headlight=0.25))
    assert night.headlight == 0.25
    night.command(NightCommand(on=0, headlight=0.0))
    assert night.headlight == 0.0
    night.command(NightCommand(on=1, headlight=math.nan))
    assert night.headlight == 0.25


def test_the_headlight_is_switched_with_and_without_night_mode() -> None:
    night = NightMode()
    night.light(0.5)
    assert (night.headlight, night.see(1.0, 0.0)) == (0.5, 1.0), "night mode stays off"
    night.command(NightCommand(on=1))
    assert night.headlight == 0.5, "as bright as the last time"
    night.light(0.0)
    assert night.headlight == 0.0
    assert night.see(1.0, 1.0) > 1.0, "night mode stays on"
    night.command(NightCommand(on=0))
    assert night.headlight == 0.0
