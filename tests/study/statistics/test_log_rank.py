"""Log-rank tests."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.errors import DataError
from rune_study.statistics.log_rank import log_rank
from tests.study.statistics.test_survival import MAINTAINED, OTHERS, REMISSION

PLACEBO = [1, 1, 2, 2, 3, 4, 4, 5, 5, 8, 8, 8, 8, 11, 11, 12, 12, 15, 17, 22, 23]
ROWS = st.lists(
    st.tuples(st.integers(0, 9), st.booleans(), st.integers(0, 2), st.integers(0, 1)),
    min_size=2,
    max_size=25,
)


def test_remission_of_leukemia() -> None:
    found = log_rank(REMISSION[0] + PLACEBO, REMISSION[1] + [1] * 21, ["drug"] * 21 + ["no"] * 21)
    assert found.groups == ("drug", "no")
    assert found.observed == (9, 21)
    assert found.expected == pytest.approx((19.2505, 10.7495), abs=1e-4)
    assert (found.square, found.df) == (pytest.approx(16.792940989216547, rel=1e-12), 1)
    assert found.p == pytest.approx(4.168809109334511e-05, rel=1e-11)  # lifelines


def test_acute_leukemia() -> None:
    found = log_rank(MAINTAINED[0] + OTHERS[0], MAINTAINED[1] + OTHERS[1], [0] * 11 + [1] * 12)
    assert found.square == pytest.approx(3.3963886989776024, rel=1e-12)
    assert found.p == pytest.approx(0.0653393220405049, rel=1e-12)


def test_three_groups_by_hand() -> None:
    # At 1 one of 3 has its event, at 2 one of 2: the last one is alone.
    found = log_rank([1, 2, 3], [1, 1, 1], ["a", "b", "c"])
    assert found.expected == pytest.approx((1 / 3, 1 / 3 + 1 / 2, 1 / 3 + 1 / 2 + 1))
    assert found.df == 2


def test_a_group_that_could_have_no_event_does_not_count() -> None:
    found = log_rank([1, 5, 6, 7], [0, 1, 1, 1], ["early", "a", "b", "b"])
    assert found.df == 1
    assert found.p == pytest.approx(log_rank([5, 6, 7], [1, 1, 1], ["a", "b", "b"]).p)


@pytest.mark.parametrize(
    ("durations", "observed", "groups"),
    [
        ([1, 2, 3], [0, 0, 0], [0, 0, 1]),
        ([1, 2, 3], [1, 1, 1], [0, 0, 0]),
        ([1, 2, 5, 5], [0, 0, 1, 1], [0, 0, 1, 1]),
        ([1, 1], [1, 1], [0, 1]),
        ([], [], []),
    ],
)
def test_groups_that_cannot_be_compared(durations, observed, groups) -> None:
    found = log_rank(durations, observed, groups)
    assert found.why
    assert math.isnan(found.square)
    assert math.isnan(found.p)


def test_labels_must_fit() -> None:
    with pytest.raises(DataError, match="label"):
        log_rank([1, 2], [1, 1], [0])
    with pytest.raises(DataError, match="label"):
        log_rank([1, 2], [1, 1], [0, 1], [0])


@given(ROWS)
def test_events_are_shared_out(rows) -> None:
    durations, observed, groups, strata = zip(*rows, strict=True)
    found = log_rank(durations, observed, groups, strata)
    assert sum(found.expected) == pytest.approx(sum(found.observed))
    assert found.why or (found.square >= -1e-12 and 0.0 <= found.p <= 1.0)


@given(ROWS)
def test_one_stratum_is_none(rows) -> None:
    durations, observed, groups, _ = zip(*rows, strict=True)
    one = log_rank(durations, observed, groups, [7] * len(rows))
    plain = log_rank(durations, observed, groups)
    assert (one.why, one.df, one.observed) == (plain.why, plain.df, plain.observed)
    assert one.square == pytest.approx(plain.square, nan_ok=True)


@given(ROWS, st.integers(2, 9))
def test_units_and_names_of_groups_do_not_matter(rows, factor: int) -> None:
    durations, observed, groups, strata = zip(*rows, strict=True)
    found = log_rank(durations, observed, groups, strata)
    other = log_rank([factor * each for each in durations], observed, [-g for g in groups], strata)
    assert found.why == other.why
    assert found.square == pytest.approx(other.square, nan_ok=True, abs=1e-9)
