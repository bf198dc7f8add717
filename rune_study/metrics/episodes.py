"""Episodes of interaction: when the operator works with a robot.

Times are seconds of the trial. Inputs are what the hands do: edges of keys, moves of a stick,
clicks. Commands that are repeated and goals of autonomy are none. While a key is held the hands do
nothing new, and still work with the robot: that is no pause.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_study.errors import DataError
from rune_study.statistics.arrays import Floats, floats

GAP_S = 2.0
"""A longer pause between two inputs ends an episode [s]; reports give 1 and 5 s too."""
LEAST_S = 0.5
"""Duration of one input alone [s]."""

_EQUAL = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """A span in which the operator works with a robot.

    Attributes:
        begin: When he chose the robot, or his first input [s].
        end: His last input [s].
        inputs: Number of inputs; a key that was down before is none.
    """

    begin: float
    end: float
    inputs: int

    @property
    def length(self) -> float:
        """Its duration [s]: one interaction effort."""
        return self.end - self.begin


def episodes(
    inputs: npt.ArrayLike,
    selections: npt.ArrayLike = (),
    *,
    held: npt.ArrayLike = (),
    gap: float = GAP_S,
    least: float = LEAST_S,
    until: float = math.inf,
    split_at_selections: bool = False,
) -> tuple[Episode, ...]:
    """Group the inputs of one robot.

    Args:
        inputs: Times of inputs [s], in any order.
        selections: When the robot was chosen [s]. An episode begins at the latest one that is at
            most `gap` before its first input, and after the episode before.
        held: Begin and end of each time in which a key was down or a stick out of neutral (k, 2)
            [s]. The hands work at both ends, also where the trial or a pause cuts it and no input
            is there.
        gap: A pause longer than this ends an episode [s].
        least: Shortest time from the first input to the end [s].
        until: End of the trial [s]; no episode lasts longer.
        split_at_selections: Whether the choice of the robot between two inputs ends an episode too.
            A return within the pause is then an episode of its own, and not a part of the one
            before.

    Raises:
        DataError: A time is not finite.
    """
    counted = np.sort(_finite(inputs, "inputs"))
    chosen = np.sort(_finite(selections, "selections"))
    spans = _finite(np.ravel(held), "held").reshape(-1, 2)
    times = np.sort(np.concatenate((counted, spans.ravel())))
    if not times.size:
        return ()
    apart = np.diff(times) > gap + _EQUAL
    if split_at_selections:
        apart |= np.diff(np.searchsorted(chosen, times, side="right")) > 0
    pauses = [
        place
        for place in np.flatnonzero(apart).tolist()
        if not ((spans[:, 0] <= times[place]) & (spans[:, 1] >= times[place + 1])).any()
    ]
    made: list[Episode] = []
    for part in np.split(times, np.array(pauses, int) + 1):
        first = float(part[0])
        near = chosen[(chosen <= first) & (chosen >= first - gap - _EQUAL)]
        begin = float(near[-1]) if near.size else first
        if made:
            begin = max(begin, made[-1].end)
        end = min(max(float(part[-1]), first + least), max(until, begin))
        within = np.searchsorted(counted, part[-1], "right") - np.searchsorted(counted, first)
        made.append(Episode(begin=begin, end=end, inputs=int(within)))
    return tuple(made)


def covered(spans: Iterable[tuple[float, float]], begin: float, end: float) -> float:
    """Length of the union of spans within a time [s]; what overlaps counts once.

    Args:
        spans: Begin and end of each [s], in any order.
        begin: Begin of the time [s].
        end: Its end [s].
    """
    total, reached = 0.0, begin
    for first, last in sorted(spans):
        total += max(0.0, min(last, end) - max(first, reached))
        reached = max(reached, min(last, end))
    return total


def _finite(times: npt.ArrayLike, what: str) -> Floats:
    array = floats(times, what)
    if not np.isfinite(array).all():
        text = f"{what}: a time is not finite"
        raise DataError(text)
    return array
