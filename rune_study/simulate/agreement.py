"""What metrics found in recordings beside what a scripted operator did."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from hub.values import dataclass
from rune_study.data.rows import MetricRow
from rune_study.simulate.script import TrueEpisode, mean_length
from rune_study.trial_data.track import Track

EPISODES, EFFORT, TOLERANCE = "episodes", "ie_mean", "nt_median"
ATTENTION, ACTIVE = "rad_mission", "fo_measured"
_WIDTH = 28


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A metric of a trial beside the truth.

    Attributes:
        participant: Number of the participant.
        trial: Number of the trial, from 1.
        metric: Its name.
        truth: What is true; NaN: not known.
        found: What was found; NaN: nothing.
        why: Why nothing was found.
    """

    participant: int
    trial: int
    metric: str
    truth: float
    found: float
    why: str = ""


def findings(
    episodes: Sequence[TrueEpisode],
    metrics: Iterable[MetricRow],
    tolerances: Mapping[tuple[int, int], float],
    lengths: Mapping[tuple[int, int], float],
) -> list[Finding]:
    """Each trial's metrics that a script knows the truth of.

    Args:
        episodes: What the operator did.
        metrics: What was found.
        tolerances: True neglect tolerance [s] by participant and trial.
        lengths: Of trials [s], by the same.
    """
    rows = {(row.participant, row.trial, row.attempt, row.metric): row for row in metrics}
    trials = sorted({key[:3] for key in rows if key[1]})  # 0: asked once per session
    found: list[Finding] = []
    for trial in trials:
        own = [each for each in episodes if (each.participant, each.trial, each.attempt) == trial]
        truths = {
            EPISODES: float(len(own)),
            EFFORT: mean_length(own),
            TOLERANCE: tolerances.get(trial[:2], math.nan),
            ATTENTION: sum(each.end - each.begin for each in own) / lengths[trial[:2]],
            ACTIVE: sum(each.until - each.begin for each in own) / lengths[trial[:2]],
        }
        for metric, truth in truths.items():
            row = rows[(*trial, metric)]
            of = {"participant": trial[0], "trial": trial[1]}
            found.append(Finding(**of, metric=metric, truth=truth, found=row.value, why=row.why))
    return found


def stops_after(track: Track, ends: Sequence[float]) -> list[float]:
    """How long a robot works after the last input of each episode, down to half its speed [s].

    Args:
        track: Its true motion.
        ends: Last input of each episode [s of the trial].

    Returns:
        Those after which it stopped.
    """
    speed = np.abs(track.linear)
    times = []
    for end in ends:
        before = speed[(track.times > end - 1.0) & (track.times <= end)]
        after = track.times >= end
        if before.size:
            slow = track.times[after][speed[after] < 0.5 * np.median(before)]
            times += [float(slow[0]) - end] if slow.size else []
    return times


def middle(times: Sequence[float]) -> float:
    """The median, the lower of two as Kaplan and Meier have it; NaN without times."""
    return float(np.percentile(times, 50.0, method="lower")) if times else math.nan


def agreement_lines(found: Sequence[Finding]) -> list[str]:
    """A table for people: found, true, and the difference."""
    lines = [f"{'participant trial metric':<{_WIDTH}}{'true':>9}{'found':>9}{'error':>9}"]
    for each in found:
        name = f"{each.participant:>11} {each.trial:>5} {each.metric}"
        numbers = (each.truth, each.found, each.found - each.truth)
        cells = "".join(
            f"{'-' if math.isnan(number) else f'{number:.3f}':>9}" for number in numbers
        )
        lines.append(f"{name:<{_WIDTH}}{cells}  {each.why}".rstrip())
    return lines


def counts_agree(found: Sequence[Finding]) -> bool:
    """Whether every trial has as many episodes as there were; False without any trial."""
    counts = [each for each in found if each.metric == EPISODES]
    return bool(counts) and all(each.truth == each.found for each in counts)
