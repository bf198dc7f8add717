"""The table of all metrics of a trial: name, unit, meaning, which way is better, and the function.

The data dictionary of a study and docs/study-metrics.md come from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from types import MappingProxyType

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.estimate import Estimate, unknown, within
from rune_study.metrics import trial_metrics as of
from rune_study.metrics.analysis import TrialAnalysis
from rune_study.metrics.trial import MeasureSpec, Questionnaires, TrialData


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """A number of a trial.

    Attributes:
        name: Its column in `metrics.csv`.
        unit: Of the number; empty: it has none.
        words: What it is, with its edge cases.
        better: "higher", "lower", or empty if neither is.
        function: Computes it.
        least: Smallest number that it can be; intervals end there.
        most: Largest one; the same.
    """

    name: str
    unit: str
    words: str
    better: str
    function: Callable[[TrialAnalysis], Estimate]
    least: float
    most: float

    def bounded(self, estimate: Estimate) -> Estimate:
        """A mean of values of it, with an interval that ends where the metric does."""
        return within(estimate, self.least, self.most)

    def bounded_difference(self, estimate: Estimate) -> Estimate:
        """The same of a difference of two such means."""
        return within(estimate, self.least - self.most, self.most - self.least)


def _row(
    name: str,
    unit: str,
    better: str,
    function: Callable[[TrialAnalysis], Estimate],
    words: str,
    *,
    least: float = 0.0,
    most: float | None = None,
) -> Metric:
    return Metric(
        name=name,
        unit=unit,
        words=words,
        better=better,
        function=function,
        least=least,
        most=most if most is not None else 1.0 if unit == "share" else math.inf,
    )


_ROWS = (
    _row("te_mean", "progress/s", "higher", of.mean_effectiveness,
         "Task effectiveness: progress of all robots over the trial, per second. The study "
         "chooses what progress is: m of path to the goal, m^2 seen, or m driven.",
         least=-math.inf),
    _row("completion", "share", "higher", of.completion,
         "Share of robots that reached their goal."),
    _row("episodes", "", "", of.episode_count,
         "Episodes of interaction: inputs of one robot, split at pauses longer than 2 s; "
         "while a key is held there is none. A key that is down when the trial begins counts."),
    _row("ie_mean", "s", "lower", lambda it: it.effort,
         "Interaction effort IE: mean length of an episode. It begins when the robot is "
         "chosen, at most 2 s before the first input, and lasts at least 0.5 s. If the robot is "
         "chosen again within an episode, the interval also holds the mean of both parts apart."),
    _row("ie_inputs", "inputs", "lower", of.inputs_per_episode, "Inputs per episode."),
    _row("rad_mission", "share", "lower", of.mission_demand,
         "Attention demand of the mission: union of all episodes over the trial."),
    _row("nt_seen", "share", "", lambda it: it.seen,
         "Share of neglects that ended with a drop of TE that was seen; the others are "
         "censored."),
    _row("nt_median", "s", "higher", lambda it: it.tolerance_median,
         "Neglect tolerance NT: time from an episode to the drop of TE below half of its "
         "median while attended. Median of the Kaplan-Meier curve, with log-log limits. Not "
         "identifiable if less than a third of the neglects end so."),
    _row("nt_restricted_mean", "s", "higher", lambda it: it.tolerance,
         "The same: mean up to a bound that its note names."),
    _row("rad", "share", "lower", lambda it: it.demand,
         "Robot attention demand RAD = IE / (IE + NT), with the restricted mean of NT. 1 "
         "without NT."),
    _row("ft", "share", "higher", of.free_time,
         "Free time FT = 1 - RAD."),
    _row("fo", "robots", "higher", lambda it: it.fan_out,
         "Fan-out FO = 1 / RAD, with the restricted mean of NT. Infinite if no attention is "
         "needed.", least=1.0),
    _row("fo_measured", "robots", "higher", lambda it: it.active,
         "Fan-out as measured: mean number of robots that are served or work. It reaches FO "
         "only with more robots than that."),
    _row("ft_secondary", "share", "higher", of.secondary_free_time,
         "Free time by the secondary task: correct answers per second, over those without a "
         "robot in the steps `secondary` of the session. May exceed 1.", most=math.inf),
    _row("secondary_right", "share", "higher", of.secondary_right,
         "Correct answers to the secondary task beside the robot, of all its questions. Those "
         "that a freeze, a pause or the end of the trial took away do not count."),
    _row("secondary_missed", "questions", "lower", of.secondary_missed,
         "Questions of the secondary task without an answer in time."),
    _row("secondary_time", "s", "lower", of.secondary_time,
         "Time from a question of the secondary task to its correct answer. Median."),
    _row("first_victim", "s", "lower", of.first_victim,
         "Time to the first mark within 1 m of a victim; censored at the end of the trial. "
         "Removed marks do not count."),
    _row("victims_found", "victims", "higher", of.found_victims,
         "Victims with a mark: most pairs within 1 m, then least distance."),
    _row("victims_fraction", "share", "higher", of.found_fraction, "Share of the victims found."),
    _row("victims_false", "marks", "lower", of.false_marks, "Marks without a victim."),
    _row("victims_precision", "share", "higher", of.mark_precision,
         "Share of the marks with a victim; unknown without marks."),
    _row("victims_error", "m", "lower", of.mark_error, "Mean distance of these marks."),
    _row("coverage", "share", "higher", of.ground_covered,
         "Share of the reachable cells that were seen or mapped, at most 3 m away."),
    _row("map_f1", "share", "higher", of.map_f1,
         "Harmonic mean of precision and recall of the map's occupied cells, within 10 cm of "
         "the true surface. 0 if nothing is marked."),
    _row("map_precision", "share", "higher", of.map_precision,
         "Share of the map's occupied cells at a true surface; unknown if none is."),
    _row("map_recall", "share", "higher", of.map_recall,
         "Share of the true surface that the map has."),
    _row("bumps", "", "lower", of.all_bumps,
         "Bumps into obstacles. Contacts within 1 s of a bump belong to it."),
    _row("bumps_front", "", "lower", of.front_bumps,
         "Bumps with a mean direction of the bumpers up to 67.5 deg from straight ahead."),
    _row("bumps_rear", "", "lower", of.rear_bumps, "Bumps from 112.5 deg on."),
    _row("bumps_side", "", "lower", of.side_bumps, "Bumps between the two."),
    _row("driven", "m", "", of.driven, "Path that was driven; steps below 5 cm count in sum."),
    _row("path_ratio", "", "lower", of.path_ratio,
         "Driven path over the shortest one on the true ground, in any direction; unknown "
         "unless the robot arrived."),
    _row("spl", "share", "higher", of.success_by_path_length,
         "Success by path length: shortest path over the longer of both; 0 unless the robot "
         "arrived."),
    _row("reversals_visual", "1/min", "lower", of.visual_reversals,
         "Reversals of a wheel by more than 3 deg, filtered at 0.6 Hz."),
    _row("reversals_cognitive", "1/min", "lower", of.cognitive_reversals,
         "Reversals of a wheel by more than 0.1 deg, filtered at 2 Hz."),
    _row("reversals_stick_fine", "1/min", "lower", of.fine_reversals,
         "Reversals of a stick by more than 5 % of its travel, filtered at 2 Hz."),
    _row("reversals_stick_coarse", "1/min", "lower", of.coarse_reversals,
         "Reversals of a stick by more than 25 % of its travel, filtered at 0.6 Hz."),
    _row("reversals_keys", "1/min", "lower", of.key_reversals,
         "Reversals of steering keys, not filtered."),
    _row("camera_off_centre", "share", "lower", of.off_centre,
         "Share of the driving time in which the camera looks more than 15 deg to a side; "
         "unknown if the robot never drives."),
    _row("command_rate", "1/s", "lower", of.command_rate,
         "Changes of intention per second: edges of keys, and moves of a stick by more than "
         "5 %."),
    _row("photon_p50", "s", "lower", of.photon_median,
         "Motion to photon: from an input to the first frame that was taken after the world "
         "answered. Median."),
    _row("photon_p95", "s", "lower", of.photon_p95, "The same: 95th percentile."),
    _row("photon_missing", "inputs", "lower", of.photons_missing,
         "Inputs without such a frame."),
    *(
        _row(f"sagat_{level}", "share", "higher", of.awareness_of(level),
             f"Right answers to the queries of level {level} of SAGAT; no answer is wrong.")
        for level in (1, 2, 3)
    ),
    _row("sagat_unanswered", "queries", "lower", of.unanswered, "Queries without an answer."),
    _row("tlx_raw", "", "lower", of.raw_tlx, "NASA-TLX, 0 to 100: mean of the six ratings.",
         most=100.0),
    _row("tlx_weighted", "", "lower", of.weighted_tlx,
         "NASA-TLX, 0 to 100: ratings by how often their scale was chosen.", most=100.0),
    _row("sus", "", "higher", of.sus,
         "System Usability Scale, 0 to 100. A missing answer counts as 3; unknown if more "
         "than 3 miss.", most=100.0),
    _row("sart", "", "higher", of.sart,
         "Situation Awareness Rating Technique: understanding - (demand - supply), -14 to "
         "46.", least=-14.0, most=46.0),
)  # fmt: skip

LONGEST_S = 1e6
"""Longest trial [s]: 11 days."""
METRICS: Mapping[str, Metric] = MappingProxyType({each.name: each for each in _ROWS})
"""All metrics of a trial by name."""


def measure(
    trial: TrialData, spec: MeasureSpec | None = None, names: Collection[str] = METRICS
) -> dict[str, Estimate]:
    """Metrics of a trial, by name; those that cannot be known say why.

    Data with a wrong shape or range are a reason too: they cost the metrics that need them only.

    Args:
        trial: Its data.
        spec: Numbers that the study fixed; None: the usual ones.
        names: Which metrics.

    Raises:
        DataError: The length of the trial is no duration.
    """
    if not 0.0 <= trial.length <= LONGEST_S:
        text = f"a trial lasts from 0 s to {LONGEST_S:g} s, not {trial.length:g} s"
        raise DataError(text)
    analysis = TrialAnalysis(trial, spec or MeasureSpec())
    return {name: _computed(METRICS[name], analysis) for name in names}


def scores(answers: Questionnaires) -> dict[str, Estimate]:
    """The scores of those questionnaires that were asked outside trials, by the metric's name."""
    asked = {
        "tlx_raw": answers.tlx,
        "tlx_weighted": answers.tlx_choices,
        "sus": answers.sus,
        "sart": answers.sart,
    }
    analysis = TrialAnalysis(TrialData(length=0.0, questionnaires=answers), MeasureSpec())
    return {name: _computed(METRICS[name], analysis) for name, given in asked.items() if given}


def _computed(metric: Metric, analysis: TrialAnalysis) -> Estimate:
    try:
        return metric.bounded(metric.function(analysis))
    except DataError as error:
        return unknown(f"its data cannot be used: {error}")
