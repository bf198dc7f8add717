"""Costs of ways, against Dijkstra's algorithm one cell at a time."""

from __future__ import annotations

import heapq
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.grids.wavefront import spread, way_back


def dijkstra(factors: np.ndarray, start: tuple[int, int]) -> np.ndarray:
    cost = np.full(factors.shape, np.inf)
    cost[start] = 0.0
    queue = [(0.0, start)]
    while queue:
        spent, (row, column) = heapq.heappop(queue)
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                other = row + down, column + right
                if (down, right) == (0, 0) or not (
                    0 <= other[0] < factors.shape[0] and 0 <= other[1] < factors.shape[1]
                ):
                    continue
                mean = 0.5 * (factors[row, column] + factors[other])
                there = spent + math.hypot(down, right) * mean
                if there < cost[other]:
                    cost[other] = there
                    heapq.heappush(queue, (there, other))
    return cost


@st.composite
def grounds(draw: st.DrawFn) -> np.ndarray:
    shape = draw(st.integers(1, 14)), draw(st.integers(1, 14))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    factors = 1.0 + draw(st.sampled_from([0.0, 0.4, 3.0, 40.0])) * random.random(shape)
    factors[random.random(shape) < draw(st.floats(0.0, 0.6))] = np.inf
    return factors


@given(grounds(), st.data())
def test_costs_are_those_of_the_cheapest_way(factors: np.ndarray, data: st.DataObject) -> None:
    start = (
        data.draw(st.integers(0, factors.shape[0] - 1)),
        data.draw(st.integers(0, factors.shape[1] - 1)),
    )
    factors[start] = 1.0
    costs = spread(factors, start)
    expected = dijkstra(factors, start)
    assert np.array_equal(np.isfinite(costs), np.isfinite(expected))
    finite = np.isfinite(expected)
    assert costs[finite] == pytest.approx(expected[finite])

    reachable = np.argwhere(finite).tolist()
    end = tuple(data.draw(st.sampled_from(reachable)))
    until = spread(factors, start, until=end)
    assert until[end] == pytest.approx(expected[end])
    way = way_back(factors, until, end)
    assert way[0] == start
    assert way[-1] == end
    steps = [math.dist(a, b) * 0.5 * (factors[a] + factors[b]) for a, b in itertools.pairwise(way)]
    assert all(math.dist(a, b) < 1.5 for a, b in itertools.pairwise(way))
    assert sum(steps) == pytest.approx(expected[end])
