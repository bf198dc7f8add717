"""The functions of the table of metrics: from a trial to an estimate, or why there is none."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator

import numpy as np

from rune_study.estimate import Estimate, unknown
from rune_study.metrics import bumps as bumping
from rune_study.metrics import driving, fan_out, questionnaires, steering, victims
from rune_study.metrics.analysis import INPUTS_NOT_KNOWN, TrialAnalysis
from rune_study.metrics.awareness import awareness
from rune_study.metrics.coverage import coverage
from rune_study.metrics.effectiveness import Signal, signal
from rune_study.metrics.map_quality import MapQuality, map_quality
from rune_study.metrics.trial import Motion, RobotData, Travel
from rune_study.metrics.victims import VictimsFound
from rune_study.statistics.means import mean, share

Function = Callable[[TrialAnalysis], Estimate]


def _number(value: float, why: str, n: int = 1) -> Estimate:
    """A number; NaN becomes the reason."""
    return unknown(why) if math.isnan(value) else Estimate(value=float(value), n=n)


def mean_effectiveness(it: TrialAnalysis) -> Estimate:
    """Progress of all robots per second."""
    gained = []
    for robot in it.trial.robots:
        if robot.progress is not None:
            values = signal(robot.progress.times, robot.progress.values).values
            values = values[np.isfinite(values)]
            if values.size:
                gained.append(float(values[-1] - values[0]))
    if not gained or it.trial.length <= 0.0:
        return unknown("no progress was recorded")
    return Estimate(value=sum(gained) / it.trial.length, n=len(gained))


def completion(it: TrialAnalysis) -> Estimate:
    """Share of robots that reached their goal."""
    goals = [each for each in _travels(it) if not math.isnan(each.shortest)]
    if not goals:
        return unknown("no robot had a goal")
    return Estimate(value=sum(each.arrived for each in goals) / len(goals), n=len(goals))


def episode_count(it: TrialAnalysis) -> Estimate:
    """Number of episodes of interaction."""
    if not it.trial.inputs_known:
        return unknown(INPUTS_NOT_KNOWN)
    return Estimate(value=len(it.episodes), n=len(it.episodes))


def inputs_per_episode(it: TrialAnalysis) -> Estimate:
    """Mean number of inputs of an episode."""
    if not it.episodes:
        return it.no_episode
    return mean([each.inputs for each in it.episodes])


def mission_demand(it: TrialAnalysis) -> Estimate:
    """Share of the trial with at least one robot."""
    if it.trial.length <= 0.0:
        return unknown("the trial has no length")
    if not it.trial.inputs_known:
        return unknown(INPUTS_NOT_KNOWN)
    return Estimate(value=it.attended / it.trial.length, n=len(it.episodes))


def free_time(it: TrialAnalysis) -> Estimate:
    """FT = 1 - RAD."""
    demand = it.demand
    if not demand.known:
        return demand
    return Estimate(
        value=1.0 - demand.value,
        low=1.0 - demand.high,
        high=1.0 - demand.low,
        n=demand.n,
        note=demand.note,
    )


def secondary_free_time(it: TrialAnalysis) -> Estimate:
    """FT by the secondary task."""
    task = it.trial.secondary
    if task is None:
        return unknown("there was no secondary task")
    return fan_out.free_time_of_secondary_task(
        task.correct, task.seconds, task.correct_alone, task.seconds_alone
    )


def secondary_right(it: TrialAnalysis) -> Estimate:
    """Share of the secondary task's questions that were answered correctly."""
    task = it.trial.secondary
    if task is None or not task.asked:
        return unknown("no question of a secondary task was asked")
    return share(task.correct, task.asked)


def secondary_missed(it: TrialAnalysis) -> Estimate:
    """Questions of the secondary task without an answer."""
    task = it.trial.secondary
    if task is None or not task.asked:
        return unknown("no question of a secondary task was asked")
    return Estimate(value=task.missed, n=task.asked)


def secondary_time(it: TrialAnalysis) -> Estimate:
    """Median time of correct answers to the secondary task."""
    task = it.trial.secondary
    if task is None or not task.times:
        return unknown("no question of a secondary task was answered correctly")
    return Estimate(value=float(np.median(task.times)), n=len(task.times))


