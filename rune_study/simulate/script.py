"""What a scripted operator does in real time: episodes and pauses of known length; pure.

The operator holds keys during an episode and leaves the robot alone during a pause. Each pause is
longer than the one that ends an episode, so that the number of episodes is known. Several robots
get their episodes one after the other, in turn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from hub import files
from hub.table_text import csv_line
from hub.values import dataclass
from rune_study.errors import StudyError
from rune_study.plan.steps import Step
from rune_study.plan.study_spec import StudySpec
from rune_study.simulate.operator_model import OperatorModel

IN_REAL_TIME: Final = OperatorModel(
    interaction_mean=3.0, interaction_deviation=1.0, tolerance_mean=2.0
)
"""A model whose episodes and pauses are short, because they take real time."""
_SHORTEST_S: Final = 1.0
_APART_S: Final = 1.5
"""Pauses are longer by this than the one that ends an episode [s]."""
_CHANGE_S: Final = 0.5
"""Time from an episode with one robot to that with the next [s]."""
_LAST_S: Final = 1.0
"""No episode lasts into the last part of a trial [s]."""
_MOST_ENDS: Final = {"time", "operator", "experimenter"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Service:
    """An episode that a script plans [s of the trial].

    Attributes:
        robot: The robot, from 0.
        begin: First input.
        end: Last input.
        until: If the robot can work alone, it does so until then.
    """

    robot: int
    begin: float
    end: float
    until: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TrueEpisode:
    """An episode as the operator knows it.

    Attributes:
        participant: Number of the participant.
        trial: Number of the trial, from 1.
        attempt: Which attempt at it, from 1.
        robot: Number of the robot, from 1.
        begin: First input, from the trial's begin [s].
        end: Last input [s].
        until: When the robot's work ends [s].
    """

    participant: int
    trial: int
    attempt: int
    robot: int
    begin: float
    end: float
    until: float


def script(model: OperatorModel, step: Step, gap: float, robots: int = 1) -> tuple[Service, ...]:
    """The episodes of a trial, in their order; the trial's seed gives the same again.

    Args:
        model: Draws the lengths of episodes and pauses.
        step: The trial.
        gap: Pause between inputs that ends an episode [s].
        robots: Number of robots.
    """
    random = np.random.default_rng(step.seed)
    found: list[Service] = []
    pause = gap + _APART_S
    free, ready = pause, [pause] * robots
    while True:
        robot = len(found) % robots
        begin = max(free, ready[robot])
        end = begin + max(_SHORTEST_S, model.interaction(random))
        if end > step.seconds - _LAST_S:
            return tuple(found)
        until = end + model.tolerance(random)
        found.append(Service(robot=robot, begin=begin, end=end, until=until))
        free, ready[robot] = end + _CHANGE_S, until + pause


def true_episode(of: Mapping[str, Any], done: Service) -> TrueEpisode:
    """An episode of a trial, given its participant, trial and attempt."""
    spans: dict[str, Any] = {"begin": done.begin, "end": done.end, "until": done.until}
    return TrueEpisode(**of, robot=done.robot + 1, **spans)


def check_playable(study: StudySpec, most_robots: int) -> None:
    """Refuse a study that a script cannot play.

    Args:
        study: The study.
        most_robots: How many robots of a condition it can serve.

    Raises:
        StudyError: It has what a script does not know the truth of; the error lists all of it.
    """
    unknown = {
        "[freeze]": study.freeze is not None,
        "[withhold]": study.withhold is not None,
        'begins = "experimenter"': study.trial.begins == "experimenter",
        "ends other than time and operator": not set(study.trial.ends) <= _MOST_ENDS,
        f"more than {most_robots} robots": any(
            each.robots > most_robots for each in study.conditions
        ),
    }
    found = [name for name, there in unknown.items() if there]
    if found:
        text = f"a script cannot play {', '.join(found)}; simulate a copy of the study without"
        raise StudyError(text)


def write_truth(path: Path, episodes: list[TrueEpisode]) -> None:
    """Write what the operator did, an episode a line.

    Raises:
        StudyError: The file cannot be written.
    """
    names = list(TrueEpisode.__dataclass_fields__)
    try:
        lines = [names, *([getattr(each, name) for name in names] for each in episodes)]
        files.replace(path, "".join(csv_line(each, "\n") for each in lines).encode())
    except OSError as fault:
        text = f"{path} cannot be written: {fault.strerror or fault}"
        raise StudyError(text) from fault


def mean_length(episodes: list[TrueEpisode]) -> float:
    """Mean length of episodes [s]; NaN without any."""
    lengths = [each.end - each.begin for each in episodes]
    return sum(lengths) / len(lengths) if lengths else math.nan
