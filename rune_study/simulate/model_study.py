"""A whole study with models in place of people: the plan, the trials, the metrics."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from hub.values import dataclass
from rune_study.data.rows import MetricRow, TrialRow, metric_rows
from rune_study.errors import StudyError
from rune_study.lots import draw
from rune_study.metrics.registry import measure
from rune_study.plan.measures import measures
from rune_study.plan.steps import TRIAL, plan
from rune_study.plan.study_spec import StudySpec
from rune_study.simulate.model_data import trial_data
from rune_study.simulate.operator_model import OperatorModel, run

_SKILL = 0.25
"""Standard deviation of people's skill, as the logarithm of their interaction time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """What a level of a factor does to models.

    Attributes:
        factor: The factor.
        level: Its level.
        interaction: Factor of the interaction time.
        tolerance: Factor of the neglect tolerance.
    """

    factor: str
    level: str
    interaction: float = 1.0
    tolerance: float = 1.0


def effect_of(text: str) -> Effect:
    """Read an effect: "link=rubble:interaction=1.25,tolerance=0.8".

    Raises:
        StudyError: It has another form.
    """
    where, _, what = text.partition(":")
    factor, given, level = where.partition("=")
    try:
        factors = {
            name: float(value) for name, value in (each.split("=") for each in what.split(","))
        }
        fits = all(0.01 <= each <= 100 for each in factors.values())
        if not given or not fits or not factors.keys() <= {"interaction", "tolerance"}:
            raise ValueError(text)
        return Effect(factor=factor, level=level, **factors)
    except (ValueError, TypeError) as fault:
        reason = f"{text[:60]!r} is no effect; write FACTOR=LEVEL:interaction=1.25,tolerance=0.8"
        raise StudyError(reason) from fault


def simulated(
    study: StudySpec, operators: int, model: OperatorModel, effects: Sequence[Effect] = ()
) -> tuple[list[TrialRow], list[MetricRow]]:
    """Trials and metrics of a study whose participants are models.

    Args:
        study: The study; its plan gives the order of conditions and all seeds.
        operators: Number of participants.
        model: What is true of them, apart from their skill.
        effects: What conditions do to them.

    Raises:
        StudyError: An effect names a factor or level that the study does not have.
    """
    _check(study, effects)
    trials: list[TrialRow] = []
    metrics: list[MetricRow] = []
    for participant in range(1, operators + 1):
        for trial, measured in _session(study, participant, model, effects):
            trials.append(trial)
            metrics += measured
    return trials, metrics


def _session(
    study: StudySpec, participant: int, model: OperatorModel, effects: Sequence[Effect]
) -> Iterator[tuple[TrialRow, list[MetricRow]]]:
    skill = math.exp(_SKILL * _normal(study.seed, participant))
    for step in plan(study, participant):
        if step.kind != TRIAL:
            continue
        levels = study.levels[step.condition]
        acting = [each for each in effects if str(levels.get(each.factor)) == each.level]
        slower = skill * math.prod(each.interaction for each in acting)
        longer = math.prod(each.tolerance for each in acting)
        own = dataclasses.replace(
            model,
            interaction_mean=model.interaction_mean * slower,
            interaction_deviation=model.interaction_deviation * slower,
            tolerance_mean=model.tolerance_mean * longer,
            robots=study.conditions[step.condition].robots,
            seconds=step.seconds,
        )
        found = measure(trial_data(own, run(own, step.seed)), measures(study))
        row: dict[str, Any] = {"participant": participant, "trial": step.trial, "code": step.code}
        yield TrialRow(**row, seconds=step.seconds, ended="time"), metric_rows(row, found)


def _normal(seed: str, participant: int) -> float:
    """A number of the standard normal distribution, by lot."""
    first, second = (draw(seed, "skill", participant, each) for each in (1, 2))
    return math.sqrt(-2.0 * math.log(1.0 - first)) * math.cos(2.0 * math.pi * second)


def _check(study: StudySpec, effects: Sequence[Effect]) -> None:
    known: Mapping[str, set[str]] = {
        name: {str(levels.get(name)) for levels in study.levels}
        for name in {name for levels in study.levels for name in levels}
    }
    for each in effects:
        if each.level not in known.get(each.factor, ()):
            levels = ", ".join(f"{name}={level}" for name in known for level in sorted(known[name]))
            text = f"the study has no {each.factor}={each.level}; it has {levels or 'no factors'}"
            raise StudyError(text)
