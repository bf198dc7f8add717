"""Times that are partly censored: the Kaplan-Meier curve and what follows from it.

A time is censored where the event was not seen: it lies later than that. The curve is that of
E. Kaplan and P. Meier (J. Am. Statist. Assoc. 53, 1958), its variance M. Greenwood's. Its limits
are symmetric in log(-log S). At equal times events come before censorings.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.estimate import LEVEL, Estimate, unknown
from rune_study.statistics.arrays import Flags, Floats, floats
from rune_study.statistics.distributions import normal_quantile, t_quantile, upper_share

MEDIAN_RULE = "first time of an event at which S <= 0.5 (+ 1e-12)"
"""Which time is the median; where S is 0.5 exactly, R takes the middle up to the next event."""

_EQUAL = 1e-12
"""S may be this much above a share to count as having reached it; products round."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestrictedMean:
    """Mean time up to a bound: the area under the curve.

    Attributes:
        value: The mean of min(time, tau).
        tau: The bound.
        standard_error: By Greenwood's formula, as R's `survfit` has it.
        low: Lower end of its interval, at least 0; NaN with fewer than two events before the bound.
            The interval is Student's, with the variance times m / (m - 1) for m events
            (J. P. Klein, M. L. Moeschberger, Survival Analysis, 2nd edition, 4.5).
        high: Upper end, at most tau; the same.
    """

    value: float
    tau: float
    standard_error: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Survival:
    """A Kaplan-Meier curve. All arrays have the shape (times,).

    Attributes:
        times: Different times of events, ascending.
        survival: S after each of them.
        low: Lower limit of S; 0 where S is 0, though its variance is not defined there.
        high: Upper limit of S; the same.
        at_risk: Observations that reach each time.
        events: Events at each time.
        censored: Censored times, ascending, with repetitions, shape (censored,).
        n: Observations.
        level: Confidence level of the limits.
    """

    times: Floats
    survival: Floats
    low: Floats
    high: Floats
    at_risk: Floats
    events: Floats
    censored: Floats
    n: int
    level: float

    def at(self, time: float) -> float:
        """S at a time: the chance of an event later than it."""
        place = int(np.searchsorted(self.times, time, side="right"))
        return float(self.survival[place - 1]) if place else 1.0

    @property
    def seen(self) -> float:
        """Share of the observations whose event was seen."""
        return float(self.events.sum()) / self.n

    @property
    def last(self) -> float:
        """The last observation, an event or a censoring."""
        return float(max(self.times.max(initial=0.0), self.censored.max(initial=0.0)))

    def quantile(self, share: float = 0.5) -> Estimate:
        """First time at which this share had its event; infinity: not that many had.

        The interval is that of R. Brookmeyer and J. Crowley (Biometrics 38, 1982), from the limits
        where S is above 0. Where these decide nothing, the end is 0 or infinity.

        Args:
            share: From 0 to 1; 0.5 is the median by MEDIAN_RULE.

        Raises:
            DataError: The share is not between 0 and 1.
        """
        if not 0.0 < share < 1.0:
            text = f"a quantile needs a share between 0 and 1, not {share:g}"
            raise DataError(text)

        def first(curve: Floats) -> float:
            reached = np.flatnonzero(curve <= 1.0 - share + _EQUAL)
            return float(self.times[reached[0]]) if reached.size else math.inf

        above = self.survival > 0.0
        value, low, high = first(self.survival), first(self.low[above]), first(self.high[above])
        return Estimate(value=value, low=low if low <= value else 0.0, high=high, n=self.n)

    @property
    def median(self) -> Estimate:
        """The median by MEDIAN_RULE."""
        return self.quantile(0.5)

    def restricted_mean(self, tau: float) -> RestrictedMean:
        """Mean time up to `tau`; beyond the last observation the curve stays as it is.

        Args:
            tau: The bound, above 0, in the unit of the times.

        Raises:
            DataError: The bound is not a finite number above 0.
        """
        if not 0.0 < tau < math.inf:
            text = f"a restricted mean needs a finite bound above 0, not {tau:g}"
            raise DataError(text)
        before = self.times < tau
        ends = np.concatenate(([0.0], self.times[before], [tau]))
        areas = np.concatenate(([1.0], self.survival[before])) * np.diff(ends)
        value = float(areas.sum())
        later = value - np.cumsum(areas)[:-1]  # the area beyond each time
        at_risk, events = self.at_risk[before], self.events[before]
        alive = at_risk > events  # where all had their event, the area beyond is 0
        terms = later[alive] ** 2 * events[alive] / (at_risk[alive] * (at_risk - events)[alive])
        error = math.sqrt(float(terms.sum()))
        count = float(events.sum())
        half = math.nan
        if error > 0.0 and count > 1.0:
            wider = math.sqrt(count / (count - 1.0))
            half = t_quantile(upper_share(self.level), count - 1.0) * wider * error
        return RestrictedMean(
            value=value,
            tau=tau,
            standard_error=error,
            low=half if math.isnan(half) else max(0.0, value - half),
            high=half if math.isnan(half) else min(tau, value + half),
        )


