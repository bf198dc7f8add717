"""Where a hat points."""

from __future__ import annotations

import pytest

from rune_tui.controls.hid.device_controls import PhysicalControl, hat_direction
from rune_tui.layout.spec import ControlKind
from tests.support.cases import for_each

AROUND = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)]
CENTRE = (0, 0)


def hat(minimum: int, maximum: int) -> PhysicalControl:
    return PhysicalControl(
        kind=ControlKind.HAT,
        index=0,
        usage="hat switch",
        role="dpad",
        minimum=minimum,
        maximum=maximum,
        flipped=False,
    )


@pytest.mark.parametrize("least", [0, 1, -4])
def test_eight_values_go_clockwise_from_up(least: int) -> None:
    control = hat(least, least + 7)
    assert [hat_direction(least + n, control) for n in range(8)] == AROUND


@pytest.mark.parametrize("least", [0, 1])
def test_four_values_are_up_right_down_left(least: int) -> None:
    control = hat(least, least + 3)
    assert [hat_direction(least + n, control) for n in range(4)] == AROUND[::2]


@for_each(("most", "step"), [(315, 45), (359, 45), (360, 45), (31500, 4500)])
def test_degrees_and_their_hundredths_go_clockwise_from_up(most: int, step: int) -> None:
    assert [hat_direction(n * step, hat(0, most)) for n in range(8)] == AROUND
    assert hat_direction(step // 3, hat(0, most)) == (0, 1)
    assert hat_direction(step * 2 // 3, hat(0, most)) == (1, 1)


@for_each("raw", [None, -1, 8, 15])
def test_no_value_and_values_out_of_range_are_the_centre(raw: int | None) -> None:
    assert hat_direction(raw, hat(0, 7)) == CENTRE
    assert hat_direction(raw, hat(0, 7), (0, 2, 4, 6)) == CENTRE


def test_bindings_say_what_is_up() -> None:
    assert hat_direction(4, hat(0, 7), (4, 6, 0, 2)) == (0, 1)
    assert hat_direction(6, hat(0, 7), (4, 6, 0, 2)) == (1, 0)
    assert [hat_direction(n, hat(1, 4), (1, 3, 4, 2)) for n in (1, 3, 4, 2)] == AROUND[::2]


@pytest.mark.parametrize(
    ("bindings", "order"),
    [((0, 2, 4, 6), AROUND), ((0, 6, 4, 2), [AROUND[-n] for n in range(8)])],
)
def test_between_two_bindings_is_both(
    bindings: tuple[int, int, int, int], order: list[tuple[int, int]]
) -> None:
    assert [hat_direction(n, hat(0, 7), bindings) for n in range(8)] == order
