"""Metrics find what is true of a model, where that can be known at all."""

from __future__ import annotations

import math

import pytest

from rune_study.simulate.operator_model import OperatorModel
from tests.support.recovery import measured, recovery
from tests.system.harness import in_soak

IDENTIFIABLE = {
    "after each stand": OperatorModel(),
    "looks in by chance": OperatorModel(check_s=60.0),
    "three robots": OperatorModel(robots=3),
}


@pytest.mark.parametrize("trials", [60, *in_soak(200)])
@pytest.mark.parametrize("name", IDENTIFIABLE)
def test_the_truth_lies_in_the_stated_interval(name: str, trials: int) -> None:
    found = {each.metric: each for each in recovery(IDENTIFIABLE[name], range(trials))}
    tolerance, effort = found["nt_median"], found["ie_mean"]
    assert tolerance.intervals == trials
    # Chance alone gives fewer than this once in a thousand series, if the level is kept.
    least = 0.95 - 3.1 * math.sqrt(0.95 * 0.05 / trials)
    assert tolerance.coverage >= least
    assert effort.coverage >= least
    assert tolerance.mean == pytest.approx(tolerance.truth, rel=0.06)
    assert effort.mean == pytest.approx(effort.truth, rel=0.04)


@pytest.mark.parametrize("trials", [60, *in_soak(200)])
@pytest.mark.parametrize("check_s", [25.0, 10.0])
def test_the_interval_of_effort_holds_where_early_returns_merge_episodes(
    check_s: float, trials: int
) -> None:
    found = recovery(OperatorModel(check_s=check_s), range(trials))
    (effort,) = (each for each in found if each.metric == "ie_mean")
    assert effort.mean > effort.truth * 1.03
    assert effort.coverage >= 0.93


def test_an_operator_who_returns_at_each_stand_leaves_nothing_to_know() -> None:
    for each in measured(OperatorModel(notice_s=0.0), range(5)):
        assert not each["nt_median"].known
        assert "identif" in each["nt_median"].why


def test_probes_mend_what_foresight_breaks() -> None:
    foresees, probed = (
        {each.metric: each for each in recovery(model, range(60))}["nt_median"]
        for model in (
            OperatorModel(foresight=0.5),
            OperatorModel(foresight=0.5, probe_share=0.5),
        )
    )
    assert foresees.coverage < 0.8 < probed.coverage
    assert foresees.mean > probed.mean > probed.truth
