"""Pairs of marks and places: the most, and then the nearest."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.missions.matching import assignment, match

PLACES = st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=5)


def test_most_pairs_come_before_near_ones() -> None:
    # The nearest pair is mark 0 with place 0; then mark 1 would have none.
    found = match([(0, 0), (0, 1.3)], [(0, 0.9), (0, -0.9)], 1.0)
    assert [(each.mark, each.place) for each in found] == [(1, 0), (0, 1)]


def test_the_radius_counts_as_near() -> None:
    assert len(match([(0.1, 0.0)], [(1.1, 0.0)], 1.0)) == 1
    assert match([(0.1, 0.0)], [(1.101, 0.0)], 1.0) == ()
    assert match([], [(1.0, 2.0)], 1.0) == match([(1.0, 2.0)], [], 1.0) == ()
    assert match([(math.nan, 0.0), (math.inf, 0.0)], [(0.0, 0.0)], 1.0) == ()


@given(PLACES, PLACES, st.integers(1, 4))
def test_no_other_pairs_are_better(marks, places, radius: int) -> None:
    found = match(marks, places, radius)
    assert len({each.mark for each in found}) == len({each.place for each in found}) == len(found)
    few, many = sorted((marks, places), key=len)
    best = (0, 0.0)
    for order in itertools.permutations(many, len(few)):
        apart = [math.dist(a, b) for a, b in zip(few, order, strict=True)]
        near = [each for each in apart if each <= radius]
        best = min(best, (-len(near), sum(near)))
    assert -len(found) == best[0]
    assert sum(each.distance for each in found) == pytest.approx(best[1])


@given(st.integers(1, 5), st.integers(1, 5), st.integers(0, 99))
def test_an_assignment_is_the_cheapest(rows: int, columns: int, seed: int) -> None:
    costs = np.random.default_rng(seed).integers(-9, 9, (rows, columns)).astype(float)
    pairs = assignment(costs)
    if rows > columns:
        costs, pairs = costs.T, [(column, row) for row, column in pairs]
    wanted = min(
        sum(costs[row, column] for row, column in enumerate(order))
        for order in itertools.permutations(range(costs.shape[1]), len(costs))
    )
    assert sum(costs[pair] for pair in pairs) == wanted
