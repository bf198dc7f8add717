"""Analysis of variance within participants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from rune_study.errors import DataError
from rune_study.statistics.paired import paired_effect
from rune_study.statistics.repeated_measures import rm_anova

ROWS = [[10, 8, 8], [12, 9, 8], [11, 10, 9], [11, 10, 8], [10, 8, 9], [11, 9, 7]]
TABLES = arrays.arrays(
    float,
    st.tuples(st.integers(2, 8), st.integers(2, 4)),
    elements=st.integers(-50, 50).map(float),
)


def test_worked_by_hand() -> None:
    found = rm_anova(ROWS)
    (effect,) = found.effects
    assert (effect.df1, effect.df2, found.n, found.left_out) == (2, 10, 6, ())
    assert effect.f == pytest.approx(19.7058823529, rel=1e-10)
    assert effect.epsilon == pytest.approx(0.7983425414, rel=1e-9)
    assert effect.p == pytest.approx(3.39506565e-4, rel=1e-8)
    # Squares by hand: mean 28/3; conditions 65/6, 9, 49/6; participants 26/3 to 10.
    assert effect.square_effect == pytest.approx(22 + 1 / 3)
    assert effect.square_error == pytest.approx(5 + 2 / 3)
    assert found.square_participants == pytest.approx(4.0)
    assert effect.eta_partial == pytest.approx(67 / 84)
    assert effect.eta_generalized == pytest.approx(67 / 96)


def test_corrected_p_is_that_of_pingouin() -> None:
    rows = [[45, 50, 55], [42, 42, 45], [36, 41, 43], [39, 35, 40], [51, 55, 59], [44, 49, 56]]
    (effect,) = rm_anova(rows).effects
    assert effect.f == pytest.approx(12.533980582524265, rel=1e-10)
    assert effect.epsilon == pytest.approx(0.6383795545243166, rel=1e-10)
    assert effect.p == pytest.approx(0.0018855906470255418, rel=1e-10)
    assert effect.p_corrected == pytest.approx(0.0089852152847808, rel=1e-10)
    assert effect.eta_generalized == pytest.approx(0.16700084082530217, rel=1e-10)


def test_two_factors_are_those_of_pingouin() -> None:
    values = np.array(ROWS + ROWS[::-1], float).reshape(6, 2, 3)
    values[:, 1] += np.arange(6)[:, None] % 3
    values[0, 1, 2] += 3
    values[3, 0, 1] -= 2
    found = rm_anova(values, ("layout", "link"))
    assert [each.name for each in found.effects] == ["layout", "link", "layout x link"]
    wanted_of = {
        "layout": (26.18811881188162, 1.0, 0.003715153132472787, 0.33502216592780293),
        "link": (30.294117647058954, 0.6704384054540288, 0.0007158774842583847, 0.5786516853932588),
        "layout x link": (
            0.25547445255474194,
            0.6729652205091429,
            0.6974955458383041,
            0.013157894736842016,
        ),
    }
    for name, wanted in wanted_of.items():
        each = found.effect(name)
        assert (each.f, each.epsilon, each.p_corrected, each.eta_generalized) == pytest.approx(
            wanted, rel=1e-10
        )


def test_incomplete_participants_are_left_out() -> None:
    rows = [*ROWS, [1, math.nan, 2]]
    found = rm_anova(rows)
    assert (found.n, found.left_out) == (6, (6,))
    assert found.effects == rm_anova(ROWS).effects


def test_two_conditions_are_a_paired_test() -> None:
    a, b = [62, 55, 71, 48, 66, 59, 73, 51], [55, 50, 60, 49, 58, 50, 66, 47]
    (effect,) = rm_anova(np.column_stack((a, b))).effects
    pair = paired_effect(a, b)
    assert effect.f == pytest.approx(pair.t**2)
    assert effect.p == pytest.approx(pair.p)
    assert effect.p_corrected == pytest.approx(effect.p)
    assert effect.epsilon == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        ([[1, 2, 3]], "two complete participants"),
        ([[1, math.nan], [math.nan, 2]], "two complete participants"),
        ([[4, 4, 4], [4, 4, 4]], "no value differs"),
        ([[0.1, 0.1, 0.1], [0.7, 0.7, 0.7], [0.3, 0.3, 0.3]], "no value differs"),
        (np.empty((0, 3)), "two complete participants"),
    ],
)
def test_no_result_has_a_reason(rows, why: str) -> None:
    (effect,) = rm_anova(rows).effects
    assert why in effect.why
    assert math.isnan(effect.f)
    assert math.isnan(effect.p)
    assert math.isnan(effect.p_corrected)


def test_no_effect_at_all() -> None:
    (effect,) = rm_anova([[1, 2, 3], [3, 1, 2], [2, 3, 1]]).effects
    assert (effect.f, effect.p, effect.eta_generalized) == (0.0, 1.0, 0.0)
    assert rm_anova([[1, 2, 3], [3, 1, 2], [2, 3, 1]]).square_participants == pytest.approx(0.0)


def test_an_effect_without_any_error_is_infinite() -> None:
    (effect,) = rm_anova([[1, 2, 3], [2, 3, 4], [7, 8, 9]]).effects
    assert (effect.f, effect.p, effect.p_corrected) == (math.inf, 0.0, 0.0)


@pytest.mark.parametrize(
    ("values", "factors", "what"),
    [
        ([1, 2, 3], ("a",), "axes"),
        ([[1], [2]], ("a",), "two levels"),
        ([[1, math.inf], [1, 2]], ("a",), "infinite"),
        ([[[1, 2]]], ("a",), "axes"),
    ],
)
def test_what_cannot_be_analysed(values, factors, what: str) -> None:
    with pytest.raises(DataError, match=what):
        rm_anova(values, factors)
    with pytest.raises(DataError, match="there is no effect"):
        rm_anova(ROWS).effect("link")


@given(TABLES, st.integers(1, 9), st.integers(-1000, 1000))
def test_scale_and_offset_of_a_participant_do_not_matter(values, factor: int, more: int) -> None:
    (first,) = rm_anova(values).effects
    shifted = factor * values + more * np.arange(len(values))[:, None]
    (second,) = rm_anova(shifted[::-1, ::-1]).effects
    if first.why or second.why or math.isinf(first.f):
        return
    assert first.f == pytest.approx(second.f, rel=1e-6, abs=1e-8)
    assert first.epsilon == pytest.approx(second.epsilon, rel=1e-6)


@given(TABLES)
def test_bounds(values) -> None:
    (effect,) = rm_anova(values).effects
    if effect.why or math.isinf(effect.f):
        return
    assert 1.0 / effect.df1 - 1e-12 <= effect.epsilon <= 1.0 + 1e-12
    assert 0.0 <= effect.eta_generalized <= effect.eta_partial + 1e-12 <= 1.0 + 1e-12
    total = float(((values - values.mean()) ** 2).sum())
    parts = effect.square_effect + effect.square_error + rm_anova(values).square_participants
    assert parts == pytest.approx(total)
