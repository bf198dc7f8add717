"""Neglect tolerance: how long a robot works on after the operator turned away.

D. R. Olsen and M. A. Goodrich, Metrics for Evaluating Human-Robot Interactions, PerMIS 2003. Most
neglects end because the operator returns, not because the robot stops: those times are censored.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from hub.values import dataclass
from rune_study.metrics.effectiveness import Signal, attended
from rune_study.metrics.episodes import Episode

FRACTION = 0.5
"""TE below this share of its median while attended is a drop."""
HOLD_S = 3.0
"""Least duration of a drop [s]."""
SHORT_S = 0.5
"""It may be shorter, down to this [s], if the operator then returns: he came because of it."""
LEAST_SEEN = 1 / 3
"""Below this share of drops that were seen, neglect tolerance cannot be identified."""

_EQUAL = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Neglect:
    """The time after an episode of interaction.

    Attributes:
        begin: End of the episode [s].
        length: Time to the drop of TE, or to what ended the observation [s].
        seen: Whether it ended with a drop; otherwise it is censored.
    """

    begin: float
    length: float
    seen: bool


def threshold(rate: Signal, spans: tuple[Episode, ...], fraction: float = FRACTION) -> float:
    """TE below which a robot needs the operator: a share of its median while attended.

    Returns:
        NaN if TE is not known while attended, or its median there is not above 0. Then a drop does
        not differ from how the robot works when served.
    """
    inside = rate.values[attended(rate, spans)]
    inside = inside[~np.isnan(inside)]
    middle = float(np.median(inside)) if inside.size else math.nan
    return fraction * middle if middle > 0.0 else math.nan


def neglects(
    spans: Sequence[Episode],
    rate: Signal,
    until: float,
    below: float,
    *,
    hold: float = HOLD_S,
    short: float = SHORT_S,
) -> tuple[Neglect, ...]:
    """The time after each episode up to the drop of TE, or censored.

    The drop is the first moment from which TE stays below the threshold for `hold`, or for `short`
    up to the return of the operator. Otherwise the time is censored at his return, at the end of
    the trial, or where TE is not known. A robot that is down when he leaves has 0, seen.

    Args:
        spans: Episodes of one robot, ascending.
        rate: TE; each value holds up to the next sample, NaN is not known.
        until: End of the trial [s].
        below: The threshold.
        hold: How long a drop lasts [s].
        short: How long one lasts that makes the operator return [s].
    """
    low = list(_runs(rate, rate.values < below, until))
    unknown = list(_runs(rate, np.isnan(rate.values), until))
    if rate.times.size and rate.times[0] > 0.0:
        unknown.insert(0, (0.0, float(rate.times[0])))
    return tuple(
        _neglect(place, spans, low, unknown, until, hold, short) for place in range(len(spans))
    )


def _neglect(
    place: int,
    spans: Sequence[Episode],
    low: list[tuple[float, float]],
    unknown: list[tuple[float, float]],
    until: float,
    hold: float,
    short: float,
) -> Neglect:
    begin = spans[place].end
    returned = place + 1 < len(spans) and spans[place + 1].begin < until
    stop = max(begin, spans[place + 1].begin if returned else until)
    known = min([stop, *(max(begin, first) for first, last in unknown if last > begin)])
    returned &= known == stop
    for fell, rose in low:
        first, last = max(fell, begin), min(rose, known)
        lasts = last - first + _EQUAL
        if lasts >= hold or (returned and last == stop and lasts >= short):
            return Neglect(begin=begin, length=first - begin, seen=True)
    return Neglect(begin=begin, length=known - begin, seen=False)


def _runs(
    rate: Signal, flags: np.typing.NDArray[np.bool_], until: float
) -> Iterator[tuple[float, float]]:
    """Begin and end of each run of samples with a flag, up to the next sample without it [s]."""
    edges = np.diff(np.concatenate(([0], flags.astype(np.int8), [0])))
    ends = (
        np.append(rate.times, max(until, float(rate.times[-1]))) if rate.times.size else rate.times
    )
    for first, last in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True):
        yield float(ends[first]), float(ends[last])
