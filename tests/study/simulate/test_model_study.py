"""A study of models finds the effect that it was given, and none where there is none."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import pytest

from rune_study.data.rows import MetricRow
from rune_study.data.store import StudyData
from rune_study.errors import StudyError
from rune_study.plan.study_file import read_study
from rune_study.plan.study_spec import StudySpec
from rune_study.report.comparison import Conditions, compare
from rune_study.report.making import conditions_of, make_page
from rune_study.simulate.model_study import Effect, effect_of, simulated
from rune_study.simulate.operator_model import OperatorModel

STUDY = """
title = "Links"
seed = "links"
participants = 12

[defaults]
layout = "search"

[factors]
link = ["lan", "rubble"]
assistance = ["on", "off"]

[trial]
seconds = 600

[metrics]
primary = ["ie_mean"]
"""
MODEL = OperatorModel(check_s=40.0)


@pytest.fixture
def study(tmp_path: Path) -> StudySpec:
    (tmp_path / "study.toml").write_text(STUDY)
    return read_study(tmp_path)


def test_a_true_effect_is_found_and_the_other_factor_is_left_alone(study: StudySpec) -> None:
    effect = Effect(factor="link", level="rubble", interaction=1.4)
    trials, metrics = simulated(study, 12, MODEL, [effect])
    assert len(trials) == 48
    (result,) = compare(metrics, conditions_of(study, unblind=True), ["ie_mean"])
    by_factor = {each.factor: each.effect for each in result.contrasts}
    assert by_factor["link"].flips.p < 0.01
    assert abs(by_factor["link"].mean.value) == pytest.approx(0.4 * 6.0, rel=0.35)
    assert abs(by_factor["assistance"].mean.value) < 0.25 * abs(by_factor["link"].mean.value)


@pytest.mark.soak
def test_many_studies_find_a_true_effect_and_no_other(tmp_path: Path) -> None:
    """60 studies of 16 people each: without an effect, with learning, and with a slow link."""
    slow = Effect(factor="link", level="rubble", interaction=1.25)
    chance: list[bool] = []
    learnt: list[bool] = []
    found: list[bool] = []
    ratios: list[float] = []
    for number in range(60):
        text = STUDY.replace('seed = "links"', f'seed = "links {number}"').replace("= 12", "= 16")
        (tmp_path / "study.toml").write_text(text)
        study = read_study(tmp_path)
        named = conditions_of(study, unblind=True)
        _, plain = simulated(study, 16, MODEL)
        chance += low_p(plain, named).values()
        learning = [dataclasses.replace(row, value=row.value * 0.92**row.trial) for row in plain]
        learnt += low_p(learning, named).values()
        _, slowed = simulated(study, 16, MODEL, [slow])
        found.append(low_p(slowed, named)["link"])
        (result,) = compare(slowed, named, ["ie_mean"])
        of_link: dict[str, list[float]] = {}
        for levels, mean in zip(named.levels, result.means, strict=True):
            of_link.setdefault(str(levels["link"]), []).append(mean.value)
        ratios.append(sum(of_link["rubble"]) / sum(of_link["lan"]))
    # One in twenty by chance; more than 13 of 120 would be rarer than one in two hundred.
    assert sum(chance) <= 13
    assert sum(learnt) <= 13
    assert sum(found) >= 57
    assert sum(ratios) / 60 == pytest.approx(1.25, abs=0.02)


def low_p(metrics: Sequence[MetricRow], conditions: Conditions) -> dict[str, bool]:
    """Whether sign flips of each factor are below 5 %."""
    (result,) = compare(metrics, conditions, ["ie_mean"])
    return {each.factor: each.effect.flips.p < 0.05 for each in result.contrasts}


def test_the_same_study_gives_the_same_data(study: StudySpec) -> None:
    assert repr(simulated(study, 2, MODEL)) == repr(simulated(study, 2, MODEL))


def test_a_page_is_made_of_it(study: StudySpec) -> None:
    trials, metrics = simulated(study, 4, MODEL)
    data = StudyData(trials=tuple(trials), metrics=tuple(metrics))
    page = make_page(study, data, made="by models", source="Models did it.")
    assert "ie mean [s] (chosen to decide)" in page
    assert "Models did it." in page


def test_effects_are_read_or_refused_in_a_sentence(study: StudySpec) -> None:
    assert effect_of("link=rubble:interaction=1.25,tolerance=0.8") == Effect(
        factor="link", level="rubble", interaction=1.25, tolerance=0.8
    )
    for wrong in ("link", "link=rubble", "link=rubble:speed=2", "link=rubble:interaction=x"):
        with pytest.raises(StudyError, match="is no effect; write FACTOR=LEVEL"):
            effect_of(wrong)
    with pytest.raises(StudyError, match="has no link=moon; it has"):
        simulated(study, 2, MODEL, [Effect(factor="link", level="moon")])
