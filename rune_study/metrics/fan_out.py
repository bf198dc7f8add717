"""Robot attention demand, free time and fan-out.

D. R. Olsen and M. A. Goodrich, PerMIS 2003: RAD = IE / (IE + NT), FT = 1 - RAD, FO = 1 / RAD. IE is
interaction effort, NT neglect tolerance, both as times [s].
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.estimate import Estimate, unknown
from rune_study.metrics.effectiveness import Signal, attended
from rune_study.metrics.episodes import Episode


def attention_demand(effort: float, tolerance: float) -> float:
    """RAD. Without any tolerance 1, with infinite tolerance 0, NaN if both are 0 or one is NaN.

    Raises:
        DataError: A time is negative.
    """
    if effort < 0.0 or tolerance < 0.0:
        text = f"times cannot be negative, but effort is {effort:g} and tolerance {tolerance:g}"
        raise DataError(text)
    if math.isnan(effort) or math.isnan(tolerance) or effort == tolerance == math.inf:
        return math.nan
    if tolerance == math.inf:
        return 0.0
    if effort == math.inf:
        return 1.0
    return effort / (effort + tolerance) if effort + tolerance > 0.0 else math.nan


def free_time(effort: float, tolerance: float) -> float:
    """FT = 1 - RAD."""
    return 1.0 - attention_demand(effort, tolerance)


def fan_out(effort: float, tolerance: float) -> float:
    """FO = 1 / RAD; infinite if no attention is needed."""
    demand = attention_demand(effort, tolerance)
    return math.inf if demand == 0.0 else 1.0 / demand


def effort_from_free_time(tolerance: float, share: float) -> float:
    """IE = NT (1 - FT) / FT; infinite without free time."""
    return tolerance * (1.0 - share) / share if share > 0.0 else math.inf


def effort_from_fan_out(tolerance: float, robots: float) -> float:
    """IE = NT / (FO - 1); infinite for a fan-out of 1 or less."""
    return tolerance / (robots - 1.0) if robots > 1.0 else math.inf


def free_time_of_secondary_task(
    correct: float, seconds: float, correct_alone: float, seconds_alone: float
) -> Estimate:
    """FT by a secondary task: correct answers per second with the robot, over those without.

    It may exceed 1, for instance by practice; it is not cut off.

    Args:
        correct: Correct answers beside the robot.
        seconds: Time beside the robot [s].
        correct_alone: Correct answers without a robot.
        seconds_alone: Time without a robot [s].
    """
    if not (0.0 < seconds < math.inf and 0.0 < seconds_alone < math.inf):
        return unknown("the secondary task was not done both with and without the robot")
    if correct_alone <= 0.0:
        return unknown("no answer without the robot was correct")
    value = (correct / seconds) / (correct_alone / seconds_alone)
    note = "above 1: more answers than without the robot" if value > 1.0 else ""
    return Estimate(value=value, n=int(correct), note=note)


def fan_out_estimate(effort: Estimate, tolerance: Estimate) -> Estimate:
    """FO = 1 + NT / IE with an interval.

    The interval is that of the ratio on a logarithmic scale, with the errors of both estimates as
    independent ones (delta method).

    Args:
        effort: Mean IE [s], with an interval.
        tolerance: Restricted mean of NT [s], with an interval; its note names the bound.
    """
    for each in (effort, tolerance):
        if not each.known:
            return each
    value = fan_out(effort.value, tolerance.value)
    if math.isnan(value):
        return unknown("interaction effort and neglect tolerance are both 0")
    low = high = math.nan
    if effort.has_interval and tolerance.has_interval and 1.0 < value < math.inf:
        parts = [
            max(each.high - each.value, each.value - each.low) / each.value
            for each in (effort, tolerance)
        ]
        factor = math.exp(math.hypot(*parts))
        low, high = 1.0 + (value - 1.0) / factor, 1.0 + (value - 1.0) * factor
    return Estimate(value=value, low=low, high=high, n=tolerance.n, note=tolerance.note)


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamRobot:
    """A robot of a team, as fan-out is measured.

    Attributes:
        spans: Episodes of interaction with it.
        rate: Its TE.
        below: TE from which on it works; NaN: not known.
    """

    spans: tuple[Episode, ...]
    rate: Signal
    below: float


def active_robots(robots: Sequence[TeamRobot]) -> float:
    """FO as measured: the mean number of robots that are served or work.

    It reaches the fan-out only with more robots than that: it is the plateau over team sizes
    (D. R. Olsen and S. B. Wood, Fan-out, CHI 2004).

    Args:
        robots: All robots of the trial, with TE at the same evenly spaced times.

    Returns:
        NaN without any sample.
    """
    if not robots or not robots[0].rate.times.size:
        return math.nan
    active = [attended(each.rate, each.spans) | (each.rate.values >= each.below) for each in robots]
    return float(np.sum(active, axis=0).mean())
