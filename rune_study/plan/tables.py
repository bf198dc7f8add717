"""Plans as text, CSV and JSON lines."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Sequence
from typing import Any

from hub.plain_text import plain
from hub.table_text import csv_line
from rune_study.plan.conditions import condition_lines, limit_words
from rune_study.plan.steps import TRIAL, Step, plan
from rune_study.plan.study_spec import StudySpec

_OF_TRIALS = ("freezes", "withheld", "questions", "link_seed")


def as_lines(study: StudySpec, participants: Sequence[int], *, named: bool) -> Iterator[str]:
    """A line for each participant, for people.

    Args:
        study: The study.
        participants: Their numbers.
        named: Whether codes are explained: no in a blind study.
    """
    if named:
        yield from map(plain, condition_lines(study))
    for participant in participants:
        trials = [step for step in plan(study, participant) if step.kind == TRIAL]
        yield f"{participant:3}  {' '.join(step.code for step in trials)}"


def as_csv(study: StudySpec, participants: Sequence[int], *, named: bool) -> Iterator[str]:
    """A heading, and a line for each trial."""
    factors = list(study.levels[0]) if named else []
    columns = ["participant", "trial", "condition", *factors]
    yield csv_line([*columns, "seconds", "freezes", "seed", "link_seed"], "")
    for participant in participants:
        for step in plan(study, participant):
            if step.kind == TRIAL:
                levels = [study.levels[step.condition].get(name, "") for name in factors]
                freezes = " ".join(f"{moment:g}" for moment in step.freezes)
                own = [f"{step.seconds:g}", freezes, step.seed, step.link_seed]
                yield csv_line([participant, step.trial, step.code, *levels, *own], "")


def json_lines(study: StudySpec, participants: Sequence[int], *, named: bool) -> Iterator[str]:
    """A line for each step."""
    for participant in participants:
        for step in plan(study, participant):
            yield json.dumps({"participant": participant, **as_data(study, step, named=named)})


def as_data(study: StudySpec, step: Step, *, named: bool) -> dict[str, Any]:
    """A step as what JSON has; without index and levels of its condition unless `named`."""
    data = dataclasses.asdict(step)
    if step.condition < 0 or not named:
        del data["condition"]
    else:
        given = study.levels[step.condition]
        data["levels"] = {**limit_words(study.conditions[step.condition]), **given}
    if step.kind != TRIAL:
        data = {name: value for name, value in data.items() if name not in _OF_TRIALS}
    return data