def kaplan_meier(
    durations: npt.ArrayLike, observed: npt.ArrayLike, level: float = LEVEL
) -> Survival:
    """The curve of times that are partly censored.

    Args:
        durations: Time to the event or to the censoring, finite, at least 0, shape (n,).
        observed: Whether the event was seen, shape (n,).
        level: Confidence level of the limits.

    Raises:
        DataError: There is no duration, or one is negative, infinite or missing, or the level is
            not between 0 and 1.
    """
    upper = upper_share(level)
    times, seen = durations_of(durations, observed)
    if not times.size:
        text = "a survival curve needs at least one duration"
        raise DataError(text)
    at = np.unique(times[seen])
    ordered, of_events = np.sort(times), np.sort(times[seen])
    at_risk = (len(times) - np.searchsorted(ordered, at, side="left")).astype(float)
    events = np.diff(np.searchsorted(of_events, np.append(at, np.inf), side="left")).astype(float)
    survival = np.cumprod(1.0 - events / at_risk)
    z = normal_quantile(upper)
    with np.errstate(divide="ignore", invalid="ignore"):
        greenwood = np.cumsum(events / (at_risk * (at_risk - events)))
        half = z * np.sqrt(greenwood) / np.abs(np.log(survival))
        low, high = survival ** np.exp(half), survival ** np.exp(-half)
    low[survival <= 0.0] = high[survival <= 0.0] = 0.0
    return Survival(
        times=at,
        survival=survival,
        low=low,
        high=high,
        at_risk=at_risk,
        events=events,
        censored=np.sort(times[~seen]),
        n=len(times),
        level=level,
    )


def durations_of(durations: npt.ArrayLike, observed: npt.ArrayLike) -> tuple[Floats, Flags]:
    """Durations and whether their event was seen, checked.

    Raises:
        DataError: They have different lengths, or a duration is negative, infinite or missing.
    """
    times = floats(durations, "durations")
    seen = floats(observed, "observed")
    if len(times) != len(seen) or not np.isin(seen, (0.0, 1.0)).all():
        text = "each duration needs a 1 if its event was seen, or a 0 if not"
        raise DataError(text)
    if not np.isfinite(times).all() or (times < 0.0).any():
        text = "durations must be finite and at least 0; leave out those that are missing"
        raise DataError(text)
    return times, seen.astype(bool)


def restricted_mean_estimate(curve: Survival, tau: float) -> Estimate:
    """The restricted mean as an estimate that names its bound.

    It also names the last observation, if the curve is not known up to the bound.
    """
    if tau <= 0.0:
        return unknown("every time is 0", curve.n)
    found = curve.restricted_mean(tau)
    note = f"restricted to {tau:g} s"
    if curve.at(tau) > 0.0 and curve.last < tau:
        note += f", but nothing is known beyond {curve.last:g} s"
    return Estimate(
        value=found.value,
        low=found.low,
        high=found.high,
        n=curve.n,
        note=note,
    )
