"""The score of marks beside known victims."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.mapping import InterestPoint, PointKind
from hub.missions.scoring import FARTHEST, Victim, score

VICTIMS = (Victim(name="a", x=0.0, y=0.0), Victim(name="b", x=3.0, y=0.0))
NONE = np.empty(0, np.uint8)


def mark(number: int, x: float, y: float, kind: PointKind = PointKind.VICTIM) -> InterestPoint:
    return InterestPoint(number=number, kind=kind, x=x, y=y, thumbnail=NONE)


def test_near_marks_count_fully_and_farther_ones_less() -> None:
    made = score(VICTIMS, [mark(1, 0.3, 0.4), mark(2, 3.0, 1.25)], 0.5, 1)
    assert [(each.mark, each.error, each.points) for each in made.findings] == [
        (1, 0.5, 30.0),
        (2, 1.25, 25.0),
    ]
    assert made.total == 0.5 * 55.0 / 4.0


def test_a_victim_counts_once_and_a_mark_without_a_victim_costs() -> None:
    marks = [mark(1, 0.1, 0.0), mark(2, 0.0, 0.9), mark(3, 9.0, 9.0)]
    marks += [mark(4, 3.0, 0.0, PointKind.LANDMARK)]
    made = score(VICTIMS, marks, 1.0, 0)
    assert (made.found, made.false, made.repeated) == (1, (3,), (2,))
    assert math.isnan(made.findings[1].error)
    assert made.total == 30.0 - 10.0


def test_two_marks_between_two_victims_find_both() -> None:
    made = score(VICTIMS, [mark(1, 1.4, 0.0), mark(2, 1.3, 0.0)], 1.0, 1)
    assert [each.mark for each in made.findings] == [2, 1]


@given(
    st.lists(st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0)), max_size=6),
    st.integers(0, 5),
)
def test_each_mark_is_one_of_found_repeated_and_false(
    places: list[tuple[float, float]], operators: int
) -> None:
    marks = [mark(number, *place) for number, place in enumerate(places, start=1)]
    made = score(VICTIMS, marks, 1.0, operators)
    found = [each.mark for each in made.findings if each.mark]
    assert sorted([*found, *made.false, *made.repeated]) == [each.number for each in marks]
    assert all(each.error <= FARTHEST for each in made.findings if each.mark)
    assert made.total <= 60.0 / (1 + operators) ** 2
