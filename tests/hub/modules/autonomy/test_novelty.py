"""Exploring ends when nothing new comes although the robot drives, and not before."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.modules.autonomy.exploring import summary
from hub.modules.autonomy.novelty import LEAST_DISTANCE, LEAST_PLACES, Limits, Novelty

LIMITS = Limits(seconds=60.0, share=0.01)
STEP_S = 2.0
FAST = 0.3
"""[m/s]"""


def looked(grounds: list[float], *, speed: float = FAST, places: int = LEAST_PLACES) -> Novelty:
    """A rule that saw so much ground in reach, one every STEP_S, while the robot drove."""
    novelty = Novelty(LIMITS)
    for step, ground in enumerate(grounds):
        novelty.see_map(ground, 1.1 * ground, step * STEP_S * speed, 0.0, step * STEP_S)
        if step in range(1, places + 1):
            novelty.set_out()
    return novelty


@pytest.mark.parametrize(
    ("grounds", "speed", "places", "expected"),
    [
        pytest.param([50.0] * 31, FAST, 2, True, id="nothing at all"),
        pytest.param([50.0] * 30, FAST, 2, False, id="nothing, but not for long enough"),
        pytest.param([50.0 + 0.01 * i for i in range(31)], FAST, 2, True, id="less than 1 %"),
        pytest.param([50.0 + 0.1 * i for i in range(31)], FAST, 2, False, id="more than 1 %"),
        pytest.param([50.0] * 31, 0.0, 2, False, id="the robot stands"),
        pytest.param([50.0] * 31, FAST, 1, False, id="on a long way to the first place"),
        pytest.param([50.0, *[40.0, 50.0] * 15], FAST, 2, True, id="what was lost comes back"),
        pytest.param([50.0] * 20 + [2.0] * 11, FAST, 2, False, id="the map is cleared"),
    ],
)
def test_it_is_over_when_nothing_new_came_for_long_enough_on_a_drive(
    grounds: list[float], speed: float, places: int, *, expected: bool
) -> None:
    novelty = looked(grounds, speed=speed, places=places)
    assert novelty.over((len(grounds) - 1) * STEP_S) is expected


@given(st.lists(st.floats(0.011, 1.0), min_size=1, max_size=40))
def test_it_is_never_over_while_the_ground_grows_by_more_than_the_share(rates: list[float]) -> None:
    novelty, free, now = Novelty(LIMITS), 1.0, 0.0
    for rate in rates:
        free *= 1.0 + rate
        now += LIMITS.seconds - 0.1
        novelty.see_map(free, free, now, 0.0, now)
        novelty.set_out()
        novelty.set_out()
        assert not novelty.over(now)


@given(
    st.floats(0.1, 1e4),
    st.lists(st.floats(0.51, 1.0), min_size=31, max_size=60),
    st.floats(LEAST_DISTANCE / 60.0 + 0.01, 2.0),
)
def test_it_is_over_in_time_when_the_ground_never_exceeds_what_it_was(
    ground: float, shares: list[float], speed: float
) -> None:
    novelty = looked([ground, *(ground * share for share in shares)], speed=speed)
    assert novelty.over(len(shares) * STEP_S)


def test_free_ground_out_of_reach_is_nothing_new() -> None:
    novelty = Novelty(LIMITS)
    for step in range(31):
        new = novelty.see_map(50.0, 60.0 + step, step * STEP_S * FAST, 0.0, step * STEP_S)
        assert new is (step == 0)
        novelty.set_out()
    assert novelty.over(30 * STEP_S)


def test_a_door_that_noise_closes_and_opens_again_is_nothing_new() -> None:
    novelty = Novelty(LIMITS)
    for step, ground in enumerate([50.0, *[10.0, 50.0] * 15]):
        novelty.see_map(ground, 60.0, step * STEP_S * FAST, 0.0, step * STEP_S)
        novelty.set_out()
    assert novelty.over(30 * STEP_S)


def test_counting_begins_with_the_first_look_and_not_before() -> None:
    novelty = Novelty(LIMITS)
    novelty.set_out()
    novelty.set_out()
    assert not novelty.over(1e9)


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ((0, 0, 0), "explored: nothing is left"),
        ((0, 3, 0), "explored: nothing is left; frontiers: 3 out of reach"),
        ((2, 1, 4), "explored: nothing is left; frontiers: 2 left, 1 out of reach, 4 given up"),
    ],
)
def test_the_end_is_told_with_what_remains(counts: tuple[int, int, int], words: str) -> None:
    assert summary("nothing is left", *counts) == words
