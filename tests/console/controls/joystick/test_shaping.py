from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.joystick.shaping import LARGEST_REST, AxisRange, Shape

SHARES = st.floats(-1.0, 1.0)
SHAPES = st.builds(
    Shape,
    inverted=st.booleans(),
    dead_zone=st.floats(0.0, 0.9),
    expo=st.floats(0.0, 1.0),
    saturation=st.floats(0.0, 0.05),
)
RAWS = st.integers(-(1 << 31), 1 << 31)


@given(raw=RAWS, low=RAWS, width=st.integers(0, 1 << 31), seen=RAWS)
def test_no_raw_number_is_moved_by_more_than_all(raw: int, low: int, width: int, seen: int) -> None:
    for wide in (AxisRange.centred, AxisRange.lever):
        assert -1.0 <= wide(low, low + width).resting_at(seen).share(raw) <= 1.0


@given(shape=SHAPES, x=SHARES, y=SHARES)
def test_a_shaped_value_stays_within_its_bounds_and_on_its_side(
    shape: Shape, x: float, y: float
) -> None:
    values = (shape.shaped(x), *shape.shaped_pair(x, y))
    assert all(-1.0 <= value <= 1.0 for value in values)
    assert all(value * given >= 0.0 for value, given in zip(values, (x, x, y), strict=True))


@given(shape=SHAPES, x=SHARES, y=SHARES, share=SHARES)
def test_within_the_dead_zone_all_is_neutral(
    shape: Shape, x: float, y: float, share: float
) -> None:
    assert shape.shaped(share * shape.dead_zone) == 0.0
    far = max(1.0, (x * x + y * y) ** 0.5) * 1.000001
    inner = shape.shaped_pair(x / far * shape.dead_zone, y / far * shape.dead_zone)
    assert inner == (0.0, 0.0)


@given(shape=SHAPES, less=SHARES, more=SHARES)
def test_more_movement_never_gives_less(shape: Shape, less: float, more: float) -> None:
    less, more = sorted((less, more))
    assert shape.shaped(less) <= shape.shaped(more) + 1e-12


@given(shape=SHAPES)
def test_each_end_is_reached_and_a_corner_moves_both(shape: Shape) -> None:
    assert shape.shaped(1.0) == pytest.approx(1.0)
    assert shape.shaped(-1.0) == pytest.approx(-1.0)
    assert shape.shaped_pair(1.0, 0.0) == pytest.approx((1.0, 0.0))


def test_the_way_between_dead_zone_and_end_is_all_used() -> None:
    straight = Shape(dead_zone=0.1, expo=0.0, saturation=0.1)
    assert straight.shaped(0.5) == pytest.approx(0.5)
    assert straight.shaped(0.101) == pytest.approx(0.00125)
    assert Shape(dead_zone=0.0, saturation=0.0, expo=1.0).shaped(0.5) == pytest.approx(0.125)


def test_each_side_of_a_stick_that_rests_off_its_middle_has_its_own_length() -> None:
    wide = AxisRange(low=0, rest_low=100, rest_high=100, high=255)
    assert wide.share(50) == pytest.approx(-0.5)
    assert wide.share(177.5) == pytest.approx(0.5)


@given(raw=st.integers(0, 1000))
def test_what_is_taken_for_the_rest_and_the_middle_are_neutral(raw: int) -> None:
    wide = AxisRange.centred(0, 1000)
    resting = wide.resting_at(raw)
    assert resting.share(500) == 0.0
    assert (resting.share(raw) == 0.0) == (abs(wide.share(raw)) <= LARGEST_REST)


@pytest.mark.parametrize(("down", "raw", "share"), [(False, 0, 0), (False, 64, 1), (True, 0, -1)])
def test_a_lever_rests_at_one_end(*, down: bool, raw: int, share: float) -> None:
    assert AxisRange.lever(0, 64, down=down).share(raw) == share