def first_victim(it: TrialAnalysis) -> Estimate:
    """Time to the first victim."""
    trial = it.trial
    if trial.marks is None or trial.victims is None:
        return unknown("marks or true places of victims are not known")
    return victims.first_victim(trial.marks, trial.victims, trial.length, it.spec.radius)


def _of_victims(why: str, value: Callable[[VictimsFound], float]) -> Function:
    def function(it: TrialAnalysis) -> Estimate:
        trial = it.trial
        if trial.marks is None or trial.victims is None:
            return unknown("marks or true places of victims are not known")
        found = victims.victims_found(trial.marks, trial.victims, it.spec.radius)
        return _number(value(found), why, found.marks)

    return function


found_victims = _of_victims("", lambda found: found.found)
found_fraction = _of_victims("there is no victim", lambda found: found.fraction)
false_marks = _of_victims("", lambda found: found.false)
mark_precision = _of_victims("there is no mark", lambda found: found.precision)
mark_error = _of_victims("no mark is near a victim", lambda found: found.error)


def ground_covered(it: TrialAnalysis) -> Estimate:
    """Share of the reachable cells that were seen."""
    seen, within = it.trial.seen, it.trial.reachable
    if seen is None or within is None:
        return unknown("what was seen or what can be reached is not known")
    return _number(coverage(seen, within), "nothing can be reached", int(np.sum(within)))


def _of_map(why: str, value: Callable[[MapQuality], float]) -> Function:
    def function(it: TrialAnalysis) -> Estimate:
        marked, true = it.trial.marked, it.trial.surface
        if marked is None or true is None:
            return unknown("the map or the true surface is not known")
        if not len(true):
            return unknown("the arena has no surface")
        return _number(value(map_quality(marked, true, it.spec.tolerance)), why, len(marked))

    return function


map_f1 = _of_map("", lambda found: found.f1)
map_precision = _of_map("the map has no occupied cell", lambda found: found.precision)
map_recall = _of_map("", lambda found: found.recall)


def _of_bumps(value: Callable[[bumping.Bumps], int]) -> Function:
    def function(it: TrialAnalysis) -> Estimate:
        logs = [each.contacts for each in it.trial.robots if each.contacts is not None]
        if not logs:
            return unknown("no contacts were recorded")
        total = sum(
            value(
                bumping.bumps(
                    each.times, each.counts, each.bumpers, each.linear, directions=each.directions
                )
            )
            for each in logs
        )
        return Estimate(value=total, n=len(logs))

    return function


all_bumps = _of_bumps(lambda found: found.total)
front_bumps = _of_bumps(lambda found: found.front)
rear_bumps = _of_bumps(lambda found: found.rear)
side_bumps = _of_bumps(lambda found: found.side)


def _travels(it: TrialAnalysis) -> Iterator[Travel]:
    yield from (each.travel for each in it.trial.robots if each.travel is not None)


def driven(it: TrialAnalysis) -> Estimate:
    """Path of all robots [m]."""
    lengths = [driving.path_length(each.x, each.y, it.spec.step) for each in _travels(it)]
    if not lengths:
        return unknown("no path was recorded")
    return Estimate(value=sum(lengths), n=len(lengths))


def _of_goals(why: str, value: Callable[[float, float, bool], float]) -> Function:
    def function(it: TrialAnalysis) -> Estimate:
        found = [
            value(driving.path_length(each.x, each.y, it.spec.step), each.shortest, each.arrived)
            for each in _travels(it)
            if not math.isnan(each.shortest)
        ]
        if not found:
            return unknown("no robot had a goal")
        kept = [each for each in found if not math.isnan(each)]
        return _number(float(np.mean(kept)) if kept else math.nan, why, len(kept))

    return function


path_ratio = _of_goals(
    "no robot reached its goal",
    lambda done, shortest, arrived: driving.path_ratio(done, shortest, arrived=arrived),
)
success_by_path_length = _of_goals(
    "no robot had a goal",
    lambda done, shortest, arrived: driving.success_by_path_length(done, shortest, arrived=arrived),
)


def _of_steering(
    what: str, pick: Callable[[RobotData], Signal | None], way: steering.Reversals
) -> Function:
    def function(it: TrialAnalysis) -> Estimate:
        signals = [each for each in map(pick, it.trial.robots) if each is not None]
        if not signals:
            return unknown(f"no robot was steered by {what}")
        rates = [
            steering.reversal_rate(
                steering.held(each.times, each.values, it.trial.length, steering.RATE_HZ),
                steering.RATE_HZ,
                way,
            )
            for each in signals
        ]
        return _number(sum(rates), "the trial is too short for the filter", len(rates))

    return function


