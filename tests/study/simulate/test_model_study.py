"""A study of models finds the effect that it was given, and none where there is none."""

from __future__ import annotations

from pathlib import Path

import pytest

from rune_study.data.store import StudyData
from rune_study.errors import StudyError
from rune_study.plan.study_file import read_study
from rune_study.plan.study_spec import StudySpec
from rune_study.report.comparison import compare
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


def test_the_same_study_gives_the_same_data(study: StudySpec) -> None:
    assert repr(simulated(study, 2, MODEL)) == repr(simulated(study, 2, MODEL))


def test_a_page_is_made_of_it(study: StudySpec) -> None:
    trials, metrics = simulated(study, 4, MODEL)
    data = StudyData(trials=tuple(trials), metrics=tuple(metrics))
    page = make_page(study, data, made="by models", source="Models did it.")
    assert "ie_mean [s] (chosen to decide)" in page
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
