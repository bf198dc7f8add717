"""The robot's tilt and its height over the ground at the time of a picture; pure."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator
from itertools import pairwise

from hub.gcm.flight import Altitude
from hub.gcm.imu import Imu
from hub.values import dataclass

_MOST = 100
"""Most values that are kept: five seconds of the fastest message."""
_GAP_S = 0.5
"""A value holds for this time [s]; between two that are farther apart, nothing is known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureStance:
    """How a robot stood, flew or dived at one time.

    Attributes:
        roll: Its roll [rad]; NaN: not measured.
        pitch: Its pitch [rad]; NaN: not measured.
        above_ground: Its origin above the ground [m]; 0: it stands; NaN: not known.
    """

    roll: float = math.nan
    pitch: float = math.nan
    above_ground: float = 0.0


class Stances:
    """Tilts and heights of the last seconds."""

    def __init__(self, *, stands: bool) -> None:
        """Know nothing yet.

        Args:
            stands: Whether the robot stands on the ground; else it flies or dives.
        """
        self._stands = stands
        self._tilts: deque[tuple[float, float, float]] = deque(maxlen=_MOST)
        self._heights: deque[tuple[float, float]] = deque(maxlen=_MOST)

    def tilted(self, imu: Imu, measured: float) -> None:
        """Take a tilt, measured at a monotonic time [s]."""
        roll, pitch, _ = imu.roll_pitch_yaw
        if not math.isnan(roll):
            self._tilts.append((measured, roll, pitch))

    def rose(self, altitude: Altitude, measured: float) -> None:
        """Take a height, measured at a monotonic time [s]."""
        self._heights.append((measured, altitude.above_ground))

    def at(self, time: float) -> PictureStance:
        """The stance at a time [s]."""
        roll, pitch = _at(self._tilts, time) or (math.nan, math.nan)
        if self._stands:
            return PictureStance(roll=roll, pitch=pitch)
        (above,) = _at(self._heights, time) or (math.nan,)
        # A body on the ground still is one that flies or dives: 0 would mean the opposite.
        return PictureStance(roll=roll, pitch=pitch, above_ground=above or math.nan)


def _at(known: Iterable[tuple[float, ...]], time: float) -> tuple[float, ...]:
    """The values at a time, between those before and after it; empty: not known."""
    series = [*known]
    for before, after in _backward(series):
        if before[0] <= time <= after[0] and after[0] - before[0] <= 2.0 * _GAP_S:
            share = (time - before[0]) / ((after[0] - before[0]) or 1.0)
            return tuple(a + (b - a) * share for a, b in zip(before[1:], after[1:], strict=True))
    newest = series[-1] if series else None
    if newest is not None and 0.0 <= time - newest[0] <= _GAP_S:
        return newest[1:]
    return ()


def _backward(
    series: list[tuple[float, ...]],
) -> Iterator[tuple[tuple[float, ...], tuple[float, ...]]]:
    return reversed([*pairwise(series)])