visual_reversals = _of_steering("a wheel", lambda robot: robot.wheel, steering.VISUAL)
cognitive_reversals = _of_steering("a wheel", lambda robot: robot.wheel, steering.COGNITIVE)
fine_reversals = _of_steering("a stick", lambda robot: robot.stick, steering.STICK_FINE)
coarse_reversals = _of_steering("a stick", lambda robot: robot.stick, steering.STICK_COARSE)
key_reversals = _of_steering("keys", lambda robot: robot.keys, steering.KEYS)


def off_centre(it: TrialAnalysis) -> Estimate:
    """Share of the driving time of all robots with the camera to a side."""
    motions = [
        each.motion for each in it.trial.robots if each.motion and each.motion.pan is not None
    ]
    if not motions:
        return unknown("no camera was recorded")
    shares = [_off_centre(each, it) for each in motions]
    known = [each for each in shares if not math.isnan(each)]
    value = float(np.mean(known)) if known else math.nan
    return _number(value, "no robot drove", len(known))


def _off_centre(motion: Motion, it: TrialAnalysis) -> float:
    if motion.pan is None:
        return math.nan
    return driving.camera_off_centre(
        motion.times, motion.pan, motion.linear, motion.angular, it.trial.length, it.spec.off_centre
    )


def command_rate(it: TrialAnalysis) -> Estimate:
    """Inputs per second; an input is a change of intention."""
    if it.trial.length <= 0.0:
        return unknown("the trial has no length")
    if not it.trial.inputs_known:
        return unknown(INPUTS_NOT_KNOWN)
    count = sum(each.inputs.size for each in it.trial.robots)
    return Estimate(value=count / it.trial.length, n=count)


def _photon_quantile(share: float) -> Function:
    def function(it: TrialAnalysis) -> Estimate:
        delays = it.trial.photons
        if delays is None or not delays.size:
            return unknown("motion to photon was not measured")
        shown = delays[np.isfinite(delays)]
        if not shown.size:
            return unknown("no frame showed an input", delays.size)
        return Estimate(value=float(np.quantile(shown, share)), n=shown.size)

    return function


photon_median = _photon_quantile(0.5)
photon_p95 = _photon_quantile(0.95)


def photons_missing(it: TrialAnalysis) -> Estimate:
    """Inputs that no frame showed."""
    delays = it.trial.photons
    if delays is None or not delays.size:
        return unknown("motion to photon was not measured")
    return Estimate(value=int((~np.isfinite(delays)).sum()), n=delays.size)


def awareness_of(level: int) -> Function:
    """The function of the SAGAT score of a level."""

    def function(it: TrialAnalysis) -> Estimate:
        return awareness(it.trial.queries or (), level)

    return function


def unanswered(it: TrialAnalysis) -> Estimate:
    """Queries of SAGAT without an answer."""
    queries = it.trial.queries
    if not queries:
        return unknown("no query was asked")
    return Estimate(value=sum(each.answer is None for each in queries), n=len(queries))


def raw_tlx(it: TrialAnalysis) -> Estimate:
    """Raw NASA-TLX."""
    ratings = it.trial.questionnaires.tlx
    return _not_asked("NASA-TLX") if ratings is None else _score(questionnaires.raw_tlx(ratings))


def weighted_tlx(it: TrialAnalysis) -> Estimate:
    """Weighted NASA-TLX."""
    answers = it.trial.questionnaires
    if answers.tlx is None or answers.tlx_choices is None:
        return _not_asked("NASA-TLX with pairs")
    return _score(questionnaires.weighted_tlx(answers.tlx, answers.tlx_choices))


def sus(it: TrialAnalysis) -> Estimate:
    """System Usability Scale."""
    answers = it.trial.questionnaires.sus
    return _not_asked("SUS") if answers is None else _score(questionnaires.sus(answers))


def sart(it: TrialAnalysis) -> Estimate:
    """Situation Awareness Rating Technique."""
    answers = it.trial.questionnaires.sart
    return _not_asked("SART") if answers is None else _score(questionnaires.sart(answers))


def _not_asked(name: str) -> Estimate:
    return unknown(f"{name} was not asked")


_score = functools.partial(_number, why="too many answers are missing")
