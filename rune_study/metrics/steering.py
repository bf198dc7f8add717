"""Steering reversals: how often the operator corrects his course.

G. Markkula and J. Engstrom, A Steering Wheel Reversal Rate Metric for Assessing Effects of Visual
and Cognitive Secondary Task Load, 2006; SAE J2944. A low-pass filter without delay, then stationary
points, then those that differ by more than a gap.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rune_study.errors import DataError
from rune_study.statistics.arrays import Floats, floats

RATE_HZ = 50.0
"""Signals are sampled so often [1/s]."""
_EDGE = 9
"""Samples by which the filter extends a signal at both ends; it needs more than these."""


class Reversals(NamedTuple):
    """A way to count reversals.

    Attributes:
        gap: Least difference, in the unit of the signal.
        cut_hz: Cut-off frequency of the filter [1/s]; None: the signal is not filtered.
    """

    gap: float
    cut_hz: float | None


VISUAL = Reversals(gap=3.0, cut_hz=0.6)
"""Of a wheel [deg], for visual load."""
COGNITIVE = Reversals(gap=0.1, cut_hz=2.0)
"""Of a wheel [deg], for cognitive load."""
STICK_FINE = Reversals(gap=0.05, cut_hz=2.0)
"""Of a stick, as a share of its travel."""
STICK_COARSE = Reversals(gap=0.25, cut_hz=0.6)
"""The same, large ones."""
KEYS = Reversals(gap=0.25, cut_hz=None)
"""Of keys: their steps are not filtered."""


def held(times: npt.ArrayLike, values: npt.ArrayLike, until: float, rate_hz: float) -> Floats:
    """Samples of a signal that holds each value up to the next, from 0 s to `until`.

    Args:
        times: Ascending [s], shape (n,).
        values: Shape (n,). Before the first one the signal is 0.
        until: Last sample [s].
        rate_hz: Samples per second [1/s].

    Raises:
        DataError: Lengths differ, times do not ascend, or the end is not finite.
    """
    at, given = floats(times, "times"), floats(values, "values")
    if len(at) != len(given) or (np.diff(at) < 0.0).any() or not math.isfinite(until):
        text = "a signal needs one ascending time for each value, and a finite end"
        raise DataError(text)
    grid = np.arange(math.floor(until * rate_hz + 1e-9) + 1) / rate_hz
    place = np.searchsorted(at, grid + 1e-9, side="right")
    return np.append(0.0, given)[place]


def reversals(angles: npt.ArrayLike, gap: float) -> int:
    """Number of reversals, up and down, of a signal.

    A sample is stationary if the signal turns there or stood still before it. The last one is not.

    Args:
        angles: Evenly sampled, shape (n,).
        gap: Stationary points must differ by more than this.
    """
    values = floats(angles, "angles")
    if values.size < 2:
        return 0
    steps = np.concatenate(([0.0], np.diff(values)))
    signs = np.sign(steps)
    turning = (np.abs(np.diff(signs)) == 2.0) | (steps[:-1] == 0.0)
    points = values[:-1][turning].tolist()
    return _rises(points, gap) + _rises([-each for each in points], gap)


def _rises(points: list[float], gap: float) -> int:
    count, lowest = 0, math.inf
    for value in points:
        if value - lowest > gap:
            count += 1
            lowest = value
        else:
            lowest = min(lowest, value)
    return count


def reversal_rate(angles: npt.ArrayLike, rate_hz: float, way: Reversals) -> float:
    """Reversals per minute; NaN for signals of at most 9 samples.

    Args:
        angles: Evenly sampled, finite, in the unit of the gap, shape (n,).
        rate_hz: Samples per second [1/s].
        way: How to count.

    Raises:
        DataError: A value is not finite, or the cut-off is not below half the rate.
    """
    values = floats(angles, "angles")
    if values.size <= _EDGE:
        return math.nan
    if not np.isfinite(values).all():
        text = "angles: a value is not finite"
        raise DataError(text)
    smooth = values if way.cut_hz is None else low_pass(values, way.cut_hz, rate_hz)
    return reversals(smooth, way.gap) / ((values.size - 1) / rate_hz) * 60.0


def low_pass(values: npt.ArrayLike, cut_hz: float, rate_hz: float) -> Floats:
    """A second-order Butterworth filter, forward and backward: no delay.

    As `filtfilt` of scipy and MATLAB: the ends are extended by 9 samples as their point reflection,
    and the filter starts in the steady state of the first one.

    Args:
        values: Evenly sampled, finite, more than 9, shape (n,).
        cut_hz: Cut-off frequency [1/s].
        rate_hz: Samples per second [1/s].

    Raises:
        DataError: There are too few samples, one is not finite, or the cut-off is not between 0 and
            half the rate.
    """
    given = floats(values, "values")
    if given.size <= _EDGE or not np.isfinite(given).all():
        text = f"the filter needs more than {_EDGE} samples, all finite"
        raise DataError(text)
    if not 0.0 < cut_hz < 0.5 * rate_hz:
        text = f"a cut-off of {cut_hz:g} Hz is not between 0 and half the rate of {rate_hz:g} Hz"
        raise DataError(text)
    before = 2.0 * given[0] - given[_EDGE:0:-1]
    after = 2.0 * given[-1] - given[-2 : -_EDGE - 2 : -1]
    warped = math.tan(math.pi * cut_hz / rate_hz)
    there = _filtered(np.concatenate((before, given, after)), warped)
    return _filtered(there[::-1], warped)[::-1][_EDGE:-_EDGE]


def _filtered(values: Floats, warped: float) -> Floats:
    """One run of the filter, by the bilinear transform, as if the first value had always been."""
    scale = 1.0 / (1.0 + math.sqrt(2.0) * warped + warped * warped)
    b = warped * warped * scale
    a1 = 2.0 * (warped * warped - 1.0) * scale
    a2 = (1.0 - math.sqrt(2.0) * warped + warped * warped) * scale
    first = float(values[0])
    one, two = first * (1.0 - b), first * (b - a2)  # of a signal that always was the first value
    out = []
    for value in values.tolist():
        new = b * value + one
        one = 2.0 * b * value - a1 * new + two
        two = b * value - a2 * new
        out.append(new)
    return np.array(out)
