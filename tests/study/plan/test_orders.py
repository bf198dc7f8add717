"""Orders of conditions: balance, lots, rules."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.errors import StudyError
from rune_study.lots import draw, shuffled, spread
from rune_study.plan.orders import (
    ROWS,
    balance,
    counts_kept,
    drawn,
    latin,
    no_run_above,
    row_of,
    williams,
)
from tests.support.cases import for_each


def test_the_square_of_williams_for_four_is_the_published_one() -> None:
    assert ["".join(map(str, row)) for row in williams(4)] == ["0132", "1203", "2310", "3021"]


@for_each("count", range(2, 14))
def test_each_condition_is_equally_often_at_each_place_and_after_each(count: int) -> None:
    found = balance(williams(count), count)
    assert len({cell for row in found.positions for cell in row}) == 1
    apart = [cell for i, row in enumerate(found.carry_over) for j, cell in enumerate(row) if i != j]
    assert set(apart) == {1 if count % 2 == 0 else 2}
    assert len({cell for row in balance(latin(count), count).positions for cell in row}) == 1


@for_each(("name", "count"), [(name, count) for name in ROWS for count in range(1, 6)])
def test_each_row_has_each_condition_once(name: str, count: int) -> None:
    rows = ROWS[name](count)
    assert all(sorted(row) == list(range(count)) for row in rows)
    assert len(set(rows)) == len(rows)


@given(st.integers(1, 9), st.integers(0, 30), st.text(max_size=20))
def test_each_block_of_participants_has_each_row_once(count: int, block: int, seed: str) -> None:
    rows = williams(count)
    places = range(block * len(rows), (block + 1) * len(rows))
    assert Counter(row_of(rows, place, seed) for place in places) == Counter(rows)


def test_draws_are_the_same_for_ever() -> None:
    """A later version that changed them would change studies that have begun."""
    assert draw("seed", "freeze", 7, 1) == pytest.approx(0.7260825, abs=1e-7)
    assert shuffled("ABCDEF", "seed", "x") == list("DFCEBA")


@given(
    st.integers(1, 20),
    st.floats(0, 600),
    st.floats(0, 60),
    st.floats(0, 600),
    st.text(max_size=9),
)
def test_moments_keep_their_gaps(
    count: int, first: float, apart: float, room: float, seed: str
) -> None:
    last = first + room + (count - 1) * apart
    moments = spread(count, first, last, apart, seed, "freeze", 3)
    assert len(moments) == count
    assert first - 1e-6 <= moments[0]
    assert moments[-1] <= last + 1e-6
    assert all(b - a >= apart - 1e-6 for a, b in pairwise(moments))


@given(st.integers(2, 6), st.integers(1, 4), st.integers(1, 1000))
def test_orders_by_lot_keep_their_rules(count: int, trials: int, participant: int) -> None:
    items = tuple(range(count)) * trials
    rule = no_run_above(2, lambda index: index)
    order = drawn(items, 1, [rule], "seed", participant)
    assert Counter(order) == Counter(items)
    assert all(len(set(order[at : at + 3])) > 1 for at in range(len(order) - 2))
    assert order == drawn(items, 1, [rule], "seed", participant)


def test_blocks_hold_each_condition_once() -> None:
    order = drawn((0, 1, 2), 4, [], "seed", 1)
    assert [sorted(order[at : at + 3]) for at in range(0, 12, 3)] == [[0, 1, 2]] * 4


def test_rules_that_no_order_keeps_are_refused_and_counted() -> None:
    never = no_run_above(1, lambda _: "same")
    with pytest.raises(StudyError, match="none of 10000 orders"):
        drawn((0, 1), 1, [never], "seed")
    assert counts_kept((0, 1), 1, [never], "seed", 100) == (0, [0])
    seldom = no_run_above(1, lambda index: index // 2)
    kept, each = counts_kept((0, 1, 2, 3), 1, [seldom], "seed", 3000)
    assert each == [kept]
    share = kept / 3000
    assert share == pytest.approx(8 / 24, abs=0.04)
