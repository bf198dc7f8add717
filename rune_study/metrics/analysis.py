"""The metrics of a trial that stand on its episodes of interaction, each computed once."""

from __future__ import annotations

import functools
import math

import numpy as np

from hub.values import dataclass
from rune_study.estimate import Estimate, unknown
from rune_study.metrics.effectiveness import Signal, rate_of_progress
from rune_study.metrics.episodes import Episode, covered, episodes
from rune_study.metrics.fan_out import (
    TeamRobot,
    active_robots,
    attention_demand,
    fan_out_estimate,
)
from rune_study.metrics.neglect import Neglect, neglects, threshold
from rune_study.metrics.trial import MeasureSpec, RobotData, TrialData
from rune_study.statistics.means import mean, share
from rune_study.statistics.survival import Survival, kaplan_meier, restricted_mean_estimate

INPUTS_NOT_KNOWN = "the operator's inputs were not recorded"
"""Why there is no number of what the operator did."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotAnalysis:
    """What follows from the inputs and the progress of one robot.

    Attributes:
        log: Its data.
        episodes: Of interaction.
        rate: TE; None: no progress was recorded.
        below: TE from which on it works; NaN: not known.
        neglects: The time after each episode; none if `below` is not known.
    """

    log: RobotData
    episodes: tuple[Episode, ...]
    rate: Signal | None
    below: float
    neglects: tuple[Neglect, ...]


class TrialAnalysis:
    """A trial, and what several metrics need of it."""

    def __init__(self, trial: TrialData, spec: MeasureSpec) -> None:
        self.trial = trial
        self.spec = spec

    @functools.cached_property
    def robots(self) -> tuple[RobotAnalysis, ...]:
        """Each robot's episodes, TE and neglects."""
        return tuple(self._analysed(each) for each in self.trial.robots)

    @functools.cached_property
    def episodes(self) -> tuple[Episode, ...]:
        """Episodes of all robots."""
        return tuple(span for robot in self.robots for span in robot.episodes)

    @functools.cached_property
    def neglects(self) -> tuple[Neglect, ...]:
        """Neglects of all robots."""
        return tuple(span for robot in self.robots for span in robot.neglects)

    @functools.cached_property
    def attended(self) -> float:
        """Time with at least one robot [s]; what overlaps counts once."""
        return covered(((each.begin, each.end) for each in self.episodes), 0.0, self.trial.length)

    @functools.cached_property
    def effort(self) -> Estimate:
        """IE: mean length of an episode [s].

        A return within the pause that ends an episode makes one of two. Where the operator chose
        the robot again in between, the interval is wider: it also holds the mean of both apart.
        """
        if not self.episodes:
            return self.no_episode
        found = mean([each.length for each in self.episodes])
        split = [
            span.length for robot in self.robots for span in self._spans(robot.log, split=True)
        ]
        returns = len(split) - len(self.episodes)
        if not returns:
            return found
        apart = mean(split)
        note = f"returns within the pause that ends an episode: {returns}; counted apart, IE is"
        return Estimate(
            value=found.value,
            low=float(np.fmin(found.low, apart.low)),
            high=float(np.fmax(found.high, apart.high)),
            n=found.n,
            note=f"{note} {apart.value:.3g} s, and the interval holds both",
        )

    @functools.cached_property
    def seen(self) -> Estimate:
        """Share of neglects that ended with a drop that was seen."""
        if not self.neglects:
            return unknown(self._why_no_neglect())
        return share(sum(each.seen for each in self.neglects), len(self.neglects))

    @functools.cached_property
    def curve(self) -> Survival | None:
        """Kaplan-Meier curve of neglect tolerance; None: there is no neglect."""
        spans = self.neglects
        if not spans:
            return None
        return kaplan_meier([each.length for each in spans], [each.seen for each in spans])

    @functools.cached_property
    def tau(self) -> float:
        """Bound of the restricted mean [s]."""
        return self.spec.tau or max((each.length for each in self.neglects), default=0.0)

    @functools.cached_property
    def tolerance_median(self) -> Estimate:
        """NT: median [s]."""
        return self._hidden or (self.curve.median if self.curve else self.seen)

    @functools.cached_property
    def tolerance(self) -> Estimate:
        """NT: restricted mean [s]."""
        if self._hidden or not self.curve:
            return self._hidden or self.seen
        if self.tau == 0.0:
            return Estimate(value=0.0, n=self.curve.n, note="every robot was down when left")
        return restricted_mean_estimate(self.curve, self.tau)

    @functools.cached_property
    def fan_out(self) -> Estimate:
        """FO, with the restricted mean of NT."""
        return fan_out_estimate(self.effort, self.tolerance)

    @functools.cached_property
    def demand(self) -> Estimate:
        """RAD = 1 / FO."""
        robots = self.fan_out
        if not robots.known:
            return robots
        return Estimate(
            value=attention_demand(self.effort.value, self.tolerance.value),
            low=1.0 / robots.high,
            high=1.0 / robots.low,
            n=robots.n,
            note=robots.note,
        )

    @functools.cached_property
    def active(self) -> Estimate:
        """FO as measured: mean number of robots that are served or work."""
        team = [
            TeamRobot(spans=each.episodes, rate=each.rate, below=each.below)
            for each in self.robots
            if each.rate is not None
        ]
        if not self.trial.inputs_known:
            return unknown(INPUTS_NOT_KNOWN)
        if not team or len(team) < len(self.robots):
            return unknown("the progress of a robot was not recorded")
        value = active_robots(team)
        if math.isnan(value):
            return unknown("the trial has no length")
        return Estimate(value=value, n=len(team), note=f"of {len(team)} robots")

    @property
    def _hidden(self) -> Estimate | None:
        """Why neglect tolerance cannot be identified, if so."""
        if not self.seen.known:
            return self.seen
        if self.seen.value >= self.spec.least_seen - 1e-12:
            return None
        drops = sum(each.seen for each in self.neglects)
        why = f"not identifiable: only {drops} of {self.seen.n} neglects ended with a drop"
        return unknown(why, self.seen.n)

    @property
    def no_episode(self) -> Estimate:
        """Why there is no episode of interaction."""
        known = self.trial.inputs_known
        return unknown("there was no interaction" if known else INPUTS_NOT_KNOWN)

    def _why_no_neglect(self) -> str:
        if not self.episodes:
            return self.no_episode.why
        if all(each.rate is None for each in self.robots):
            return "no progress was recorded"
        return "not identifiable: there was no progress while the operator attended"

    def _spans(self, log: RobotData, *, split: bool = False) -> tuple[Episode, ...]:
        return episodes(
            log.inputs,
            log.selections,
            held=log.held,
            gap=self.spec.gap,
            least=self.spec.least,
            until=self.trial.length,
            split_at_selections=split,
        )

    def _analysed(self, log: RobotData) -> RobotAnalysis:
        spec, until = self.spec, self.trial.length
        spans = self._spans(log)
        if log.progress is None:
            return RobotAnalysis(log=log, episodes=spans, rate=None, below=math.nan, neglects=())
        rate = rate_of_progress(
            log.progress,
            until,
            window=spec.window,
            rate_hz=spec.rate_hz,
            longest_gap=spec.silence,
        )
        below = threshold(rate, spans, spec.fraction)
        found = (
            ()
            if math.isnan(below)
            else neglects(spans, rate, until, below, hold=spec.hold, short=spec.short)
        )
        return RobotAnalysis(log=log, episodes=spans, rate=rate, below=below, neglects=found)
