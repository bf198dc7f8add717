"""Time of a trial: from its first moment with control to its end, without freezes and pauses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.statistics.arrays import Flags, Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialTime:
    """A trial on the hub's clock.

    Attributes:
        begin: First moment at which control is possible [s].
        end: Its end [s].
        pauses: Begin and end of each freeze and pause [s], ascending, apart from each other.
    """

    begin: float
    end: float
    pauses: tuple[tuple[float, float], ...] = ()

    @property
    def length(self) -> float:
        """Duration without pauses [s]."""
        return float(self.moments([self.end])[0])

    def moments(self, times: npt.ArrayLike) -> Floats:
        """Times of the hub as times of the trial [s].

        A time in a pause becomes the moment at which the trial stood still, so that the newest
        value of a signal stays. Times before the trial become 0, times after it its length.
        """
        at = np.clip(np.asarray(times, np.float64), self.begin, self.end)
        moments = at - self.begin
        for first, last in self.pauses:
            begin, end = max(first, self.begin), min(last, self.end)
            if end > begin:
                moments -= np.clip(at - begin, 0.0, end - begin)
        return moments

    def during(self, times: npt.ArrayLike) -> Flags:
        """Whether times of the hub lie within the trial and in no pause."""
        at = np.asarray(times, np.float64)
        inside: Flags = (at >= self.begin) & (at <= self.end)
        for begin, end in self.pauses:
            inside &= ~((at >= begin) & (at < end))
        return inside


def trial_time(begin: float, end: float, pauses: Sequence[tuple[float, float]] = ()) -> TrialTime:
    """The time of a trial; pauses that touch or overlap become one.

    Args:
        begin: First moment at which control is possible [s].
        end: Its end [s].
        pauses: Begin and end of each freeze and pause [s], in any order.

    Raises:
        DataError: It ends before it begins, or a pause does.
    """
    if not begin <= end or any(not first <= last for first, last in pauses):
        text = "a trial or a pause ends before it begins"
        raise DataError(text)
    joined: list[tuple[float, float]] = []
    for first, last in sorted(pauses):
        if joined and first <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(last, joined[-1][1]))
        else:
            joined.append((first, last))
    return TrialTime(begin=begin, end=end, pauses=tuple(joined))
