"""Conditions are compared within participants, factors where they are crossed."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from rune_study.data.rows import MetricRow
from rune_study.report.comparison import Conditions, asked_once, compare, corrected

CROSSED = Conditions(
    codes=("A", "B", "C", "D"),
    levels=tuple(
        {"layout": layout, "link": link} for layout in ("x", "y") for link in ("lan", "slow")
    ),
)
PLAIN = Conditions(codes=("A", "B", "C"), levels=({}, {}, {}))
# The oracle data of a repeated-measures analysis: F(2, 10) = 19.705882, epsilon = .798343.
ORACLE = [[10, 8, 8], [12, 9, 8], [11, 10, 9], [11, 10, 8], [10, 8, 9], [11, 9, 7]]


def rows(values: list[list[float]], codes: tuple[str, ...], metric: str = "IE") -> list[MetricRow]:
    return [
        MetricRow(
            participant=person,
            trial=trial,
            code=code,
            metric=metric,
            value=float(value),
            why="lost" if math.isnan(value) else "",
        )
        for person, line in enumerate(values, 1)
        for trial, (code, value) in enumerate(zip(codes, line, strict=True), 1)
    ]


def test_one_factor_is_tested_as_published() -> None:
    (result,) = compare(rows(ORACLE, PLAIN.codes), PLAIN, ["IE"])
    assert result.tests is not None
    effect = result.tests.effect("condition")
    assert effect.f == pytest.approx(19.705882, abs=1e-6)
    assert effect.epsilon == pytest.approx(0.798343, abs=1e-6)
    assert [each.value for each in result.means] == pytest.approx(np.mean(ORACLE, axis=0))
    assert [(each.first, each.second) for each in result.contrasts] == [
        ("A", "B"),
        ("A", "C"),
        ("B", "C"),
    ]
    assert all(each.p_holm >= each.effect.flips.p for each in result.contrasts)


def test_crossed_factors_are_compared_over_the_others() -> None:
    values = [[base, base + 3, base + 1, base + 4.0] for base in (1, 2, 4, 7)]
    (result,) = compare(rows(values, CROSSED.codes), CROSSED, ["IE"])
    assert {each.factor: each.effect.mean.value for each in result.contrasts} == {
        "layout": -1,
        "link": -3,
    }
    assert result.tests is not None
    assert {each.name for each in result.tests.effects} == {"layout", "link", "layout x link"}


def test_conditions_that_are_not_crossed_are_one_factor() -> None:
    uneven = Conditions(
        codes=("A", "B", "C"), levels=({"link": "lan"}, {"link": "slow"}, {"link": "slow"})
    )
    assert list(uneven.factors) == ["condition"]


def test_several_trials_of_a_condition_are_averaged_and_missing_ones_are_reported() -> None:
    values = [[1.0, 5.0, 3.0], [2.0, 6.0, math.nan]]
    first = rows(values, ("A", "B", "A"))
    (result,) = compare(first, Conditions(codes=("A", "B"), levels=({}, {})), ["IE"])
    assert result.values.tolist() == [[2.0, 5.0], [2.0, 6.0]]
    assert result.reasons == {"lost": 1}


def test_means_by_the_place_in_the_session_show_learning() -> None:
    (result,) = compare(rows(ORACLE, PLAIN.codes), PLAIN, ["IE"])
    places = {place: each.value for place, each in result.by_place.items()}
    assert places == {1: pytest.approx(65 / 6), 2: 9.0, 3: pytest.approx(49 / 6)}


def test_a_log_rank_test_of_a_chosen_metric_is_corrected_with_the_others() -> None:
    censored = [
        dataclasses.replace(row, metric="first_victim", censored=int(row.value > 9))
        for row in rows(ORACLE, PLAIN.codes)
    ]
    both = [*rows(ORACLE, PLAIN.codes), *censored]
    results = compare(both, PLAIN, ["IE", "first_victim"])
    assert set(corrected(results, ["IE", "first_victim"])) == {
        "IE: condition",
        "first_victim: condition",
    }
    alone = corrected(results, ["IE"])["IE: condition"]
    assert corrected(results, ["IE", "first_victim"])["IE: condition"] == pytest.approx(2 * alone)


def test_a_metric_without_data_has_neither_means_nor_tests() -> None:
    (result,) = compare([], PLAIN, ["NT"])
    assert result.tests is None
    assert not any(each.known for each in result.means)


def test_tests_of_primary_metrics_are_corrected_together() -> None:
    both = [*rows(ORACLE, PLAIN.codes), *rows(ORACLE, PLAIN.codes, "NT")]
    results = compare(both, PLAIN, ["IE", "NT"])
    one = corrected(results, ["IE"])["IE: condition"]
    assert corrected(results, ["IE", "NT"])["IE: condition"] == pytest.approx(2 * one)
    assert corrected(results, []) == {}


def test_times_that_are_lower_bounds_are_compared_by_their_curves() -> None:
    times = {"A": [(10.0, 0), (20.0, 0), (30.0, 0)], "B": [(60.0, 1), (50.0, 0), (60.0, 1)]}
    found = [
        MetricRow(
            participant=person,
            trial=trial,
            code=code,
            metric="first_victim",
            value=seconds,
            censored=censored,
        )
        for trial, code in enumerate("AB", 1)
        for person, (seconds, censored) in enumerate(times[code], 1)
    ]
    two = Conditions(codes=("A", "B"), levels=({}, {}))
    (result,) = compare(found, two, ["first_victim"])
    assert result.censored is not None
    assert result.censored.tau == 30.0
    assert result.means[0].value == pytest.approx(20.0)
    assert result.means[1].value == pytest.approx(30.0)
    assert result.censored.test is not None
    assert result.censored.test.p < 0.2
    assert result.contrasts == ()


def test_intervals_end_where_a_metric_does() -> None:
    """A share is from 0 to 1, a time from 0 on, a difference of shares from -1 to 1."""
    codes = ("A", "B")
    plain = Conditions(codes=codes, levels=({}, {}))
    values = [[0.0, 1.0], [0.9, 0.1], [0.1, 0.9]]
    (found,) = compare(rows(values, codes, "nt_seen"), plain, ["nt_seen"])
    assert [(each.low, each.high) for each in found.means] == [(0.0, 1.0)] * 2
    assert "cut at 0 and 1" in found.means[0].note
    (effect,) = (each.effect for each in found.contrasts)
    assert (effect.mean.low, effect.mean.high) == (-1.0, 1.0)
    (times,) = compare(rows([[0.1, 9.0], [30.0, 2.0]], codes, "ie_mean"), plain, ["ie_mean"])
    assert times.means[0].low == 0.0
    assert times.means[0].high > 100.0
    once = [
        MetricRow(participant=n, trial=0, code="", metric="sus", value=v)
        for n, v in ((1, 99.0), (2, 80.0))
    ]
    assert asked_once(once)["sus"].high == 100.0
