"""Task effectiveness TE(t): how fast the task progresses."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.metrics.episodes import Episode
from rune_study.statistics.arrays import Flags, Floats, floats

WINDOW_S = 1.0
"""Width of the centred window in which progress is counted [s]."""
RATE_HZ = 10.0
"""TE is computed so often [1/s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """A number over time.

    Attributes:
        times: Ascending [s], shape (n,).
        values: Shape (n,).
    """

    times: Floats
    values: Floats


def signal(times: npt.ArrayLike, values: npt.ArrayLike) -> Signal:
    """A number over time, checked; of equal times the last value counts.

    Raises:
        DataError: Lengths differ, or times are not finite and ascending.
    """
    at, of = floats(times, "times"), floats(values, "values")
    if len(at) != len(of) or not np.isfinite(at).all() or (np.diff(at) < 0.0).any():
        text = "a signal needs one finite, ascending time for each value"
        raise DataError(text)
    last = np.append(np.diff(at) > 0.0, np.ones(min(len(at), 1), bool))
    return Signal(times=at[last], values=of[last])


def rate_of_progress(
    progress: Signal,
    until: float,
    *,
    window: float = WINDOW_S,
    rate_hz: float = RATE_HZ,
    longest_gap: float = math.inf,
) -> Signal:
    """TE(t): progress per second in a centred window.

    The study chooses what progress is: the negative of the path that is left [m], the area that was
    seen [m^2], or metres driven. Between samples it grows evenly. At the ends of the trial the
    window is shorter.

    Args:
        progress: Progress so far, in any unit.
        until: End of the trial [s].
        window: Width of the window [s].
        rate_hz: Samples per second of the result [1/s].
        longest_gap: Samples farther apart than this leave the rate between them unknown [s].

    Returns:
        From 0 up to `until` [unit/s]; NaN where progress is not known.

    Raises:
        DataError: The window or the rate is not above 0, the end is not finite, or times do not
            ascend.
    """
    if not (window > 0.0 and rate_hz > 0.0 and math.isfinite(until)):
        text = "the window and the rate of TE must be above 0, and the end of the trial finite"
        raise DataError(text)
    grid = np.arange(math.floor(until * rate_hz + 1e-9) + 1) / rate_hz
    kept = signal(progress.times, progress.values)
    known = np.isfinite(kept.values)
    times, values = kept.times[known], kept.values[known]
    if times.size < 2:
        return Signal(times=grid, values=np.full(grid.shape, np.nan))
    first = np.clip(grid - 0.5 * window, times[0], times[-1])
    last = np.clip(grid + 0.5 * window, times[0], times[-1])
    width = last - first
    gained = np.interp(last, times, values) - np.interp(first, times, values)
    rate = np.divide(gained, width, out=np.full(grid.shape, np.nan), where=width > 1e-9)
    for place in np.flatnonzero(np.diff(times) > longest_gap):
        rate[(last > times[place] + 1e-9) & (first < times[place + 1] - 1e-9)] = np.nan
    return Signal(times=grid, values=rate)


def driven(x: npt.ArrayLike, y: npt.ArrayLike, step: float = 0.05) -> Floats:
    """Metres driven up to each sample.

    Steps shorter than `step` are noise of a robot that stands; they count when they add up.

    Args:
        x: Positions [m], shape (n,).
        y: The same.
        step: Shortest step that counts at once [m].

    Returns:
        Shape (n,); the rest up to the last sample is not in it. Positions that are not finite add
        nothing.
    """
    xs, ys = floats(x, "x"), floats(y, "y")
    length = np.zeros(xs.shape)
    total, here = 0.0, (math.nan, math.nan)
    for place, (at_x, at_y) in enumerate(zip(xs.tolist(), ys.tolist(), strict=True)):
        if math.isfinite(at_x) and math.isfinite(at_y):
            away = math.dist(here, (at_x, at_y))
            if math.isnan(away):
                here = (at_x, at_y)
            elif away >= step:
                total += away
                here = (at_x, at_y)
        length[place] = total
    return length


def attended(rate: Signal, spans: tuple[Episode, ...]) -> Flags:
    """At which samples of a signal the operator works with the robot."""
    inside = np.zeros(rate.times.shape, np.bool_)
    for each in spans:
        inside |= (rate.times >= each.begin) & (rate.times < each.end)
    return inside
