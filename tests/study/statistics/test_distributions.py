"""p-values and quantiles. The numbers are those of mpmath with 50 digits, quantiles of scipy."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.errors import DataError
from rune_study.statistics.distributions import (
    chi_square_tail,
    f_tail,
    normal_quantile,
    normal_tails,
    t_quantile,
    t_tails,
)
from tests.support.cases import for_each

DF = st.floats(0.5, 5000.0)


@for_each(
    ("found", "wanted"),
    [
        (t_tails(2, 7), 0.085619328562976077),
        (t_tails(-0.001, 3), 0.99926489496946094),
        (t_tails(40, 3), 3.4380680789158528e-5),
        (t_tails(12.5, 15), 2.469443017088086e-9),
        (t_tails(2, 2500.5), 0.045608244715953372),
        (f_tail(19.705882, 2, 10), 0.00033950658923564058),
        (f_tail(3.5, 1.596685, 7.983425), 0.087271982544001005),
        (f_tail(0.05698, 35.5, 2000), 0.99999999999999983),
        (f_tail(1.2, 3, 45), 0.3206158135789417),
        (f_tail(300, 4, 60), 6.3722596466225493e-39),
        (chi_square_tail(3.841458820694124, 1), 0.050000000000000057),
        (chi_square_tail(16.79, 1), 4.1752751389197895e-5),
        (chi_square_tail(0.3, 5), 0.99764308626052886),
        (chi_square_tail(250, 80), 2.204425123725404e-19),
        (chi_square_tail(1001.5, 999), 0.47178034640242821),
        (t_quantile(0.975, 7), 2.364624251592784),
        (t_quantile(0.6, 1), 0.32491969623290634),
        (t_quantile(0.005, 15.5), -2.9332790895438547),
        (t_quantile(0.5, 4), 0.0),
        (normal_quantile(0.975), 1.959963984540054),
        (normal_tails(1.959963984540054), 0.05),
    ],
)
def test_numbers_are_those_of_others(found: float, wanted: float) -> None:
    assert found == pytest.approx(wanted, rel=1e-12, abs=0.0)


@for_each(
    ("found", "wanted"),
    [
        (t_tails(math.inf, 3), 0.0),
        (t_tails(1e200, 3), 0.0),
        (t_tails(0.0, 3), 1.0),
        (f_tail(math.inf, 2, 3), 0.0),
        (f_tail(0.0, 2, 3), 1.0),
        (chi_square_tail(math.inf, 2), 0.0),
        (chi_square_tail(0.0, 2), 1.0),
    ],
)
def test_ends(found: float, wanted: float) -> None:
    assert found == wanted


def test_what_is_not_known_stays_unknown() -> None:
    assert all(map(math.isnan, (t_tails(math.nan, 3), f_tail(math.nan, 2, 3))))
    assert math.isnan(chi_square_tail(math.nan, 2))


@for_each("df", [0.0, -1.0, math.inf, math.nan])
def test_degrees_of_freedom_must_be_above_zero(df: float) -> None:
    for tail in (lambda: t_tails(1.0, df), lambda: f_tail(1.0, 2.0, df)):
        with pytest.raises(DataError, match="degrees of freedom"):
            tail()
    with pytest.raises(DataError, match="degrees of freedom"):
        chi_square_tail(1.0, df)


@for_each("share", [0.0, 1.0, math.nan])
def test_quantiles_need_a_share(share: float) -> None:
    with pytest.raises(DataError, match="between 0 and 1"):
        t_quantile(share, 3.0)
    with pytest.raises(DataError, match="between 0 and 1"):
        normal_quantile(share)


@given(st.floats(0.0, 50.0), st.floats(0.0, 5.0), DF, DF)
def test_tails_fall(at: float, more: float, df1: float, df2: float) -> None:
    assert 1.0 >= t_tails(at, df1) >= t_tails(at + more, df1) * (1 - 1e-12) >= 0.0
    assert 1.0 >= f_tail(at, df1, df2) >= f_tail(at + more, df1, df2) * (1 - 1e-12) >= 0.0
    assert 1.0 >= chi_square_tail(at, df1) >= chi_square_tail(at + more, df1) * (1 - 1e-12) >= 0.0


@given(st.floats(0.0, 30.0), DF)
def test_the_square_of_t_is_f(t: float, df: float) -> None:
    assert t_tails(t, df) == pytest.approx(f_tail(t * t, 1.0, df), rel=1e-11)


@given(st.floats(0.01, 20.0), DF, DF)
def test_f_upside_down_is_the_other_tail(f: float, df1: float, df2: float) -> None:
    assert f_tail(f, df1, df2) + f_tail(1.0 / f, df2, df1) == pytest.approx(1.0, abs=1e-11)


@given(st.floats(0.001, 0.999), DF)
def test_quantile_and_tail_agree(share: float, df: float) -> None:
    wanted = 2.0 * min(share, 1.0 - share)
    assert t_tails(t_quantile(share, df), df) == pytest.approx(wanted, rel=1e-10)
