from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.joystick.calibration import (
    TIME_TO_ACT_S,
    Calibration,
    Ends,
    Guide,
    GuidedAxis,
)
from tests.support.cases import for_each

STICK = GuidedAxis(control="lefty", usage="y", lever=False, width=255)
LEVER = GuidedAxis(control="gas", usage="slider", lever=True, width=255)


def pushed(ends: Ends, *peaks: float) -> list[bool]:
    """Move out to each of these shares and back; whether an end was found each time."""
    found = []
    for peak in peaks:
        for share in (0.0, peak / 2, peak, peak / 2):
            ends.look(share)
        found.append(ends.look(0.0))
    return found


def test_an_axis_that_stops_at_the_same_place_four_times_ends_there() -> None:
    ends = Ends()
    assert pushed(ends, 0.80, 0.805, 0.80, 0.80) == [False, False, False, True]
    assert (ends.negative, ends.positive) == (1.0, 0.80)
    pushed(ends, -0.7, -0.7, -0.7, -0.7)
    assert (ends.negative, ends.positive) == (0.7, 0.80)


def test_hands_that_turn_back_anywhere_find_no_end() -> None:
    ends = Ends()
    assert not any(pushed(ends, 0.8, 0.7, 0.9, 0.75, 0.85, 0.65, 0.95))
    assert not any(pushed(ends, 0.3, 0.3, 0.3, 0.3, 0.3))
    assert ends.positive == 1.0


def test_an_end_that_was_passed_moves_out() -> None:
    ends = Ends()
    pushed(ends, 0.8, 0.8, 0.8, 0.8)
    assert pushed(ends, 0.9) == [True]
    assert ends.positive == 0.9


@given(st.lists(st.floats(-1.0, 1.0), max_size=60))
def test_no_end_is_nearer_than_a_real_one_can_be(shares: list[float]) -> None:
    ends = Ends()
    for share in shares:
        ends.look(share)
    assert 0.6 <= ends.negative <= 1.0
    assert 0.6 <= ends.positive <= 1.0


def test_the_guide_asks_for_maximum_minimum_and_rest_of_each_axis() -> None:
    guide = Guide([STICK, LEVER], 0.0)
    asked = []
    for raws in ({"y": 10}, {"y": 250}, {"y": 120}, {"slider": 200}, {"slider": 3}):
        asked.append(guide.prompt)
        assert not guide.ended
        guide.accept(raws, 1.0)
    assert "lefty to its maximum" in asked[0]
    assert "lefty to its minimum" in asked[1]
    assert "let go of lefty" in asked[2]
    assert "gas to its maximum" in asked[3]
    assert guide.ended
    assert guide.prompt == ""
    assert guide.found == {
        "y": Calibration(low=10, high=250, centre=120),
        "slider": Calibration(low=3, high=200),
    }


@for_each(
    ("maximum", "minimum", "rest"), [(200, 190, 195), (200, 10, 210), (200, 10, 10), (5, 5, 5)]
)
def test_the_guide_asks_again_for_what_cannot_be(maximum: int, minimum: int, rest: int) -> None:
    guide = Guide([STICK], 0.0)
    for raw in (maximum, minimum, rest):
        guide.accept({"y": raw}, 1.0)
    assert not guide.ended
    assert "cannot be" in guide.prompt
    for raw in (250, 10, 120):
        guide.accept({"y": raw}, 2.0)
    assert guide.found["y"] == Calibration(low=10, high=250, centre=120)


def test_the_guide_says_that_nothing_has_come_and_waits() -> None:
    guide = Guide([STICK], 0.0)
    guide.accept({"y": None}, 1.0)
    assert "Nothing has come from lefty" in guide.prompt


def test_the_guide_gives_up_after_a_while_without_an_answer() -> None:
    guide = Guide([STICK], 0.0)
    guide.accept({"y": 3}, 50.0)
    guide.expire(50.0 + TIME_TO_ACT_S)
    assert not guide.ended
    guide.expire(50.1 + TIME_TO_ACT_S)
    assert guide.given_up
    assert guide.prompt == ""
